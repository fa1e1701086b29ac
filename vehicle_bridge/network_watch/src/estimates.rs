//! What the controller has found out about road, actuators and sensors, by its telemetry.

use lcm_types::MpcTelemetry;
use serde::Serialize;

/// Index of e_psi in a state.
const E_PSI: usize = 3;
/// Index of e_y in a state.
const E_Y: usize = 5;

/// The controller's action and its estimates in the last step.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Estimates {
    /// What was commanded: `warm_up`, `learned`, `recovering` and so on.
    pub action: String,
    /// Why, where it is not the usual course; else empty.
    pub reason: String,
    /// Whether the car is on its way back to the line after an incident.
    pub recovering: bool,
    /// Factors on front and rear grip of the nominal car. \[-\]
    pub grip: [f32; 2],
    /// Share of the fitted grip that the road has now. \[-\]
    pub road_grip: f32,
    /// Pure delay from a command to its effect. \[s\]
    pub delay_s: f32,
    /// Time constant of the actuators. \[s\]
    pub lag_s: f32,
    /// Whether delay and lag were estimated in the initial laps.
    pub response_found: bool,
    /// Commands act later than the delay by this, below 0 sooner; 0 while no change is clear. \[s\]
    pub delay_change_s: f32,
    /// Standard deviations of the estimated heading \[rad\] and place across the track \[m\]; none while
    /// the measurement passes as it is.
    pub sigma: Option<[f32; 2]>,
    /// Standard deviations of the noise of the measured heading \[rad\] and place across the track \[m\].
    pub noise: Option<[f32; 2]>,
}

impl Estimates {
    /// Those of a step's telemetry.
    #[must_use]
    pub fn of(step: &MpcTelemetry) -> Self {
        let pose = |sigma: &[f32; 6]| step.filtered.then_some([sigma[E_PSI], sigma[E_Y]]);
        Self {
            action: action_name(step.action).to_owned(),
            reason: reason_name(step.reason).to_owned(),
            recovering: step.action == MpcTelemetry::RECOVERING,
            grip: step.grip,
            road_grip: step.road_grip,
            delay_s: step.delay,
            lag_s: step.lag,
            response_found: step.response_found,
            delay_change_s: step.delay_change,
            sigma: pose(&step.state_sigma),
            noise: pose(&step.noise_sigma),
        }
    }
}

/// The name of an action by its code in `LMPC/TELEM`.
#[must_use]
pub fn action_name(action: i8) -> &'static str {
    match action {
        MpcTelemetry::WARM_UP => "warm_up",
        MpcTelemetry::LEARNED => "learned",
        MpcTelemetry::SHIFTED_PLAN => "shifted_plan",
        MpcTelemetry::TRACKING => "tracking",
        MpcTelemetry::BRAKING => "braking",
        MpcTelemetry::RECOVERING => "recovering",
        _ => "unknown",
    }
}

/// The name of a reason by its code in `LMPC/TELEM`; empty for the usual course.
#[must_use]
pub fn reason_name(reason: i8) -> &'static str {
    match reason {
        MpcTelemetry::NORMAL => "",
        MpcTelemetry::SOLVER_FAILED => "solver_failed",
        MpcTelemetry::NON_FINITE => "non_finite",
        MpcTelemetry::TIME_NOT_ADVANCING => "time_not_advancing",
        MpcTelemetry::TIME_GAP => "time_gap",
        MpcTelemetry::JUMP => "jump",
        MpcTelemetry::OFF_TRACK => "off_track",
        MpcTelemetry::WRONG_WAY => "wrong_way",
        MpcTelemetry::STANDSTILL => "standstill",
        MpcTelemetry::NO_SAFE_SET => "no_safe_set",
        MpcTelemetry::SPIN => "spin",
        MpcTelemetry::ASKEW => "askew",
        _ => "unknown",
    }
}
