//! The table of all keys: name, symbol, unit, range, where the value comes from, meaning.
//!
//! [`SECTIONS`](super::SECTIONS) is the table.
//! The macro `section!` makes the struct of a section and its rows of this table from one text.
//! Range checks, the reference page, the schema for editors and `lmpc config` read the table.

use std::fmt;

use super::Config;

/// A section of a configuration file.
#[derive(Debug, Clone, Copy)]
pub struct Section {
    /// Name, as in the TOML file.
    pub name: &'static str,
    about: &'static str,
    /// Its keys, in the order of the struct.
    pub keys: &'static [ConfigKey],
}

impl Section {
    pub(super) const fn new(
        name: &'static str,
        about: &'static str,
        keys: &'static [ConfigKey],
    ) -> Self {
        Self { name, about, keys }
    }

    /// What the section is for.
    #[must_use]
    pub fn about(&self) -> &'static str {
        self.about.trim_start()
    }
}

/// A key of a configuration file.
#[derive(Debug, Clone, Copy)]
pub struct ConfigKey {
    /// Section it stands in.
    pub section: &'static str,
    /// Name within the section.
    pub name: &'static str,
    /// Symbol in the paper; empty if the paper gives it no symbol.
    pub symbol: &'static str,
    /// Unit; empty for words, switches, counts and numbers without one.
    pub unit: &'static str,
    /// What the value is.
    pub kind: ValueKind,
    /// Least and greatest allowed value, or entry of an array.
    pub range: Option<[f64; 2]>,
    /// Where the value comes from unless it is given.
    pub derivation: Derivation,
    pub(super) meaning: &'static str,
    pub(super) value: fn(&Config) -> ConfigValue<'_>,
}

impl ConfigKey {
    /// What the value does.
    #[must_use]
    pub fn meaning(&self) -> &'static str {
        self.meaning.trim_start()
    }

    /// The value in a configuration.
    #[must_use]
    pub fn value<'a>(&self, config: &'a Config) -> ConfigValue<'a> {
        (self.value)(config)
    }

    /// Section and name, as after `--set`.
    #[must_use]
    pub fn dotted(&self) -> String {
        format!("{}.{}", self.section, self.name)
    }
}

/// Where the value of a key comes from in the preset `race`, unless it is given. In the preset
/// `paper` every value is that of the preset.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Derivation {
    /// From the preset, whatever the car.
    Preset,
    /// From the car, by this rule.
    Car(&'static str),
    /// From car and track, by this rule.
    CarAndTrack(&'static str),
}

/// Words a key may have, with their meaning.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Choice {
    /// The word.
    pub word: &'static str,
    pub(crate) meaning: &'static str,
}

impl Choice {
    /// What the word means.
    #[must_use]
    pub fn meaning(&self) -> &'static str {
        self.meaning.trim_start()
    }
}

/// What the value of a key is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ValueKind {
    /// A whole number.
    Count,
    /// A number.
    Number,
    /// `true` or `false`.
    Switch,
    /// One of these words.
    Choice(&'static [Choice]),
    /// Numbers, one for each of these quantities.
    Numbers(&'static [&'static str]),
}

/// The value of a key.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ConfigValue<'a> {
    /// A whole number.
    Count(u64),
    /// A number.
    Number(f64),
    /// `true` or `false`.
    Switch(bool),
    /// A word.
    Word(&'static str),
    /// Numbers.
    Numbers(&'a [f64]),
}

/// As in a TOML file; a precision is the number of significant digits.
impl fmt::Display for ConfigValue<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Count(value) => write!(f, "{value}"),
            Self::Switch(value) => write!(f, "{value}"),
            Self::Word(word) => write!(f, "\"{word}\""),
            Self::Number(value) => number(*value, f),
            Self::Numbers(values) => {
                f.write_str("[")?;
                for (i, value) in values.iter().enumerate() {
                    f.write_str(if i == 0 { "" } else { ", " })?;
                    number(*value, f)?;
                }
                f.write_str("]")
            }
        }
    }
}

fn number(value: f64, f: &mut fmt::Formatter<'_>) -> fmt::Result {
    let Some(digits) = f.precision() else { return write!(f, "{value:?}") };
    let rounded = format!("{value:.*e}", digits.saturating_sub(1)).parse().unwrap_or(value);
    let text = format!("{rounded:?}");
    f.write_str(text.strip_suffix(".0").unwrap_or(&text))
}

/// A type that a key can have.
pub(crate) trait Setting {
    const KIND: ValueKind;
    fn value(&self) -> ConfigValue<'_>;
}

macro_rules! setting {
    ($($type:ty, $kind:expr, $value:expr;)*) => {$(
        impl Setting for $type {
            const KIND: ValueKind = $kind;
            fn value(&self) -> ConfigValue<'_> {
                let value: fn(&Self) -> ConfigValue<'_> = $value;
                value(self)
            }
        }
    )*};
}

/// Entries of the metric: velocities and inputs.
const METRIC: &[&str] = &["v_x", "v_y", "omega_z", "a", "delta"];
/// Entries in state order.
const STATE: &[&str] = &["v_x", "v_y", "omega_z", "e_psi", "s", "e_y"];

setting! {
    usize, ValueKind::Count, |v| ConfigValue::Count(*v as u64);
    u32, ValueKind::Count, |v| ConfigValue::Count(u64::from(*v));
    u64, ValueKind::Count, |v| ConfigValue::Count(*v);
    f64, ValueKind::Number, |v| ConfigValue::Number(*v);
    bool, ValueKind::Switch, |v| ConfigValue::Switch(*v);
    [f64; 5], ValueKind::Numbers(METRIC), |v| ConfigValue::Numbers(v);
    [f64; 6], ValueKind::Numbers(STATE), |v| ConfigValue::Numbers(v);
}

/// Makes a section of the configuration: its struct and the rows of the table of keys.
///
/// A field: documentation, name, name of the key, type, symbol of the paper, unit, least and
/// greatest value, where the value comes from.
macro_rules! section {
    (
        $(#[doc = $about:literal])*
        $name:ident in $section:ident;
        $(
            $(#[doc = $doc:literal])*
            $field:ident $key:literal: $type:ty,
            symbol $symbol:tt, unit $unit:tt, range ($($least:literal, $most:literal)?),
            from $from:ident $($rule:literal)?;
        )*
    ) => {
        $(#[doc = $about])*
        #[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
        #[serde(deny_unknown_fields, default)]
        pub struct $name {
            $(
                $(#[doc = $doc])*
                #[doc = ""]
                #[doc = concat!(
                    "Key `", stringify!($section), ".", $key, "`",
                    $crate::config::keys::symbol_doc!($symbol)
                    $(, ", ", $least, " to ", $most)?,
                    $crate::config::keys::unit_doc!($unit)
                )]
                #[serde(rename = $key)]
                pub $field: $type,
            )*
        }

        impl $name {
            pub(in crate::config) const SECTION: $crate::config::keys::Section =
                $crate::config::keys::Section::new(
                    stringify!($section),
                    concat!($($about),*),
                    &[$($crate::config::keys::ConfigKey {
                        section: stringify!($section),
                        name: $key,
                        symbol: $symbol,
                        unit: $unit,
                        kind: <$type as $crate::config::keys::Setting>::KIND,
                        range: $crate::config::keys::range!($($least, $most)?),
                        derivation: $crate::config::keys::derivation!($from $($rule)?),
                        meaning: concat!($($doc),*),
                        value: |config| $crate::config::keys::Setting::value(&config.$section.$field),
                    }),*],
                );
        }
    };
}

/// Makes an enum whose variants are the words a key may have, and perhaps its default.
macro_rules! choice {
    (
        $(#[doc = $about:literal])*
        $name:ident $(default $default:ident)?;
        $($(#[doc = $doc:literal])* $variant:ident $word:literal;)*
    ) => {
        $(#[doc = $about])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
        pub enum $name {
            $($(#[doc = $doc])* #[serde(rename = $word)] $variant,)*
        }

        $(impl Default for $name {
            fn default() -> Self {
                Self::$default
            }
        })?

        impl $name {
            /// The words, with their meaning.
            pub const CHOICES: &[$crate::config::keys::Choice] = &[
                $($crate::config::keys::Choice { word: $word, meaning: concat!($($doc),*) }),*
            ];

            /// The word, as in a configuration file.
            #[must_use]
            pub const fn word(self) -> &'static str {
                match self { $(Self::$variant => $word,)* }
            }
        }

        impl $crate::config::keys::Setting for $name {
            const KIND: $crate::config::keys::ValueKind = $crate::config::keys::ValueKind::Choice(Self::CHOICES);
            fn value(&self) -> $crate::config::keys::ConfigValue<'_> {
                $crate::config::keys::ConfigValue::Word(self.word())
            }
        }
    };
}

macro_rules! symbol_doc {
    ("") => {
        ""
    };
    ($symbol:tt) => {
        concat!(", symbol ", $symbol)
    };
}

macro_rules! unit_doc {
    ("") => {
        "."
    };
    ($unit:tt) => {
        concat!(" \\[", $unit, "\\].")
    };
}

macro_rules! range {
    () => {
        None
    };
    ($least:literal, $most:literal) => {
        Some([$least as f64, $most as f64])
    };
}

macro_rules! derivation {
    (preset) => {
        $crate::config::keys::Derivation::Preset
    };
    (car $rule:literal) => {
        $crate::config::keys::Derivation::Car($rule)
    };
    (car_and_track $rule:literal) => {
        $crate::config::keys::Derivation::CarAndTrack($rule)
    };
}

pub(crate) use {choice, derivation, range, section, symbol_doc, unit_doc};
