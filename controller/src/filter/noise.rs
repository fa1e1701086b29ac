//! Measurement noise and model error, told apart by the correlation of the one-step residuals.
//!
//! d_k = z_{k+1} - f(z_k, u_k) = n_{k+1} - A n_k + w_k. White noise n leaves a negative correlation
//! of neighbouring residuals, E[d_k d_{k-1}'] = -A R, and none farther apart; a model error w that
//! changes slowly adds about the same to both. Row by row with a = A_ii:
//!
//! ```text
//! a near 1 (pose, v_x)       R = (C_2 - C_1) / a                Q = C_0 - (1 + a^2) R
//! a near 0 (v_y, omega_z)    R = (C_0 - C_1) / (1 + a + a^2)
//! ```
//!
//! In the second case the model forgets within a period, so that only slow model errors can be told
//! from noise. A sensor stays what it is while a model becomes worse or better: R comes from a long
//! memory, Q from a short one.

use nalgebra::{Matrix6, Vector6};
use serde::{Deserialize, Serialize};

use super::Filter;
use crate::derive::Scales;

/// Residuals remembered for the noise of the sensors.
const LONG: f64 = 4000.0;
/// Residuals remembered for the error of the model.
const SHORT: f64 = 150.0;
/// Residuals before anything is estimated.
const LEAST: f64 = 60.0;
/// Greatest residual and slope taken in.
const GREATEST: f64 = 1e6;
/// A residual counts up to this many standard deviations.
const CLIP: f64 = 4.0;
/// Noise of the position that counts as noise, in wheelbases; half of it ends the filtering.
const NOISY: f64 = 2e-3;
/// The same where the residuals are noise for the most part, and no error of the model.
const CLEARLY_NOISY: f64 = 3e-4;
/// Share that noise then has in the variance of the residuals, R + A R A'.
const CLEAR: f64 = 0.6;
/// Least feedback of such a row on itself.
const OWN: f64 = 0.5;
/// Rows of the velocities.
const VELOCITIES: [usize; 3] = [0, 1, 2];
/// Rows of the place.
const POSITION: [usize; 2] = [4, 5];
/// Rows that the model carries on: v_x and the pose.
const SLOW: [usize; 4] = [0, 3, 4, 5];
/// Variances of noise that go together differ at most by this factor.
const ALIKE: f64 = 0.2;
/// Noise of a pose before it is known: in wheelbases, and in radians.
const ASSUMED: f64 = 0.01;
/// Noise of a row is at least this share of that: a covariance must not vanish.
const FLOOR: f64 = 0.1;

/// Running moments of the one-step residuals.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Noise {
    count: f64,
    c_0: [f64; 6],
    /// C_0 of the last residuals.
    recent: [f64; 6],
    c_1: [f64; 6],
    c_2: [f64; 6],
    a: [f64; 6],
    /// Squares of the entries of A in the rows of s and e_y.
    spread: [[f64; 6]; 2],
    /// Recent squares of the second differences of the velocities' residuals.
    second: [f64; 3],
    last: Option<[f64; 6]>,
    before: Option<[f64; 6]>,
    /// Whether the position is noisy enough to be filtered.
    noisy: bool,
}

/// Diagonals of R and Q.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Variances {
    pub(super) noise: Vector6<f64>,
    pub(super) process: Vector6<f64>,
}

impl Noise {
    /// The next residual does not follow the last one.
    pub(super) fn interrupt(&mut self) {
        self.last = None;
        self.before = None;
    }

    /// Takes a residual in; `length` is the wheelbase.
    pub(super) fn add(&mut self, residual: &Vector6<f64>, a: &Matrix6<f64>, length: f64) {
        // What no sensor of a car says would spoil the moments for good.
        let sane = |v: &f64| v.abs() < GREATEST;
        if !residual.iter().all(sane) || !a.iter().all(sane) {
            self.interrupt();
            return;
        }
        let d: [f64; 6] = std::array::from_fn(|i| {
            let most = CLIP * self.recent[i].sqrt();
            if self.count < LEAST { residual[i] } else { residual[i].clamp(-most, most) }
        });
        let before = self.before;
        self.before = self.last;
        let (Some(last), Some(before)) = (self.last.replace(d), before) else { return };
        self.count = (self.count + 1.0).min(LONG);
        let (share, brief) = (1.0 / self.count, 1.0 / self.count.min(SHORT));
        for i in 0..6 {
            self.c_0[i] += share * (d[i] * d[i] - self.c_0[i]);
            self.recent[i] += brief * (d[i] * d[i] - self.recent[i]);
            self.c_1[i] += share * (d[i] * last[i] - self.c_1[i]);
            self.c_2[i] += share * (d[i] * before[i] - self.c_2[i]);
            self.a[i] += share * (a[(i, i)] - self.a[i]);
        }
        for (i, square) in self.second.iter_mut().enumerate() {
            let second = d[i] - 2.0 * last[i] + before[i];
            *square += brief * (second * second - *square);
        }
        for (row, spread) in POSITION.into_iter().zip(&mut self.spread) {
            for (i, square) in spread.iter_mut().enumerate() {
                *square += share * (a[(row, i)] * a[(row, i)] - *square);
            }
        }
        let held = if self.noisy { 0.5 } else { 1.0 };
        let noise: [f64; 6] = std::array::from_fn(|i| self.row(i).0);
        // Where v_y and omega_z leave the model at once, their noise is not told from errors of the model.
        let carried = self.spread.map(|a| SLOW.iter().map(|i| a[*i] * noise[*i]).sum::<f64>());
        let clear = POSITION
            .into_iter()
            .zip(carried)
            .all(|(i, carried)| noise[i] + carried > held * CLEAR * self.c_0[i]);
        let least = held * length * if clear { CLEARLY_NOISY } else { NOISY };
        self.noisy = self.count >= LEAST && POSITION.iter().all(|i| noise[*i].sqrt() > least);
    }

    /// Variances of the velocities' residuals by all that changes from period to period, sensor noise first:
    /// errors of the model change slowly along a lap, so that second differences, which have a
    /// white noise six times, leave them out.
    pub(super) fn rough(&self) -> [f64; 3] {
        self.second.map(|square| square / 6.0)
    }

    /// Noise and model error of a row.
    fn row(&self, i: usize) -> (f64, f64) {
        let (c_0, c_1, c_2, a) = (self.c_0[i], self.c_1[i], self.c_2[i], self.a[i]);
        let r = if SLOW.contains(&i) {
            (c_2 - c_1) / a.max(OWN)
        } else {
            (c_0 - c_1) / (1.0 + a + a * a)
        };
        let r = r.max(0.0);
        (r, (self.recent[i] - (1.0 + a * a) * r).max(0.0))
    }

    /// R and Q; none while measurements are exact, or not known to be noisy.
    pub(super) fn variances(&self, filter: &Filter) -> Option<Variances> {
        let (Scales { length, speed, .. }, dt) = (filter.scales, filter.dt);
        let known = self.count >= LEAST;
        let given = filter.config.noise;
        if !self.noisy && filter.config.velocities && given == [0.0; 6] {
            return None;
        }
        let scales = [speed, speed, speed / length, 1.0, length, length];
        let squared = Vector6::from(scales.map(|scale| scale * scale));
        let first = filter.first();
        let noise = Vector6::from_fn(|i, _| {
            let least = FLOOR * ASSUMED * scales[i];
            let sigma = match given[i] {
                0.0 if i < first => 0.0,
                0.0 if known => self.row(i).0.sqrt(),
                0.0 => ASSUMED * scales[i],
                given => given,
            };
            sigma.max(least).powi(2)
        });
        // Rows of one kind come from one sensor: one that seems exact is a bad estimate.
        let mut noise = noise.component_div(&squared);
        for rows in [&VELOCITIES[first.min(3)..], &POSITION[..]] {
            let most = rows.iter().map(|i| noise[*i]).fold(0.0, f64::max);
            for i in rows {
                noise[*i] = noise[*i].max(ALIKE * most);
            }
        }
        let noise = noise.component_mul(&squared);
        // What the tyres may do beside the model, in one period.
        let v = filter.config.model_error * speed * speed / length * dt;
        let velocity = [0, 1, 2].map(|i| {
            let least = if i == 2 { v / length } else { v };
            let seen = if known && i >= first { self.row(i).1 } else { 0.0 };
            least * least + seen
        });
        let half = (0.5 * dt).powi(2);
        let [v_x, v_y, omega_z] = velocity;
        let process = Vector6::new(v_x, v_y, omega_z, half * omega_z, half * v_x, half * v_y);
        Some(Variances { noise, process })
    }
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng as _;
    use vehicle_model::normal::standard_normal;

    use super::*;

    /// White residuals on an error of the model that goes round once in 60 periods.
    #[test]
    fn slow_errors_of_the_model_are_no_noise() {
        let mut random = rand_pcg::Pcg64::seed_from_u64(1);
        let sigma = [0.01, 0.02, 0.03];
        let (mut noise, mut sum, mut count) = (Noise::default(), [0.0; 3], 0.0);
        for k in 0..4_000 {
            let slow = 0.1 * libm::sin(std::f64::consts::TAU * f64::from(k) / 60.0);
            let mut residual = Vector6::zeros();
            for (value, sigma) in residual.iter_mut().zip(sigma) {
                *value = slow + sigma * standard_normal(&mut random);
            }
            noise.add(&residual, &Matrix6::zeros(), 1.0);
            if k % 100 == 99 {
                count += 1.0;
                for (sum, variance) in sum.iter_mut().zip(noise.rough()) {
                    *sum += variance;
                }
            }
        }
        for (sum, sigma) in sum.into_iter().zip(sigma) {
            let found = (sum / count).sqrt();
            assert!((found / sigma - 1.0).abs() < 0.1, "{found}, not {sigma}");
        }
    }
}
