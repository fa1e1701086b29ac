//! What the car does against what was sent to it. The yaw rate has to follow none of a bank of
//! hypotheses about the grip before the steering is doubted: sliding is no fault of an actuator.

use vehicle_model::{Input, State};

use super::super::rules::Rules;
use super::{DoubtLimits, Finding, Suspicion};

/// Shares of the grip that a car may have without a fault. \[-\]
pub(crate) const GRIPS: [f64; 3] = [1.0, 0.7, 0.45];
/// The models are drawn to the measured velocities with this time constant. \[s\]
const FOLLOW: f64 = 0.15;
/// Longest step of the models. \[s\]
const STEP: f64 = 0.005;
/// Below this speed the yaw rate tells nothing of the steering. \[m/s\]
const SLOW: f64 = 0.7;
/// A gap this long begins anew. \[s\]
const GAP: f64 = 0.5;
/// Highest sum: what is over is soon forgotten. \[-\]
const MOST: f64 = 1.5;

/// Models of the car, one for each hypothesis, and the sums of their disagreements.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Response {
    models: Option<[State; GRIPS.len()]>,
    /// The input as the actuators have it by now.
    input: Input,
    drive: f64,
    steering: f64,
}

impl Response {
    pub(super) fn on_state(
        &mut self,
        rules: &Rules,
        limits: &DoubtLimits,
        x: &State,
        sent: Input,
        dt: f64,
    ) -> Finding {
        let car = &rules.rolling.params;
        let slow = car.actuator_lag + car.actuator_delay;
        let share = if slow > 0.0 { 1.0 - (-dt / slow).exp() } else { 1.0 };
        self.input.a += share * (sent.a - self.input.a);
        self.input.delta += share * (sent.delta - self.input.delta);
        let Some(mut models) = self.models.filter(|_| dt < GAP) else {
            *self = Self { models: Some([*x; GRIPS.len()]), input: sent, ..Self::default() };
            return Finding::default();
        };
        let mut steering = f64::INFINITY;
        let mut drive = f64::INFINITY;
        let gain = 1.0 - (-dt / FOLLOW).exp();
        let wheelbase = car.wheelbase();
        let allowed = limits.yaw_rate + limits.steer * x.v_x.max(0.0) / wheelbase;
        for (model, sliding) in models.iter_mut().zip(&rules.sliding) {
            *model = super::super::stop::roll(rules, sliding, model, self.input, (dt, STEP), 0.0);
            let (v, v_y, omega) = (x.v_x - model.v_x, x.v_y - model.v_y, x.omega_z - model.omega_z);
            steering = steering.min(omega.abs() / allowed);
            drive = drive.min(v.abs() / (FOLLOW * limits.accel));
            model.v_x += gain * v;
            model.v_y += gain * v_y;
            model.omega_z += gain * omega;
        }
        self.models = Some(models);
        let add = |sum: f64, ratio: f64| {
            (sum + (ratio.min(10.0) - 1.0) * dt / limits.patience).clamp(0.0, MOST)
        };
        self.drive = add(self.drive, drive);
        self.steering = if x.v_x > SLOW { add(self.steering, steering) } else { 0.0 };
        Finding { what: Suspicion::Drive, level: self.drive }
            .or(Finding { what: Suspicion::Steering, level: self.steering })
    }
}
