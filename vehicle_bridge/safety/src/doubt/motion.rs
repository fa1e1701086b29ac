//! Pose against velocity of the same states: a pose that is frozen, jumps, drifts or is scaled.

use vehicle_model::State;

use super::super::rules::Rules;
use super::{DoubtFinding, DoubtLimits, Suspicion};

/// Disagreements are forgotten with this time constant. \[s\]
const FORGET: f64 = 1.0;
/// A wheel's or a map's curvature changes at once where two segments meet. \[-\]
const LEAST_SCALE: f64 = 0.2;

/// Disagreement so far: along and across the track, and of the heading. \[m, m, rad\]
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Motion([f64; 3]);

impl Motion {
    pub(super) fn on_state(
        &mut self,
        rules: &Rules,
        limits: &DoubtLimits,
        before: &State,
        x: &State,
        dt: f64,
    ) -> DoubtFinding {
        let track = &rules.track;
        let length = track.length();
        let way = (x.s - before.s + 0.5 * length).rem_euclid(length) - 0.5 * length;
        let kappa = track.kappa(before.s + 0.5 * way);
        let turn = (x.e_psi - before.e_psi).sin().atan2((x.e_psi - before.e_psi).cos());
        let rates = [before, x].map(|x| {
            let scale = (1.0 - kappa * x.e_y).max(LEAST_SCALE);
            let (sin, cos) = x.e_psi.sin_cos();
            let s_dot = (x.v_x * cos - x.v_y * sin) / scale;
            (scale * s_dot, x.v_x * sin + x.v_y * cos, x.omega_z - kappa * s_dot, scale)
        });
        let mean =
            |part: fn(&(f64, f64, f64, f64)) -> f64| 0.5 * (part(&rates[0]) + part(&rates[1]));
        let moved = [
            way * mean(|r| r.3) - mean(|r| r.0) * dt,
            x.e_y - before.e_y - mean(|r| r.1) * dt,
            turn - mean(|r| r.2) * dt,
        ];
        let kept = (-dt / FORGET).exp();
        for (sum, new) in self.0.iter_mut().zip(moved) {
            *sum = kept * *sum + new;
        }
        let speed = 0.5 * (x.v_x.hypot(x.v_y) + before.v_x.hypot(before.v_y));
        let bend = track.max_abs_kappa() * speed;
        let along = limits.position + speed * (limits.timing + FORGET * limits.speed_share);
        // Curvature is known at one place of the step alone.
        let across = limits.position
            + speed * (FORGET * limits.heading_error + bend * dt * limits.timing.max(dt));
        let heading = limits.turn
            + bend * (limits.timing + dt)
            + FORGET * limits.speed_share * x.omega_z.abs();
        let [a, b, c] = self.0;
        let position = (a.abs() / along).max(b.abs() / across);
        DoubtFinding { what: Suspicion::Position, level: position }
            .or(DoubtFinding { what: Suspicion::Heading, level: c.abs() / heading })
    }
}
