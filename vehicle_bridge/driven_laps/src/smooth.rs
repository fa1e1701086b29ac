//! Signals without their noise: the Whittaker smoother, as strong as the signal itself asks for.
//!
//! z minimises |y - z|^2 + lambda |D^3 z|^2 with the third differences D^3 (Eilers, Analytical
//! Chemistry 75, 2003). lambda is the one of least generalised cross-validation score.

use std::f64::consts::PI;

/// Order of the differences: parabolas are left as they are.
const ORDER: usize = 3;
/// Strengths tried: powers of this from the least to the greatest.
const RATIO: f64 = 1.995_262_314_968_88; // 10^0.3
const LEAST: f64 = 1e-4;
const GRADES: usize = 34;
/// A smoother has to lower the score to this share of that of nearly none to be used: samples that
/// are exact stay exact.
const WORTH: f64 = 0.8;
/// Fewest samples a third difference says something about.
pub const MIN_SAMPLES: usize = 8;

/// A smoothed signal.
#[derive(Debug, Clone)]
pub struct Smoothed {
    /// The samples without noise.
    pub values: Vec<f64>,
    /// Standard deviation of what was taken away; 0 where nothing was.
    pub noise: f64,
}

/// Smooths samples at equal distances.
#[must_use]
pub fn smooth(samples: &[f64]) -> Smoothed {
    let exact = Smoothed { values: samples.to_vec(), noise: 0.0 };
    if samples.len() < MIN_SAMPLES {
        return exact;
    }
    let score = |lambda: f64| -> Option<(f64, Smoothed)> {
        let values = solve(samples, lambda)?;
        let n = samples.len() as f64;
        let left: f64 = samples.iter().zip(&values).map(|(y, z)| (y - z) * (y - z)).sum();
        let freedom = n - degrees(samples.len(), lambda);
        let gcv = n * left / (freedom * freedom);
        Some((gcv, Smoothed { values, noise: (left / freedom).sqrt() }))
    };
    let Some((nearly_none, _)) = score(LEAST) else { return exact };
    let mut best: Option<(f64, Smoothed)> = None;
    let mut lambda = LEAST;
    for _ in 0..GRADES {
        lambda *= RATIO;
        if let Some((gcv, smoothed)) = score(lambda)
            && best.as_ref().is_none_or(|(least, _)| gcv < *least)
        {
            best = Some((gcv, smoothed));
        }
    }
    match best {
        Some((gcv, smoothed)) if gcv < WORTH * nearly_none => smoothed,
        _ => exact,
    }
}

/// Effective number of parameters, by the eigenvalues (2 sin(pi i / 2n))^6 of D'D far from the ends.
fn degrees(n: usize, lambda: f64) -> f64 {
    let one = |i: usize| {
        let wave = 2.0 * (0.5 * PI * i as f64 / n as f64).sin();
        1.0 / (1.0 + lambda * wave.powi(2 * ORDER as i32))
    };
    (0..n).map(one).sum()
}

/// (I + lambda D'D) z = y by a banded LDL'.
fn solve(y: &[f64], lambda: f64) -> Option<Vec<f64>> {
    const D: [f64; ORDER + 1] = [-1.0, 3.0, -3.0, 1.0];
    let n = y.len();
    // band[i][k] is the entry (i, i - k) of the matrix, then of the factor.
    let mut band = vec![[0.0; ORDER + 1]; n];
    for row in &mut band {
        row[0] = 1.0;
    }
    for first in 0..n - ORDER {
        for (i, a) in D.iter().enumerate() {
            for (j, b) in D.iter().enumerate().take(i + 1) {
                band[first + i][i - j] += lambda * a * b;
            }
        }
    }
    for i in 0..n {
        for k in (1..=ORDER.min(i)).rev() {
            let j = i - k;
            let mut value = band[i][k];
            for m in k + 1..=ORDER.min(i) {
                let p = i - m;
                value -= band[i][m] * band[p][0] * band[j][j - p];
            }
            band[i][k] = value / band[j][0];
        }
        for k in 1..=ORDER.min(i) {
            let entry = band[i][k];
            band[i][0] -= entry * entry * band[i - k][0];
        }
        if !(band[i][0] > 0.0 && band[i][0].is_finite()) {
            return None;
        }
    }
    let mut z = y.to_vec();
    for i in 0..n {
        for k in 1..=ORDER.min(i) {
            z[i] -= band[i][k] * z[i - k];
        }
    }
    for i in (0..n).rev() {
        z[i] /= band[i][0];
        for k in 1..=ORDER.min(n - 1 - i) {
            z[i] -= band[i + k][k] * z[i + k];
        }
    }
    Some(z)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "code of tests")]

    use nalgebra::{DMatrix, DVector};
    use rand::SeedableRng as _;
    use rand_distr::{Distribution as _, Normal};

    use super::*;

    #[test]
    fn the_banded_solution_is_that_of_the_full_matrix() {
        let y: Vec<f64> = (0..12).map(|i| f64::from(i * i % 7)).collect();
        let n = y.len();
        let mut d = DMatrix::<f64>::identity(n, n);
        for _ in 0..ORDER {
            let rows = d.nrows() - 1;
            d = d.rows(1, rows) - d.rows(0, rows);
        }
        let matrix = DMatrix::identity(n, n) + d.transpose() * &d * 2.5;
        let full = matrix.lu().solve(&DVector::from_column_slice(&y)).unwrap();
        for (a, b) in solve(&y, 2.5).unwrap().iter().zip(full.iter()) {
            assert!((a - b).abs() < 1e-12, "{a} {b}");
        }
    }

    #[test]
    fn noise_goes_and_exact_samples_stay() {
        let exact: Vec<f64> = (0..400).map(|i| (0.05 * f64::from(i)).sin() * 3.0).collect();
        let left = smooth(&exact);
        assert_eq!(left.values, exact);
        let mut rng = rand_pcg::Pcg64::seed_from_u64(3);
        let normal = Normal::new(0.0, 0.02).unwrap();
        let noisy: Vec<f64> = exact.iter().map(|y| y + normal.sample(&mut rng)).collect();
        let found = smooth(&noisy);
        assert!((found.noise - 0.02).abs() < 0.003, "{}", found.noise);
        let error = |z: &[f64]| {
            let sum: f64 = z.iter().zip(&exact).map(|(a, b)| (a - b) * (a - b)).sum();
            (sum / exact.len() as f64).sqrt()
        };
        assert!(error(&found.values) < 0.4 * error(&noisy), "{}", error(&found.values));
    }
}
