//! Named sets of settings: `paper` for reproduction, `race` for speed.

use crate::config::keys::choice;
use crate::config::{
    Config, CostConfig, CostToGo, DelayConfig, EnvelopeConfig, Features, FilterConfig, Horizon,
    LimitsConfig, NominalConfig, NominalModel, RecoveryConfig, RegressionConfig, RegressionMode,
    SafeSetConfig, Selection, SolverConfig, SolverMethod, WarmUpConfig,
};

choice! {
    /// A named set of settings.
    Preset default Race;
    /// As close to the paper as is known.
    Paper "paper";
    /// Our best: slip guards front and rear, acceleration rate nearly free after a gentle start,
    /// grip fitted by least squares.
    Race "race";
}

impl Config {
    /// The settings of a preset.
    #[must_use]
    pub fn preset(preset: Preset) -> Self {
        match preset {
            Preset::Paper => Self::paper(),
            Preset::Race => Self::race(),
        }
    }

    fn paper() -> Self {
        Self {
            preset: Preset::Paper,
            horizon: Horizon { steps: 13, period: 0.1, substeps: 10 },
            safe_set: SafeSetConfig {
                neighbors: 10,
                laps: 3,
                selection: Selection::Recent,
                cost_to_go: CostToGo::Line,
            },
            regression: RegressionConfig {
                mode: RegressionMode::Error,
                neighbors: 40,
                laps: 4,
                bandwidth: 5.0,
                ridge: 1e-3,
                metric: [5.0, 5.0, 1.0, 1.0, 5.0],
                features: Features::Own,
            },
            nominal: NominalConfig {
                model: NominalModel::Dynamic,
                adapt_grip: false,
                secant: 0.0,
                inverse_tyre: false,
            },
            cost: CostConfig {
                input: 1e-3,
                input_acceleration: 1e-3,
                control_rate: 0.1,
                acceleration_rate: 1.0,
                steering_rate: 1.0,
                steering_rate_floor: 0.0,
                gentle_start: 0.0,
                dissipation: 0.0,
                terminal_slack: [40.0, 4.0, 4.0, 40.0, 40.0, 40.0],
                lane_linear: 25.0,
                lane_quadratic: 100.0,
                slip: 1000.0,
                speed: 25.0,
            },
            envelope: EnvelopeConfig {
                active: false,
                grip_share: 1.0,
                growth_least: 0.05,
                growth_most: 0.5,
                brake_share: 1.0,
            },
            limits: LimitsConfig {
                lane_margin: 0.1,
                body: false,
                front_slip: 0.11,
                rear_slip: 0.09,
                steering_reserve: 0.0,
                brake_reserve: 0.0,
                slip_reserve: 0.0,
                rear_load: false,
                uncertainty: 0.0,
                speed_cap: 0.0,
            },
            warm_up: WarmUpConfig { laps: 4, speed: 1.2, noise_a: 0.1, noise_delta: 0.02, seed: 0 },
            delay: DelayConfig { steps: 0, estimate: false },
            filter: FilterConfig {
                active: false,
                velocities: true,
                noise: [0.0; 6],
                model_error: 0.02,
            },
            recovery: RecoveryConfig { active: false },
            solver: SolverConfig {
                method: SolverMethod::Structured,
                fallback: true,
                tolerance: 1e-8,
                max_iterations: 60,
            },
        }
    }

    fn race() -> Self {
        let paper = Self::paper();
        Self {
            preset: Preset::Race,
            horizon: Horizon { steps: 15, ..paper.horizon },
            safe_set: SafeSetConfig {
                selection: Selection::Fastest,
                cost_to_go: CostToGo::Round,
                ..paper.safe_set
            },
            regression: RegressionConfig {
                neighbors: 40,
                metric: [2.0, 2.0, 1.0, 1.0, 2.0],
                features: Features::Both,
                ..paper.regression
            },
            nominal: NominalConfig { adapt_grip: true, inverse_tyre: true, ..paper.nominal },
            cost: CostConfig {
                acceleration_rate: 3e-4,
                steering_rate_floor: 0.05,
                gentle_start: 1.0,
                dissipation: 2.0,
                lane_linear: 100.0,
                slip: 20.0,
                ..paper.cost
            },
            envelope: EnvelopeConfig { active: true, ..paper.envelope },
            delay: DelayConfig { estimate: true, ..paper.delay },
            filter: FilterConfig { active: true, ..paper.filter },
            recovery: RecoveryConfig { active: true },
            limits: LimitsConfig {
                body: true,
                front_slip: 0.165,
                rear_slip: 0.14,
                steering_reserve: 0.05,
                brake_reserve: 0.05,
                slip_reserve: 0.12,
                rear_load: true,
                uncertainty: 2.5,
                ..paper.limits
            },
            ..paper
        }
    }
}

macro_rules! default_of_race {
    ($($section:ident: $type:ty),* $(,)?) => {$(
        impl Default for $type {
            fn default() -> Self {
                Config::default().$section
            }
        }
    )*};
}

impl Default for Config {
    fn default() -> Self {
        Self::race()
    }
}

default_of_race! {
    horizon: Horizon,
    safe_set: SafeSetConfig,
    regression: RegressionConfig,
    nominal: NominalConfig,
    cost: CostConfig,
    envelope: EnvelopeConfig,
    limits: LimitsConfig,
    warm_up: WarmUpConfig,
    delay: DelayConfig,
    filter: FilterConfig,
    recovery: RecoveryConfig,
    solver: SolverConfig,
}
