//! Error dynamics regression (paper, section on regression): a local affine model of what the
//! nominal model gets wrong in the velocity rows.
//!
//! For a point z_bar = [v_x, v_y, omega_z, a, delta] of the horizon, with the M nearest stored
//! samples z_m and their targets y_m,
//!
//! ```text
//! u_m    = (z_m - z_bar)' Q (z_m - z_bar)
//! K(u)   = 3/4 (1 - u^2/h^2)  for u < h, else 0                   (Epanechnikov)
//! Gamma  = argmin  sum_m K(u_m) (y_m - Gamma' phi_m)^2 + eps |Gamma|^2
//! ```
//!
//! The kernel takes the squared distance u: with it the paper's study of h is reproduced.
//! Neither s, e_y nor e_psi are in z, so that data of other corners count.

use nalgebra::{SMatrix, SVector};
use vehicle_model::{Input, State};

use super::dataset::Lap;
use super::neighbors::{DIMENSIONS, Neighbor, Point, Tree};
use crate::affine::Affine;
use crate::config::{Features, RegressionConfig};

/// Velocity rows: v_x, v_y, omega_z.
pub const ROWS: usize = 3;

/// Point of the regression's space: [v_x, v_y, omega_z, a, delta].
#[must_use]
pub fn regressor(x: &State, u: &Input) -> [f64; DIMENSIONS] {
    [x.v_x, x.v_y, x.omega_z, u.a, u.delta]
}

/// Epanechnikov kernel of the squared distance u with bandwidth h.
#[must_use]
pub fn epanechnikov(u: f64, h: f64) -> f64 {
    if u < h { 0.75 * (1.0 - (u / h) * (u / h)) } else { 0.0 }
}

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
pub struct Gamma(pub [[f64; DIMENSIONS + 1]; ROWS]);

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
    let mut gamma = Gamma::default();
    match features {
        Features::Own => {
            let longitudinal = solve(samples, eps, [0, 1, 2, 3], [0]);
            let lateral = solve(samples, eps, [0, 1, 2, 4], [1, 2]);
            place::<4, 5, 1>(&mut gamma, &longitudinal, [0, 1, 2, 3], [0]);
            place::<4, 5, 2>(&mut gamma, &lateral, [0, 1, 2, 4], [1, 2]);
        }
        Features::Both => {
            let all = solve(samples, eps, [0, 1, 2, 3, 4], [0, 1, 2]);
            place::<5, 6, 3>(&mut gamma, &all, [0, 1, 2, 3, 4], [0, 1, 2]);
        }
    }
    gamma
}

/// Normal equations (Phi' W Phi + eps I) Gamma = Phi' W Y of the rows that share features.
fn solve<const F: usize, const F1: usize, const R: usize>(
    samples: &[Weighted],
    eps: f64,
    features: [usize; F],
    rows: [usize; R],
) -> SMatrix<f64, F1, R> {
    let mut gram = SMatrix::<f64, F1, F1>::identity() * eps;
    let mut moment = SMatrix::<f64, F1, R>::zeros();
    for sample in samples {
        let phi =
            SVector::<f64, F1>::from_fn(|i, _| if i < F { sample.z[features[i]] } else { 1.0 });
        let y = SVector::<f64, R>::from_fn(|i, _| sample.y[rows[i]]);
        let weighted = phi * sample.weight;
        gram.ger(1.0, &weighted, &phi, 1.0);
        moment.ger(1.0, &weighted, &y, 1.0);
    }
    // eps > 0 makes the Gram matrix positive definite; overflow alone can spoil it.
    gram.cholesky().map_or_else(SMatrix::zeros, |factor| factor.solve(&moment))
}

fn place<const F: usize, const F1: usize, const R: usize>(
    gamma: &mut Gamma,
    solution: &SMatrix<f64, F1, R>,
    features: [usize; F],
    rows: [usize; R],
) {
    for (r, &row) in rows.iter().enumerate() {
        for (f, &feature) in features.iter().enumerate() {
            gamma.0[row][feature] = solution[(f, r)];
        }
        gamma.0[row][DIMENSIONS] = solution[(F, r)];
    }
}

/// Regression samples of one lap. They depend on the lap and on the nominal model alone, so that
/// each lap's residuals are computed once.
#[derive(Debug, Clone, Default)]
pub(crate) struct Targets {
    z: Vec<[f64; DIMENSIONS]>,
    y: Vec<[f64; ROWS]>,
}

impl Targets {
    /// The samples of `lap`; `target` maps x, u and the next velocities to y.
    pub(crate) fn new(
        lap: &Lap,
        mut target: impl FnMut(&State, &Input, [f64; ROWS]) -> [f64; ROWS],
    ) -> Self {
        let mut targets = Self::default();
        for sample in &lap.samples {
            let Some(next) = sample.next else { continue };
            let y = target(&sample.x, &sample.u, next);
            if y.iter().all(|v| v.is_finite()) {
                targets.z.push(regressor(&sample.x, &sample.u));
                targets.y.push(y);
            }
        }
        targets
    }
}

/// The samples of all laps in use, with a tree over them.
#[derive(Debug, Clone, Default)]
pub(crate) struct RegressionData {
    z: Vec<[f64; DIMENSIONS]>,
    y: Vec<[f64; ROWS]>,
    tree: Tree,
    scale: [f64; DIMENSIONS],
}

/// Memory a fit needs, reused from step to step.
#[derive(Debug, Clone, Default)]
pub(crate) struct Scratch {
    neighbors: Vec<Neighbor>,
    samples: Vec<Weighted>,
}

impl RegressionData {
    /// Collects the laps' samples.
    pub(crate) fn new<'a>(
        laps: impl Iterator<Item = &'a Targets>,
        config: &RegressionConfig,
    ) -> Self {
        let scale = config.metric.map(f64::sqrt);
        let mut data = Self { scale, ..Self::default() };
        for lap in laps {
            data.z.extend_from_slice(&lap.z);
            data.y.extend_from_slice(&lap.y);
        }
        data.tree = Tree::new(data.z.iter().map(|z| scaled(z, &scale)));
        data
    }

    /// Fit around z_bar: Gamma, and the sum of the kernel weights that support it.
    ///
    /// Without data inside the bandwidth Gamma is exactly zero.
    pub(crate) fn fit(
        &self,
        z_bar: &[f64; DIMENSIONS],
        config: &RegressionConfig,
        scratch: &mut Scratch,
    ) -> (Gamma, f64) {
        let query = scaled(z_bar, &self.scale);
        let h = config.bandwidth;
        self.tree.nearest(&query, config.neighbors, h, &mut scratch.neighbors);
        scratch.samples.clear();
        let mut support = 0.0;
        for &(u, index) in &scratch.neighbors {
            let i = index as usize;
            let weight = epanechnikov(u, h);
            support += weight;
            scratch.samples.push(Weighted { z: self.z[i], y: self.y[i], weight });
        }
        if support > 0.0 {
            (ridge(&scratch.samples, config.ridge, config.features), support)
        } else {
            (Gamma::default(), 0.0)
        }
    }
}

fn scaled(z: &[f64; DIMENSIONS], scale: &[f64; DIMENSIONS]) -> Point {
    std::array::from_fn(|i| z[i] * scale[i])
}
