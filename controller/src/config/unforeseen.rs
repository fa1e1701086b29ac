//! Settings for what nobody planned: incidents, delay and noise.

use super::keys::section;

section! {
    /// Delay compensation.
    DelayConfig in delay;
    /// Whole periods between a command and its effect; the state is predicted through the
    /// queued inputs.
    steps "steps": usize, symbol "", unit "", range (0, 20), from preset;
    /// With `steps = 0`: whether delay and lag of the actuators are estimated from the initial laps.
    estimate "estimate": bool, symbol "", unit "", range (), from preset;
}

impl DelayConfig {
    /// Whether delay and lag are estimated.
    pub(crate) fn estimates(&self) -> bool {
        self.estimate && self.steps == 0
    }
}

section! {
    /// What happens after a spin, an excursion, a standstill or a start askew.
    RecoveryConfig in recovery;
    /// Whether the controller drives back to the line by itself. Without it a car that points the
    /// wrong way, or is far off, brakes until its host resets it.
    active "active": bool, symbol "", unit "", range (), from preset;
}

section! {
    /// Estimation of the state in front of the controller.
    FilterConfig in filter;
    /// Whether measurements are filtered.
    active "active": bool, symbol "", unit "", range (), from preset;
    /// Whether the source measures velocities; otherwise those it sends are ignored.
    velocities "velocities": bool, symbol "", unit "", range (), from preset;
    /// Standard deviations of the measurement in state order; 0 is estimated while driving.
    noise "noise": [f64; 6], symbol "", unit "", range (0.0, 1e3), from preset;
    /// What the model may get wrong, as a share of the acceleration that the grip allows.
    model_error "model_error": f64, symbol "", unit "", range (1e-6, 1.0), from preset;
}
