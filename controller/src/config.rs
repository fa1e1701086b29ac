//! Configuration of the controller, as read from TOML, with its limits.
//!
//! Keys are words; the paper's symbol stands in the doc of each. Units end the key where the
//! value has one. Every key has a default: that of the preset named by `preset`, `race` if none
//! is named.

mod check;
mod driving;
pub mod keys;
mod sections;
mod unforeseen;

use serde::{Deserialize, Serialize};
use vehicle_model::{CarParams, Track};

use crate::error::ConfigError;
use crate::presets::Preset;
use keys::Section;

pub use driving::{CostConfig, EnvelopeConfig, LimitsConfig};
pub use sections::{
    CostToGo, Features, Horizon, NominalConfig, NominalModel, RegressionConfig, RegressionMode,
    SafeSetConfig, Selection, SolverConfig, SolverMethod, WarmUpConfig,
};
pub use unforeseen::{DelayConfig, FilterConfig, RecoveryConfig};

/// Everything a study varies about the controller.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Config {
    /// The set of defaults the other keys override.
    pub preset: Preset,
    /// Horizon and sampling.
    pub horizon: Horizon,
    /// Safe set and cost-to-go.
    pub safe_set: SafeSetConfig,
    /// Error dynamics regression.
    pub regression: RegressionConfig,
    /// Nominal model.
    pub nominal: NominalConfig,
    /// Weights of the optimal control problem.
    pub cost: CostConfig,
    /// Speed envelope along the track.
    pub envelope: EnvelopeConfig,
    /// Constraints beside the input box, which belongs to the car.
    pub limits: LimitsConfig,
    /// The initial laps.
    pub warm_up: WarmUpConfig,
    /// Delay compensation.
    pub delay: DelayConfig,
    /// State estimation.
    pub filter: FilterConfig,
    /// Incidents.
    pub recovery: RecoveryConfig,
    /// QP solver.
    pub solver: SolverConfig,
}

/// All sections, in the order of [`Config`].
pub const SECTIONS: &[Section] = &[
    Horizon::SECTION,
    SafeSetConfig::SECTION,
    RegressionConfig::SECTION,
    NominalConfig::SECTION,
    CostConfig::SECTION,
    EnvelopeConfig::SECTION,
    LimitsConfig::SECTION,
    WarmUpConfig::SECTION,
    DelayConfig::SECTION,
    FilterConfig::SECTION,
    RecoveryConfig::SECTION,
    SolverConfig::SECTION,
];

/// A key whose value is not allowed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ConfigProblem {
    /// Dotted key, as in the TOML file.
    pub key: String,
    /// What was found and what is allowed.
    pub message: String,
}

impl Config {
    /// Reads a configuration: the preset it names, overridden by its keys.
    ///
    /// # Errors
    /// [`ConfigError::Syntax`] for text that is no TOML or has unknown keys or wrong types,
    /// [`ConfigError::Values`] with every value out of range.
    pub fn from_toml(text: &str) -> Result<Self, ConfigError> {
        // Read directly first: only this error knows lines and columns.
        let direct: Self = toml::from_str(text).map_err(ConfigError::syntax)?;
        Self::over(&Self::preset(direct.preset), text)
    }

    /// What follows from a car and a track, overridden by the keys of the text.
    ///
    /// # Errors
    /// As [`Config::from_toml`].
    pub fn from_toml_for(text: &str, car: &CarParams, track: &Track) -> Result<Self, ConfigError> {
        let direct: Self = toml::from_str(text).map_err(ConfigError::syntax)?;
        Self::over(&Self::derived(direct.preset, car, track), text)
    }

    fn over(base: &Self, text: &str) -> Result<Self, ConfigError> {
        let mut table = toml::Table::try_from(base).map_err(ConfigError::merge)?;
        overlay(&mut table, toml::from_str(text).map_err(ConfigError::syntax)?);
        let config: Self = table.try_into().map_err(ConfigError::syntax)?;
        config.checked()
    }

    /// What two configurations must agree in to be the same for learned data and for both ends of a
    /// network: all but the seed of the warm-up laps, as another seed is another trial of the same,
    /// and the leave to drive back by itself, which changes nothing that is learned.
    #[must_use]
    pub fn identity(&self) -> Self {
        let mut config = self.clone();
        config.warm_up.seed = 0;
        config.recovery.active = false;
        config
    }

    /// The configuration itself, if every value is allowed.
    ///
    /// # Errors
    /// [`ConfigError::Values`] with every value out of range.
    pub fn checked(self) -> Result<Self, ConfigError> {
        let problems = self.problems();
        if problems.is_empty() { Ok(self) } else { Err(ConfigError::Values(problems)) }
    }
}

/// Lays `above` over `base`, table by table.
pub fn overlay(base: &mut toml::Table, above: toml::Table) {
    for (key, value) in above {
        match (base.get_mut(&key), value) {
            (Some(toml::Value::Table(below)), toml::Value::Table(above)) => overlay(below, above),
            (_, value) => {
                base.insert(key, value);
            }
        }
    }
}
