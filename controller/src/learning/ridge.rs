//! Weighted ridge regression of the velocity rows: normal equations of a handful of features.

use fhocp::Affine;
use nalgebra::{SMatrix, SVector};
use neighbors::DIMENSIONS;
use vector_sums::dot;

use crate::config::Features;

/// Velocity rows: v_x, v_y, omega_z.
pub const ROWS: usize = 3;

/// Features phi: v_x, v_y, omega_z, a, delta and 1.
const FEATURES: usize = DIMENSIONS + 1;

/// A regression sample with its weight.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Weighted {
    /// [v_x, v_y, omega_z, a, delta].
    pub z: [f64; DIMENSIONS],
    /// Target of each velocity row.
    pub y: [f64; ROWS],
    /// Kernel weight.
    pub weight: f64,
}

/// Coefficients Gamma of each velocity row on [v_x, v_y, omega_z, a, delta, 1]; 0 where the row
/// does not have the feature.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Gamma(pub [[f64; FEATURES]; ROWS]);

impl Gamma {
    /// The regression's part of the affine model: A^e, B^e, C^e.
    #[must_use]
    pub fn affine(&self) -> Affine {
        let mut model = Affine::default();
        for (row, gamma) in self.0.iter().enumerate() {
            let [v_x, v_y, omega_z, a, delta, one] = *gamma;
            model.a[(row, 0)] = v_x;
            model.a[(row, 1)] = v_y;
            model.a[(row, 2)] = omega_z;
            model.b[(row, 0)] = a;
            model.b[(row, 1)] = delta;
            model.c[row] = one;
        }
        model
    }
}

/// Weighted ridge regression of all three rows.
#[must_use]
pub fn ridge(samples: &[Weighted], eps: f64, features: Features) -> Gamma {
    let mut columns = Columns::default();
    let weights: Vec<f64> = samples.iter().map(|sample| sample.weight).collect();
    columns.set(&weights, samples.iter().map(|sample| (&sample.z, &sample.y)));
    columns.ridge(eps, features)
}

/// Samples, each quantity side by side.
#[derive(Debug, Clone, Default)]
pub(crate) struct Columns {
    weight: Vec<f64>,
    phi: [Vec<f64>; FEATURES],
    y: [Vec<f64>; ROWS],
    /// A feature times the weight.
    weighted: Vec<f64>,
}

impl Columns {
    /// Room for `count` samples.
    pub(crate) fn with_capacity(count: usize) -> Self {
        let column = || Vec::with_capacity(count);
        Self {
            weight: column(),
            phi: std::array::from_fn(|_| column()),
            y: std::array::from_fn(|_| column()),
            weighted: column(),
        }
    }

    /// Takes these samples in place of those before.
    #[inline(always)]
    pub(crate) fn set<'a>(
        &mut self,
        weights: &[f64],
        samples: impl Iterator<Item = (&'a [f64; DIMENSIONS], &'a [f64; ROWS])>,
    ) {
        let Self { weight, phi, y, .. } = self;
        for column in phi.iter_mut().chain(y.iter_mut()).chain([&mut *weight]) {
            column.resize(weights.len(), 1.0);
        }
        weight.copy_from_slice(weights);
        let [v_x, v_y, omega_z, a, delta, _] = phi;
        let inputs = a.iter_mut().zip(delta);
        let velocities = v_x.iter_mut().zip(v_y).zip(omega_z).zip(inputs);
        let [y_x, y_y, y_w] = y;
        let targets = y_x.iter_mut().zip(y_y).zip(y_w);
        for (((((v_x, v_y), omega_z), (a, delta)), ((y_x, y_y), y_w)), (z, y)) in
            velocities.zip(targets).zip(samples)
        {
            [*v_x, *v_y, *omega_z, *a, *delta] = *z;
            [*y_x, *y_y, *y_w] = *y;
        }
    }

    /// Normal equations (Phi' W Phi + eps I) Gamma = Phi' W Y of the rows that share features.
    #[inline(always)]
    pub(crate) fn ridge(&mut self, eps: f64, features: Features) -> Gamma {
        let mut gram = SMatrix::<f64, FEATURES, FEATURES>::identity() * eps;
        let mut moment = SMatrix::<f64, FEATURES, ROWS>::zeros();
        for i in 0..FEATURES {
            self.weighted.clear();
            self.weighted.extend(self.weight.iter().zip(&self.phi[i]).map(|(w, phi)| w * phi));
            for j in i..FEATURES {
                gram[(i, j)] += dot(&self.weighted, &self.phi[j]);
                gram[(j, i)] = gram[(i, j)];
            }
            for row in 0..ROWS {
                moment[(i, row)] = dot(&self.weighted, &self.y[row]);
            }
        }
        let mut gamma = Gamma::default();
        match features {
            Features::Own => {
                solve(&gram, &moment, [0, 1, 2, 3, 5], [0], &mut gamma);
                solve(&gram, &moment, [0, 1, 2, 4, 5], [1, 2], &mut gamma);
            }
            Features::Both => {
                solve(&gram, &moment, [0, 1, 2, 3, 4, 5], [0, 1, 2], &mut gamma);
            }
        }
        gamma
    }
}

/// Solves for the rows on their features.
#[inline(always)]
fn solve<const F: usize, const R: usize>(
    gram: &SMatrix<f64, FEATURES, FEATURES>,
    moment: &SMatrix<f64, FEATURES, ROWS>,
    features: [usize; F],
    rows: [usize; R],
    gamma: &mut Gamma,
) {
    let own = SMatrix::<f64, F, F>::from_fn(|i, j| gram[(features[i], features[j])]);
    // eps > 0 makes the Gram matrix positive definite; overflow alone can spoil it.
    let Some(factor) = own.cholesky() else { return };
    for row in rows {
        let mut solution = SVector::<f64, F>::from_fn(|i, _| moment[(features[i], row)]);
        factor.solve_mut(&mut solution);
        for (feature, value) in features.iter().zip(&solution) {
            gamma.0[row][*feature] = *value;
        }
    }
}
