//! What an axis may vary.

use anyhow::{Result, bail};
use toml::{Table, Value};

/// A key of a run.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Key {
    /// Name or file of the car.
    Car,
    /// Name or file of the track, or `random-SEED`.
    Track,
    /// Preset of the settings.
    Preset,
    /// Changes of the simulated car as on the command line.
    Plant,
    /// Grip the controller believes in.
    NominalMu,
    /// Learned laps to drive.
    Laps,
    /// Whether the whole body has to stay inside.
    Body,
    /// A key of the configuration, `SECTION.KEY`.
    Config(String),
    /// A key of the car file.
    OfCar(String),
    /// A key of the track file.
    OfTrack(String),
    /// A name of `--plant`.
    OfPlant(String),
}

impl Key {
    /// The key of this name.
    pub(super) fn parse(name: &str) -> Result<Self> {
        let part = name.split_once('.').map(|(head, rest)| (head, rest.to_owned()));
        Ok(match (name, part) {
            ("car", _) => Self::Car,
            ("track", _) => Self::Track,
            ("preset", _) => Self::Preset,
            ("plant", _) => Self::Plant,
            ("nominal_mu", _) => Self::NominalMu,
            ("laps", _) => Self::Laps,
            ("body", _) => Self::Body,
            (_, Some(("config", rest))) => Self::Config(rest),
            (_, Some(("car", rest))) => Self::OfCar(rest),
            (_, Some(("track", rest))) => Self::OfTrack(rest),
            (_, Some(("plant", rest))) => Self::OfPlant(rest),
            _ => bail!(
                "unknown key `{name}`, expected car, track, preset, plant, nominal_mu, laps, body, or \
                 one that begins with `config.`, `car.`, `track.` or `plant.`"
            ),
        })
    }
}

/// The keys of nested tables by their dotted names, in their order.
pub(super) fn flatten(table: &Table) -> Vec<(String, Value)> {
    let mut all = Vec::new();
    for (name, value) in table {
        match value {
            Value::Table(inner) => {
                let below = flatten(inner).into_iter();
                all.extend(below.map(|(rest, value)| (format!("{name}.{rest}"), value)));
            }
            value => all.push((name.clone(), value.clone())),
        }
    }
    all
}

/// A value as in a table of runs: words without quotation marks.
pub(super) fn text(value: &Value) -> String {
    match value {
        Value::String(word) => word.clone(),
        Value::Float(number) => number.to_string(),
        other => other.to_string(),
    }
}

/// Whether two values are the same, a whole number being the float of its value.
pub(super) fn same(a: &Value, b: &Value) -> bool {
    match (number(a), number(b)) {
        (Some(a), Some(b)) => a.to_bits() == b.to_bits(),
        _ => a == b,
    }
}

/// A value as a number.
pub(super) fn number(value: &Value) -> Option<f64> {
    match value {
        Value::Integer(whole) => Some(*whole as f64),
        Value::Float(number) => Some(*number),
        _ => None,
    }
}
