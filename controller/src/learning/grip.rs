//! Grip by least squares: the factors on front and rear mu that explain the measured laps.
//!
//! Gauss-Newton on the scaled one-step velocity residuals r, with robust weights
//! 1 / sqrt(1 + (r/2)^2) and a light pull towards the first guess. Two factors only: fitting the
//! tyre's shape too runs away from slow laps.

use nalgebra::{Matrix2, Vector2};
use vehicle_model::{Discretized, Track};

use super::dataset::Sample;

/// Samples used, the most recent.
pub(crate) const SAMPLES: usize = 1500;
/// Scales of the residuals of v_x, v_y [m/s] and omega_z [rad/s].
const SCALES: [f64; 3] = [0.05, 0.05, 0.3];
/// Weight of the pull towards factor 1.
const PULL: f64 = 0.1;
/// The same where residuals are noise: slow laps say little of the grip, and noise would be taken
/// for it.
const NOISY_PULL: f64 = 10.0;
/// Gauss-Newton steps at most.
const STEPS: usize = 4;
/// A step smaller than this ends the iteration.
const DONE: f64 = 1e-4;
/// Factors that differ by less than this are the same.
const SAME: f64 = 1e-3;
/// Fitted factors outside this range are rejected: no road has such grip.
const RANGE: (f64, f64) = (0.2, 3.0);

/// The grip factors [front, rear] of `model` that fit the samples best, starting from its own;
/// `noise` are the variances of the velocities as measured.
pub(crate) fn fit<'a>(
    model: &Discretized,
    track: &Track,
    samples: impl Iterator<Item = &'a Sample>,
    noise: [f64; 3],
) -> [f64; 2] {
    let mut model = model.clone();
    let scales = [0, 1, 2].map(|row| {
        let exact = SCALES[row];
        if noise[row] > 0.0 { (exact * exact + noise[row]).sqrt() } else { exact }
    });
    let share = [0, 1, 2].map(|row| noise[row] / (scales[row] * scales[row]));
    let pull = PULL + NOISY_PULL * share.into_iter().fold(0.0, f64::max);
    let measured = samples.filter_map(|sample| Some(((sample.x, sample.u), sample.next?)));
    let (points, measured): (Vec<_>, Vec<_>) = measured.unzip();
    for _ in 0..STEPS {
        let grip = Vector2::from(model.model.grip);
        let mut hessian = Matrix2::identity() * pull;
        let mut gradient = (Vector2::repeat(1.0) - grip) * pull;
        model.grip_jacobians(&points, track.road(), |i, next, jacobian| {
            for row in 0..3 {
                let r = (measured[i][row] - next[row]) / scales[row];
                let j = Vector2::new(jacobian[(row, 0)], jacobian[(row, 1)]) / scales[row];
                if !r.is_finite() || !j.iter().all(|v| v.is_finite()) {
                    continue;
                }
                let weight = 1.0 / (1.0 + 0.25 * r * r).sqrt();
                hessian += j * j.transpose() * weight;
                gradient += j * (weight * r);
            }
        });
        let Some(step) = hessian.cholesky().map(|factor| factor.solve(&gradient)) else { break };
        model.model.grip = [0, 1].map(|i| (grip[i] + step[i]).clamp(RANGE.0, RANGE.1));
        if step.amax() < DONE {
            break;
        }
    }
    model.model.grip
}

/// Whether two fits differ enough to matter.
pub(crate) fn differ(a: [f64; 2], b: [f64; 2]) -> bool {
    a.iter().zip(b).any(|(a, b)| (a - b).abs() > SAME)
}
