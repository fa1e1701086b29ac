//! Grip from noisy measurements: what each of them says of it, summed up as it comes.
//!
//! A smoothed lap agrees with the model that smoothed it, whatever its grip. A measurement does not:
//! `r = z - f(x, u)` with the filtered state x tells the factors g of the grip by
//!
//! ```text
//! Lambda <- FORGET Lambda + w J' S^-1 J          eta <- FORGET eta + w J' S^-1 (r + J g)
//! g = (Lambda + 1/PRIOR^2)^-1 (eta + g_0/PRIOR^2)                g_0: what is expected
//! ```
//!
//! with the model's derivative J by the factors, the variances S and the robust weights w of the fit
//! ([`grip`](super::grip)).

use nalgebra::{Matrix2, Vector2};
use serde::{Deserialize, Serialize};

/// What a period says one period later.
const FORGET: f64 = 0.9985;
/// Standard deviation of the grip of a road before it is driven, about what is expected of it.
const PRIOR: f64 = 0.25;
/// Factors outside this range are rejected.
const RANGE: (f64, f64) = (0.2, 3.0);

/// The sums.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub(crate) struct GripSums {
    lambda: [[f64; 2]; 2],
    eta: [f64; 2],
}

impl GripSums {
    /// Takes in residuals [v_x, v_y, omega_z], their derivatives by the factors, and variances.
    pub(crate) fn add(
        &mut self,
        grip: [f64; 2],
        residual: [f64; 3],
        by_grip: [[f64; 2]; 3],
        variance: [f64; 3],
    ) {
        let known = residual.iter().chain(by_grip.iter().flatten()).all(|v| v.is_finite());
        if !known {
            return;
        }
        let (mut lambda, mut eta) = (Matrix2::from(self.lambda), Vector2::from(self.eta));
        lambda *= FORGET;
        eta *= FORGET;
        for row in 0..3 {
            let j = Vector2::from(by_grip[row]);
            let r = residual[row];
            let weight = 1.0 / (1.0 + 0.25 * r * r / variance[row]).sqrt() / variance[row];
            lambda += j * j.transpose() * weight;
            eta += j * (weight * (r + j.dot(&Vector2::from(grip))));
        }
        (self.lambda, self.eta) = (lambda.into(), eta.into());
    }

    /// The most likely factors [front, rear], where these were `expected` before.
    pub(crate) fn grip(&self, expected: [f64; 2]) -> Option<[f64; 2]> {
        let prior = 1.0 / (PRIOR * PRIOR);
        let lambda = Matrix2::from(self.lambda) + Matrix2::identity() * prior;
        let eta = Vector2::from(self.eta) + Vector2::from(expected) * prior;
        let grip = lambda.cholesky()?.solve(&eta);
        Some(grip.map(|factor| factor.clamp(RANGE.0, RANGE.1)).into())
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    /// The true factors come out of exact residuals, whatever the factors that were in force.
    #[test]
    fn factors_are_found_from_residuals() {
        let (truth, mut sums) = ([0.7, 0.8], GripSums::default());
        for k in 0..400 {
            let grip = [1.0 - 0.001 * f64::from(k), 0.9];
            let angle = 0.3 * f64::from(k);
            let j = [[0.0, 0.1], [angle.sin(), 0.5], [2.0, angle.cos() * 3.0]];
            let r = j.map(|j| j[0] * (truth[0] - grip[0]) + j[1] * (truth[1] - grip[1]));
            sums.add(grip, r, j, [0.01, 0.01, 0.1]);
        }
        let found = sums.grip([1.0; 2]).unwrap();
        assert!((found[0] - truth[0]).abs() < 0.01 && (found[1] - truth[1]).abs() < 0.01);
        assert_eq!(GripSums::default().grip([0.9, 0.8]), Some([0.9, 0.8]));
    }
}
