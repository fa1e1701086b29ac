//! Configuration of the controller, as read from TOML, with its limits.
//!
//! Keys are words; the paper's symbol stands in the doc of each. Units end the key where the
//! value has one. Every key has a default: that of the preset named by `preset`, `race` if none
//! is named.

mod check;
mod unforeseen;

use serde::{Deserialize, Serialize};
use vehicle_model::{CarParams, NX, Track};

use crate::error::ConfigError;
use crate::presets::Preset;

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

/// Horizon and sampling.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Horizon {
    /// Number of steps N. Longer horizons learn faster and, from slow laps, less safely. [2, 200]
    pub steps: usize,
    /// Sampling period dt \[s\].
    #[serde(rename = "period_s")]
    pub period: f64,
    /// RK4 sub-steps of the nominal model in one period. [1, 200]
    pub substeps: usize,
}

/// Which laps the safe set takes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Selection {
    /// The P fastest laps (Rosolia); holds lap times better once the limit is reached.
    Fastest,
    /// The P most recent laps (the paper).
    Recent,
}

/// Safe set and cost-to-go (paper, eqs. for SS and Q).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SafeSetConfig {
    /// Samples taken from each lap, K. With the horizon it sets the learning rate. [2, 200]
    pub neighbors: usize,
    /// Laps taken, P. [1, 20]
    pub laps: usize,
    /// Which P laps.
    pub selection: Selection,
}

/// What the regression learns.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum RegressionMode {
    /// The error of the nominal model, x_plus - f(x, u) (the paper's method).
    Error,
    /// The velocity rows themselves, x_plus, without a nominal model (Rosolia).
    Full,
    /// Nothing: the nominal model alone.
    Nominal,
}

/// Which inputs are features of which velocity row.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Features {
    /// v_x from a; v_y and omega_z from delta (the paper).
    Own,
    /// Both inputs in all three rows.
    Both,
}

/// Error dynamics regression: local weighted ridge regression of the velocity rows.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RegressionConfig {
    /// What is learned.
    pub mode: RegressionMode,
    /// Nearest samples used for each point of the horizon, M. [1, 500]
    pub neighbors: usize,
    /// Most recent laps searched for neighbours; 0 searches all.
    pub laps: usize,
    /// Kernel bandwidth h; compared with the squared metric distance u.
    pub bandwidth: f64,
    /// Ridge weight eps.
    pub ridge: f64,
    /// Diagonal of Q, the metric on (v_x, v_y, omega_z, a, delta): u = (z - z_bar)' Q (z - z_bar).
    pub metric: [f64; 5],
    /// Input features of each row.
    pub features: Features,
}

/// Nominal vehicle model of the controller.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum NominalModel {
    /// Dynamic bicycle with the car's tyres.
    Dynamic,
    /// Kinematic bicycle.
    Kinematic,
}

/// Nominal model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct NominalConfig {
    /// Which equations.
    pub model: NominalModel,
    /// Whether front and rear grip are fitted by least squares after each lap.
    pub adapt_grip: bool,
    /// Length of the secants that stand for tangents of the tyre curves near their peaks, as a
    /// share of the peak slip; 0: tangents. [0, 0.4]
    pub secant: f64,
}

/// Weights of the optimal control problem.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct CostConfig {
    /// Weight c_u of the squared steering angle, in steps [1/rad^2].
    pub input: f64,
    /// Weight c_u of the squared acceleration, in steps [s^4/m^2].
    pub input_acceleration: f64,
    /// Weight c_du ("CRC") of the squared rates of the input per second.
    pub control_rate: f64,
    /// Factor of the acceleration rate within `control_rate`, w_a.
    pub acceleration_rate: f64,
    /// Factor of the steering rate within `control_rate`, w_delta.
    pub steering_rate: f64,
    /// Least product of `control_rate` and `steering_rate`: below it the car weaves.
    pub steering_rate_floor: f64,
    /// Gentle start: factor of the acceleration rate in the first learned lap, halved each lap
    /// until `acceleration_rate` is reached. 0 switches it off.
    pub gentle_start: f64,
    /// Factor of the curvature of tyre dissipation; 1 is that of the equations, 0 switches it off.
    pub dissipation: f64,
    /// Quadratic weights of the terminal slack in state order.
    pub terminal_slack: [f64; NX],
    /// Linear weight of the lane slack of each stage [1/m].
    pub lane_linear: f64,
    /// Quadratic weight of the lane slack of each stage [1/m^2].
    pub lane_quadratic: f64,
    /// Linear weight of the slip-guard slacks [1/rad].
    pub slip: f64,
    /// Linear weight of the speed-cap slack [s/m].
    pub speed: f64,
}

/// Speed envelope: how fast a plan may be at each place of the track.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct EnvelopeConfig {
    /// Whether there is one.
    pub active: bool,
    /// Share of the known grip up to which speed may grow in one lap. (0, 2]
    pub grip_share: f64,
    /// Growth from lap to lap that is always allowed, as a share of the driven speed. [0, 1]
    pub growth_least: f64,
    /// Greatest growth from lap to lap, as a share of the driven speed. [0, 10]
    pub growth_most: f64,
    /// Share of the brakes that slowing down for what comes may use. (0, 1]
    pub brake_share: f64,
}

/// Constraints beside the input box.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct LimitsConfig {
    /// Distance the centre of gravity of a car parallel to the track keeps from either edge \[m\].
    #[serde(rename = "lane_margin_m")]
    pub lane_margin: f64,
    /// Whether the outline of the body keeps what `lane_margin` leaves beside half its width.
    pub body: bool,
    /// Guard on the front slip angle |alpha_f|; 0 switches it off \[rad\].
    #[serde(rename = "front_slip_rad")]
    pub front_slip: f64,
    /// Guard on the rear slip angle |alpha_r|; 0 switches it off \[rad\].
    #[serde(rename = "rear_slip_rad")]
    pub rear_slip: f64,
    /// Whether a braking car has only that share of the rear guard that is left of the rear load.
    pub rear_load: bool,
    /// Speed cap; 0 switches it off [m/s].
    #[serde(rename = "speed_cap_mps")]
    pub speed_cap: f64,
}

/// Initial laps by centre-line tracking.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct WarmUpConfig {
    /// Number of initial laps. [1, 1000]
    pub laps: usize,
    /// Their speed [m/s].
    #[serde(rename = "speed_mps")]
    pub speed: f64,
    /// Standard deviation of the noise on the acceleration: without excitation nothing can be
    /// regressed [m/s^2].
    #[serde(rename = "noise_a_mps2")]
    pub noise_a: f64,
    /// Standard deviation of the noise on the steering angle \[rad\].
    #[serde(rename = "noise_delta_rad")]
    pub noise_delta: f64,
    /// Seed of that noise.
    pub seed: u64,
}

/// Which method solves the QP.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SolverMethod {
    /// The structured interior-point method; with `fallback`, Clarabel takes what it misses.
    Structured,
    /// Clarabel alone.
    Clarabel,
}

/// QP solver.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SolverConfig {
    /// Which method.
    pub method: SolverMethod,
    /// Whether Clarabel takes over, within the same step, what the structured method does not
    /// solve to tolerance. Without it such a step drives the shifted plan, sooner.
    pub fallback: bool,
    /// Tolerance of gap and feasibility.
    pub tolerance: f64,
    /// Most iterations of one solve.
    pub max_iterations: u32,
}

/// A key whose value is not allowed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Problem {
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
        let base = toml::Table::try_from(base).map_err(ConfigError::merge)?;
        let user: toml::Table = toml::from_str(text).map_err(ConfigError::syntax)?;
        let config: Self = merge(base, user).try_into().map_err(ConfigError::syntax)?;
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

/// `user` laid over `base`, table by table.
fn merge(mut base: toml::Table, user: toml::Table) -> toml::Table {
    for (key, value) in user {
        match (base.remove(&key), value) {
            (Some(toml::Value::Table(below)), toml::Value::Table(above)) => {
                base.insert(key, toml::Value::Table(merge(below, above)));
            }
            (_, value) => {
                base.insert(key, value);
            }
        }
    }
    base
}
