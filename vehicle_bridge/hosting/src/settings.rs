//! A configuration put together from layers: preset, embedded settings, the user's file, single
//! keys from the command line.

use std::fmt;
use std::path::Path;

use anyhow::{Context as _, Result};
use bounded_file::Limit;
use controller::config::keys::{ConfigKey, ConfigValue, Derivation};
use controller::config::{SECTIONS, overlay};
use controller::{Config, Preset};
use toml::{Table, Value};
use vehicle_model::{CarParams, Track};

/// A command line that cannot be obeyed.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct Usage(pub String);

/// Where the value of a key comes from.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum SettingOrigin {
    /// From the preset.
    Preset(Preset),
    /// From the car, by this rule.
    Car(&'static str),
    /// From car and track, by this rule.
    CarAndTrack(&'static str),
    /// From the file of this name.
    File(String),
    /// From `--set` or another option.
    CommandLine,
}

impl fmt::Display for SettingOrigin {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Preset(preset) => write!(f, "preset {}", preset.word()),
            Self::Car(_) => f.write_str("car"),
            Self::CarAndTrack(_) => f.write_str("car and track"),
            Self::File(name) => f.write_str(name),
            Self::CommandLine => f.write_str("command line"),
        }
    }
}

/// A key, its value in a configuration and where that comes from.
#[derive(Debug, Clone)]
pub struct Setting<'a> {
    /// The key.
    pub key: &'static ConfigKey,
    /// Its value.
    pub value: ConfigValue<'a>,
    /// Where the value comes from.
    pub origin: SettingOrigin,
}

/// Layers of a configuration, the later over the earlier.
#[derive(Debug, Clone, Default)]
pub struct Layers {
    table: Table,
    /// Each layer's own keys, the latest last.
    given: Vec<(SettingOrigin, Table)>,
}

impl Layers {
    /// Lays a file over what there is.
    ///
    /// # Errors
    /// If it cannot be read, or has a key or value that is not allowed.
    pub fn file(&mut self, path: &Path) -> Result<()> {
        let text = bounded_file::text(path, Limit::SETTINGS)?;
        let name = path.display().to_string();
        self.text(&text, SettingOrigin::File(name.clone())).context(name)
    }

    /// Lays TOML over what there is.
    ///
    /// # Errors
    /// If it has a key or value that is not allowed.
    pub fn text(&mut self, text: &str, origin: SettingOrigin) -> Result<()> {
        Config::from_toml(text)?;
        let table: Table = toml::from_str(text)?;
        self.lay(table, origin);
        Ok(())
    }

    fn lay(&mut self, table: Table, origin: SettingOrigin) {
        overlay(&mut self.table, table.clone());
        self.given.push((origin, table));
    }

    /// Lays `section.key=value` over what there is.
    ///
    /// # Errors
    /// [`Usage`] if there is no such key or its value is not allowed.
    pub fn set(&mut self, assignment: &str) -> Result<()> {
        let usage = |why: String| Usage(format!("--set {assignment}: {why}"));
        let (key, value) = assignment
            .split_once('=')
            .ok_or_else(|| usage("expected SECTION.KEY=VALUE".to_owned()))?;
        let (key, value) = (key.trim(), value.trim());
        let text = format!("{key} = {value}");
        let quoted = format!("{key} = {value:?}");
        let text = if toml::from_str::<Table>(&text).is_ok() { text } else { quoted };
        self.text(&text, SettingOrigin::CommandLine).map_err(|e| usage(e.to_string()).into())
    }

    /// Lays the assignments of one command line over what there is, each key once.
    ///
    /// # Errors
    /// [`Usage`] for a key that is given twice, and those of [`Self::set`].
    pub fn set_each(&mut self, assignments: &[String]) -> Result<()> {
        let key = |text: &str| text.split_once('=').map(|(key, _)| key.trim().to_owned());
        for (i, assignment) in assignments.iter().enumerate() {
            let same =
                |earlier: &&String| key(earlier).is_some() && key(earlier) == key(assignment);
            if let Some(earlier) = assignments[..i].iter().find(same) {
                let why = format!("found {earlier} before it; expected each key once");
                return Err(Usage(format!("--set {assignment}: {why}")).into());
            }
            self.set(assignment)?;
        }
        Ok(())
    }

    /// Sets one key of a section.
    pub fn insert(&mut self, section: &str, key: &str, value: impl Into<Value>) {
        let mut inner = Table::new();
        inner.insert(key.to_owned(), value.into());
        let mut outer = Table::new();
        outer.insert(section.to_owned(), Value::Table(inner));
        self.lay(outer, SettingOrigin::CommandLine);
    }

    /// Names the preset below all layers.
    pub fn preset(&mut self, name: &str) {
        self.table.insert("preset".to_owned(), Value::String(name.to_owned()));
    }

    /// The configuration of layers over a preset as it stands, for the paper's studies.
    ///
    /// # Errors
    /// If a value is out of range.
    pub fn build(&self) -> Result<Config> {
        Ok(Config::from_toml(&toml::to_string(&self.table)?)?)
    }

    /// The configuration: what follows from car and track below all layers.
    ///
    /// # Errors
    /// If a value is out of range.
    pub fn build_for(&self, car: &CarParams, track: &Track) -> Result<Config> {
        Ok(Config::from_toml_for(&toml::to_string(&self.table)?, car, track)?)
    }

    /// Every key of the configuration these layers gave for a car on a track, and where its value
    /// comes from.
    #[must_use]
    pub fn explain<'a>(&self, config: &'a Config) -> Vec<Setting<'a>> {
        let keys = SECTIONS.iter().flat_map(|section| section.keys);
        keys.map(|key| Setting { key, value: key.value(config), origin: self.origin(key, config) })
            .collect()
    }

    fn origin(&self, key: &ConfigKey, config: &Config) -> SettingOrigin {
        let has = |table: &Table| {
            table.get(key.section).and_then(|section| section.get(key.name)).is_some()
        };
        let given = self.given.iter().rev().find(|(_, table)| has(table));
        match (given, config.preset, key.derivation) {
            (Some((origin, _)), ..) => origin.clone(),
            (None, Preset::Race, Derivation::Car(rule)) => SettingOrigin::Car(rule),
            (None, Preset::Race, Derivation::CarAndTrack(rule)) => SettingOrigin::CarAndTrack(rule),
            (None, preset, _) => SettingOrigin::Preset(preset),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn later_layers_win_key_by_key() {
        let mut layers = Layers::default();
        layers.preset("paper");
        let file = SettingOrigin::File("race.toml".to_owned());
        layers.text("[horizon]\nsteps = 11\nsubsteps = 7", file.clone()).unwrap();
        layers.set("horizon.steps=9").unwrap();
        layers.set("regression.mode=full").unwrap();
        let config = layers.build().unwrap();
        assert_eq!((config.horizon.steps, config.horizon.substeps), (9, 7));
        assert_eq!(config.regression.mode, controller::config::RegressionMode::Full);
        let below = Config::preset(controller::Preset::Paper);
        assert_eq!(config.safe_set, below.safe_set, "the preset below");
        assert_ne!(config.safe_set, Config::default().safe_set, "which is not the default");

        let origins = |layers: &Layers, name: &str| -> (String, SettingOrigin) {
            let all = layers.explain(&config);
            let one = all.into_iter().find(|setting| setting.key.dotted() == name).unwrap();
            (one.value.to_string(), one.origin)
        };
        let of = |name| origins(&layers, name);
        assert_eq!(of("horizon.steps"), ("9".to_owned(), SettingOrigin::CommandLine));
        assert_eq!(of("horizon.substeps"), ("7".to_owned(), file));
        assert_eq!(of("regression.mode"), ("\"full\"".to_owned(), SettingOrigin::CommandLine));
        assert_eq!(
            of("horizon.period_s"),
            ("0.1".to_owned(), SettingOrigin::Preset(Preset::Paper))
        );
    }

    #[test]
    fn what_is_not_given_follows_from_the_car() {
        let (car, track) = (CarParams::builtin("kart").unwrap(), Track::builtin("l").unwrap());
        let mut layers = Layers::default();
        layers.set("limits.rear_slip_rad=0.05").unwrap();
        let config = layers.build_for(&car, &track).unwrap();
        for setting in layers.explain(&config) {
            let preset = setting.key.value(&Config::default()).to_string();
            match (setting.key.dotted().as_str(), setting.origin) {
                ("limits.rear_slip_rad", origin) => assert_eq!(origin, SettingOrigin::CommandLine),
                ("limits.front_slip_rad", origin) => {
                    assert!(matches!(origin, SettingOrigin::Car(_)))
                }
                ("warm_up.speed_mps", origin) => {
                    assert!(matches!(origin, SettingOrigin::CarAndTrack(_)))
                }
                (name, SettingOrigin::Preset(_)) => {
                    assert_eq!(setting.value.to_string(), preset, "{name}")
                }
                _ => {}
            }
        }
    }

    #[test]
    fn a_command_line_gives_each_key_once() {
        let each = |keys: &[&str]| {
            let keys: Vec<String> = keys.iter().map(ToString::to_string).collect();
            Layers::default()
                .set_each(&keys)
                .map_err(|error| (error.is::<Usage>(), error.to_string()))
        };
        each(&["horizon.steps=11", "horizon.substeps=7"]).unwrap();
        let (usage, text) = each(&["horizon.steps=11", "horizon.steps = 9"]).unwrap_err();
        assert!(usage && text.contains("found horizon.steps=11 before it"), "{text}");
        assert!(text.contains("--set horizon.steps = 9"), "{text}");
    }

    #[test]
    fn a_wrong_key_is_a_usage_error_that_names_the_allowed_ones() {
        let error = Layers::default().set("horizon.stepz=9").unwrap_err();
        assert!(error.is::<Usage>());
        let text = error.to_string();
        assert!(text.contains("stepz") && text.contains("`steps`"), "{text}");
        assert!(Layers::default().set("horizon.steps=1").is_err(), "out of range");
        assert!(Layers::default().set("horizon.steps").is_err(), "no value");
    }
}
