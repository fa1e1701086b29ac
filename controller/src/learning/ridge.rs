//! Weighted ridge regression of the velocity rows, (6) to (8) of the paper: normal equations of a handful of
//! features.
//!
//! ```text
//! v_x row:                phi = [v_x, v_y, omega_z, a, 1]              (7), features = "own"
//! v_y and omega_z rows:   phi = [v_x, v_y, omega_z, delta, 1]
//! every row:              phi = [v_x, v_y, omega_z, a, delta, 1]       features = "both"
//!
//! (Phi' W Phi + eps I) Gamma* = Phi' W y        W = diag K(u_m)        (8), solved by a Cholesky factor
//!
//! A^e = [Gamma_vx Gamma_vy Gamma_omega 0 0 0],  B^e = [Gamma_a Gamma_delta],  C^e = Gamma_1      (6)
//! ```
//!
//! Gamma_q are the coefficients of the feature q in the three velocity rows; a row's missing feature has 0. The
//! pose rows of A^e, B^e and C^e are zero.

use fhocp::Affine;
use nalgebra::{SMatrix, SVector};
use neighbors::{DIMENSIONS, squared_distance};
use vector_sums::{dots, sum};

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
    columns.set(samples.iter().map(|sample| (&sample.z, &sample.y)));
    columns.weight.extend(samples.iter().map(|sample| sample.weight));
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

    /// Takes these samples in place of those before; they have no weights yet.
    #[inline(always)]
    pub(crate) fn set<'a>(
        &mut self,
        samples: impl ExactSizeIterator<Item = (&'a [f64; DIMENSIONS], &'a [f64; ROWS])>,
    ) {
        let Self { weight, phi, y, .. } = self;
        weight.clear();
        for column in phi.iter_mut().chain(y.iter_mut()) {
            column.resize(samples.len(), 1.0);
        }
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

    /// Weighs each sample by its distance from a point, both times `scale`; returns the sum of the weights.
    #[inline(always)]
    pub(crate) fn weigh(
        &mut self,
        z_bar: &[f64; DIMENSIONS],
        scale: &[f64; DIMENSIONS],
        kernel: impl Fn(f64) -> f64,
    ) -> f64 {
        let Self { weight, phi: [v_x, v_y, omega_z, a, delta, one], .. } = self;
        weight.resize(one.len(), 0.0);
        let inputs = a.iter().zip(&*delta);
        let velocities = v_x.iter().zip(&*v_y).zip(&*omega_z).zip(inputs);
        for (weight, (((v_x, v_y), omega_z), (a, delta))) in weight.iter_mut().zip(velocities) {
            let z = [*v_x, *v_y, *omega_z, *a, *delta];
            let z: [f64; DIMENSIONS] = std::array::from_fn(|i| z[i] * scale[i]);
            *weight = kernel(squared_distance(&z, z_bar));
        }
        sum(weight)
    }

    /// Normal equations (Phi' W Phi + eps I) Gamma = Phi' W Y of the rows that share features.
    #[inline(always)]
    pub(crate) fn ridge(&mut self, eps: f64, features: Features) -> Gamma {
        let mut equations = (SMatrix::identity() * eps, SMatrix::zeros());
        self.add_row::<9>(0, &mut equations);
        self.add_row::<8>(1, &mut equations);
        self.add_row::<7>(2, &mut equations);
        self.add_row::<6>(3, &mut equations);
        self.add_row::<5>(4, &mut equations);
        self.add_row::<4>(5, &mut equations);
        let (gram, moment) = equations;
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

    /// Adds the products of feature `i` with itself, those after it and the targets, `COUNT` in all.
    #[inline(always)]
    fn add_row<const COUNT: usize>(&mut self, i: usize, (gram, moment): &mut Equations) {
        let Self { weight, phi, y, weighted } = self;
        weighted.clear();
        weighted.extend(weight.iter().zip(&phi[i]).map(|(w, phi)| w * phi));
        let mut columns = [&[][..]; COUNT];
        for (column, of) in columns.iter_mut().zip(phi[i..].iter().chain(&*y)) {
            *column = of;
        }
        let products = dots(weighted, columns);
        let (own, targets) = products.split_at(FEATURES - i);
        for (j, product) in (i..).zip(own) {
            gram[(i, j)] += product;
            gram[(j, i)] = gram[(i, j)];
        }
        for (row, product) in targets.iter().enumerate() {
            moment[(i, row)] = *product;
        }
    }
}

/// Gram matrix and moments.
type Equations = (SMatrix<f64, FEATURES, FEATURES>, SMatrix<f64, FEATURES, ROWS>);

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
