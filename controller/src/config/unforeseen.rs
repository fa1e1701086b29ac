//! Settings for what nobody planned: incidents and delay.

use serde::{Deserialize, Serialize};
use vehicle_model::NX;

use super::check::Check;

/// Delay compensation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct DelayConfig {
    /// Whole periods between a command and its effect; the state is predicted through the
    /// queued inputs. [0, 20]
    pub steps: usize,
    /// With `steps = 0`: whether the initial laps tell how many periods it takes.
    pub estimate: bool,
}

/// What happens after a spin, an excursion, a standstill or a start askew.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RecoveryConfig {
    /// Whether the controller drives back to the line by itself. Without it a car that points the
    /// wrong way, or is far off, brakes until its host resets it.
    pub active: bool,
}

/// Estimation of the state in front of the controller.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct FilterConfig {
    /// Whether measurements are filtered.
    pub active: bool,
    /// Whether the source measures velocities; otherwise those it sends are ignored.
    pub velocities: bool,
    /// Standard deviations of the measurement in state order; 0 is estimated while driving.
    pub noise: [f64; NX],
    /// What the model may get wrong, as a share of the acceleration that the grip allows. [0, 1]
    pub model_error: f64,
}

impl FilterConfig {
    pub(super) fn check(&self, check: &mut Check) {
        check.range("filter.model_error", self.model_error, 1e-6, 1.0);
        for noise in self.noise {
            check.range("filter.noise", noise, 0.0, 1e3);
        }
    }
}
