//! What the car does against what was sent to it. The yaw rate has to follow none of a bank of
//! hypotheses about grip and lag before the steering is doubted: sliding is no fault of an actuator.

use vehicle_model::{Input, State};

use super::super::rules::Rules;
use super::super::stop;
use super::{DoubtFinding, DoubtLimits, Suspicion};

/// Shares of the grip that a car may have without a fault. \[-\]
pub(crate) const GRIPS: [f64; 3] = [1.0, 0.7, 0.45];
/// Lags that the actuators may have beyond what the car's file says. \[s\]
pub(super) const LAGS: [f64; 3] = [0.0, 0.06, 0.15];
/// The models are drawn to the measured velocities with this time constant. \[s\]
const FOLLOW: f64 = 0.15;
/// Longest step of the models. \[s\]
const STEP: f64 = 0.005;
/// Lateral acceleration is taken over this time. \[s\]
const SMOOTH: f64 = 0.08;
/// What the tyres held is forgotten with this time constant. \[s\]
const REMEMBER: f64 = 10.0;
/// Tyres that held this share of what a grip can give have more. \[-\]
const HELD: f64 = 1.1;
/// Below this speed the yaw rate tells nothing of the steering. \[m/s\]
const SLOW: f64 = 0.7;
/// A gap this long begins anew. \[s\]
const GAP: f64 = 0.5;
/// Highest sum: what is over is soon forgotten. \[-\]
const MOST: f64 = 1.5;

/// Models of the car, one for each hypothesis, and the sums of their disagreements.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct ResponseModels {
    models: Option<[[State; LAGS.len()]; GRIPS.len()]>,
    /// The input as the actuators have it by now.
    input: Input,
    /// The same behind each lag.
    lagged: [Input; LAGS.len()],
    /// Lateral acceleration the tyres have held, slowly forgotten. \[m/s^2\]
    held: f64,
    lateral: f64,
    drive: f64,
    steering: f64,
}

impl ResponseModels {
    /// The input as the actuators have it.
    pub(super) fn acting(&self) -> Input {
        self.input
    }

    /// The input behind each lag.
    pub(super) fn lagged(&self) -> &[Input; LAGS.len()] {
        &self.lagged
    }

    /// Whether the car may have this share of its grip: not if its tyres just held more.
    pub(super) fn may_have(&self, rules: &Rules, grip: f64) -> bool {
        let car = &rules.rolling.params;
        let most = grip * 9.81 * car.tyre_front.mu.max(car.tyre_rear.mu);
        grip >= 1.0 || self.held < HELD * most
    }

    /// The actuators follow what was sent.
    pub(super) fn follow(&mut self, rules: &Rules, sent: Input, dt: f64) {
        let towards = |from: &mut Input, to: Input, lag: f64| {
            let share = if lag > 0.0 { 1.0 - (-dt / lag).exp() } else { 1.0 };
            from.a += share * (to.a - from.a);
            from.delta += share * (to.delta - from.delta);
        };
        self.input = stop::follow(rules, self.input, sent, dt);
        for (lagged, lag) in self.lagged.iter_mut().zip(LAGS) {
            towards(lagged, self.input, lag);
        }
    }

    pub(super) fn on_state(
        &mut self,
        rules: &Rules,
        limits: &DoubtLimits,
        x: &State,
        sent: Input,
        dt: f64,
    ) -> DoubtFinding {
        let car = &rules.rolling.params;
        self.follow(rules, sent, dt);
        let Some(mut models) = self.models.filter(|_| dt < GAP) else {
            let (models, lagged) = ([[*x; LAGS.len()]; GRIPS.len()], [sent; LAGS.len()]);
            *self = Self { models: Some(models), input: sent, lagged, ..Self::default() };
            return DoubtFinding::default();
        };
        let mut steering = f64::INFINITY;
        let mut drive = f64::INFINITY;
        let gain = 1.0 - (-dt / FOLLOW).exp();
        let wheelbase = car.wheelbase();
        let allowed = limits.yaw_rate + limits.steer * x.v_x.max(0.0) / wheelbase;
        let smooth = 1.0 - (-dt / SMOOTH).exp();
        self.lateral += smooth * (x.v_x * x.omega_z - self.lateral);
        self.held = (self.held * (-dt / REMEMBER).exp()).max(self.lateral.abs());
        for ((models, sliding), grip) in models.iter_mut().zip(&rules.sliding).zip(GRIPS) {
            let counts = self.may_have(rules, grip);
            for (model, input) in models.iter_mut().zip(&self.lagged) {
                *model = stop::roll(rules, sliding, model, *input, (dt, STEP), 0.0);
                let (v, v_y) = (x.v_x - model.v_x, x.v_y - model.v_y);
                let omega = x.omega_z - model.omega_z;
                if counts {
                    steering = steering.min(omega.abs() / allowed);
                    drive = drive.min(v.abs() / (FOLLOW * limits.accel));
                }
                model.v_x += gain * v;
                model.v_y += gain * v_y;
                model.omega_z += gain * omega;
            }
        }
        self.models = Some(models);
        let add = |sum: f64, ratio: f64| {
            (sum + (ratio.min(10.0) - 1.0) * dt / limits.patience).clamp(0.0, MOST)
        };
        self.drive = add(self.drive, drive);
        self.steering = if x.v_x > SLOW { add(self.steering, steering) } else { 0.0 };
        DoubtFinding { what: Suspicion::Drive, level: self.drive }
            .or(DoubtFinding { what: Suspicion::Steering, level: self.steering })
    }
}
