//! How far the car is from where the plan expected it one period before: what the learned model does
//! not know, and what disturbs the car.
//!
//! With d_k the error of the predicted velocities at step k,
//!
//! ```text
//! Q = mean(d d')      over the latest steps
//! ```
//!
//! is the covariance of the velocities one period ahead, when the next command can answer. The pose
//! follows from the velocities:
//!
//! ```text
//! var e_psi = dt^2 Q_33          var e_y = dt^2 (Q_22 + (v_x dt)^2 Q_33)
//! ```
//!
//! Lane and slip guards keep room for it. Where measurements are noisy, lane and front guard keep room for
//! the filter's covariance instead.

use nalgebra::{Matrix3, Matrix6};
use serde::{Deserialize, Serialize};
use vehicle_model::State;

/// Steps remembered.
const RECENT: f64 = 150.0;
/// Steps without any error that the mean begins with: a single error says little.
const PRIOR: f64 = 20.0;

/// Running second moments of the one-step prediction error of [v_x, v_y, omega_z].
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct PredictionError {
    /// The velocities at the next measurement, as the plan has them.
    expected: Option<[f64; 3]>,
    /// Steps in the mean.
    count: f64,
    moments: [[f64; 3]; 3],
}

impl Default for PredictionError {
    fn default() -> Self {
        Self { expected: None, count: PRIOR, moments: [[0.0; 3]; 3] }
    }
}

impl PredictionError {
    /// The state at the next measurement, if all goes as planned.
    pub(crate) fn expect(&mut self, next: &State) {
        self.expected = Some([next.v_x, next.v_y, next.omega_z]);
    }

    /// Compares what was expected with the state measured now; `None` where no conclusion can be drawn from it.
    pub(crate) fn compare(&mut self, now: Option<&State>) {
        let (Some(expected), Some(now)) = (self.expected.take(), now) else { return };
        let d = [now.v_x - expected[0], now.v_y - expected[1], now.omega_z - expected[2]];
        self.count = (self.count + 1.0).min(RECENT);
        for (i, row) in self.moments.iter_mut().enumerate() {
            for (j, moment) in row.iter_mut().enumerate() {
                *moment += (d[i] * d[j] - *moment) / self.count;
            }
        }
    }

    /// Covariance of the state one period `dt` ahead of a car with this speed.
    pub(crate) fn covariance(&self, v_x: f64, dt: f64) -> Matrix6<f64> {
        let q = Matrix3::from(self.moments);
        let mut p = Matrix6::zeros();
        p.fixed_view_mut::<3, 3>(0, 0).copy_from(&q);
        let along = v_x * dt;
        p[(3, 3)] = dt * dt * q[(2, 2)];
        p[(5, 5)] = dt * dt * (q[(1, 1)] + along * along * q[(2, 2)]);
        p
    }
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_pcg::Pcg64;
    use vehicle_model::normal::standard_normal;

    use super::*;

    /// Positions integrated from velocities with drawn errors spread as far as the covariance says.
    #[test]
    fn the_pose_spreads_as_velocities_with_the_measured_error_carry_it() {
        let (v_x, dt, sigma) = (3.0, 0.1, [0.05, 0.04, 0.3]);
        let mut rng = Pcg64::seed_from_u64(4);
        let mut error = PredictionError::default();
        let expected = State { v_x, ..State::default() };
        let (mut heading, mut across) = (0.0, 0.0);
        let n = 4000;
        for _ in 0..n {
            let [a, b, c] = sigma.map(|sigma| -> f64 { sigma * standard_normal(&mut rng) });
            let now = State { v_x: v_x + a, v_y: b, omega_z: c, ..State::default() };
            error.expect(&expected);
            error.compare(Some(&now));
            // The heading is off by the whole period's turn when the car has gone on by v_x dt.
            heading += (dt * c).powi(2);
            across += (dt * b + v_x * dt * dt * c).powi(2);
        }
        let p = error.covariance(v_x, dt);
        for (found, drawn) in [(p[(3, 3)], heading), (p[(5, 5)], across), (p[(0, 0)], 0.0)] {
            let drawn = if drawn > 0.0 { drawn / f64::from(n) } else { sigma[0] * sigma[0] };
            // Of the latest 150 draws, a variance is known to 12 %.
            assert!((found / drawn - 1.0).abs() < 0.4, "{found} {drawn}");
        }
    }

    #[test]
    fn what_was_not_expected_is_no_error() {
        let mut error = PredictionError::default();
        error.compare(Some(&State { v_x: 5.0, ..State::default() }));
        error.expect(&State::default());
        error.compare(None);
        error.compare(Some(&State { v_x: 5.0, ..State::default() }));
        assert_eq!(error.covariance(3.0, 0.1), Matrix6::zeros());
    }
}
