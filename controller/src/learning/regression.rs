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
use super::neighbors::{DIMENSIONS, Neighbor, Point, Tree, squared_distance};
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
    /// Number of each lap and where its samples begin; laps follow one another.
    laps: Vec<(usize, usize)>,
}

/// Memory a fit needs, reused from step to step; the neighbours found last are where the next
/// search begins.
#[derive(Debug, Clone, Default)]
pub(crate) struct Scratch {
    neighbors: Vec<Neighbor>,
    samples: Vec<Weighted>,
}

impl Scratch {
    /// Room for the neighbours of a fit.
    pub(crate) fn new(config: &RegressionConfig) -> Self {
        let count = config.neighbors;
        Self { neighbors: Vec::with_capacity(count), samples: Vec::with_capacity(count) }
    }
}

impl RegressionData {
    /// No samples yet.
    pub(crate) fn new(config: &RegressionConfig) -> Self {
        Self { scale: config.metric.map(f64::sqrt), ..Self::default() }
    }

    /// The first lap from `first` on that has not been added.
    pub(crate) fn next_lap(&self, first: usize) -> usize {
        self.laps.last().map_or(first, |(lap, _)| lap + 1)
    }

    /// Adds the samples of lap number `lap`.
    pub(crate) fn add(&mut self, lap: usize, targets: &Targets) {
        let begin = self.z.len();
        self.laps.push((lap, begin));
        self.z.extend_from_slice(&targets.z);
        self.y.extend_from_slice(&targets.y);
        self.grow(begin);
    }

    /// Takes away the laps before `first`.
    pub(crate) fn forget_before(&mut self, first: usize) {
        let gone = self.laps.partition_point(|(lap, _)| *lap < first);
        if gone == 0 {
            return;
        }
        let begin = self.laps.get(gone).map_or(self.z.len(), |(_, begin)| *begin);
        self.z.drain(..begin);
        self.y.drain(..begin);
        self.laps.drain(..gone);
        for (_, old) in &mut self.laps {
            *old -= begin;
        }
        self.tree = Tree::default();
        self.grow(0);
    }

    /// Brings the samples from `begin` on into the tree.
    fn grow(&mut self, begin: usize) {
        let points: Vec<Point> = self.z[begin..].iter().map(|z| scaled(z, &self.scale)).collect();
        self.tree.extend(&points);
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
        let limit = h.min(self.reach(&query, config.neighbors, &scratch.neighbors));
        self.tree.nearest(&query, config.neighbors, limit, &mut scratch.neighbors);
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

    /// A squared distance within which `count` samples lie for certain: those found for the point
    /// before, which is near. Where the search looks first makes no difference to what it finds.
    fn reach(&self, query: &Point, count: usize, before: &[Neighbor]) -> f64 {
        if before.len() < count {
            return f64::INFINITY;
        }
        let mut farthest: f64 = 0.0;
        for &(_, index) in before {
            // Indices may be those of data that are no more.
            let Some(z) = self.z.get(index as usize) else { return f64::INFINITY };
            farthest = farthest.max(squared_distance(&scaled(z, &self.scale), query));
        }
        farthest.next_up()
    }
}

fn scaled(z: &[f64; DIMENSIONS], scale: &[f64; DIMENSIONS]) -> Point {
    std::array::from_fn(|i| z[i] * scale[i])
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};

    #[test]
    fn grown_and_cut_data_fit_as_those_made_at_once() {
        let config = RegressionConfig { laps: 0, ..RegressionConfig::default() };
        let mut rng = rand_pcg::Pcg64::seed_from_u64(3);
        let mut lap = |n: usize| {
            let mut lap = Targets::default();
            for _ in 0..n {
                lap.z.push([(); DIMENSIONS].map(|()| rng.random_range(-1.0..1.0)));
                lap.y.push([(); ROWS].map(|()| rng.random_range(-1.0..1.0)));
            }
            lap
        };
        let laps = [lap(150), lap(0), lap(90), lap(200)];
        let (mut grown, mut scratch) = (RegressionData::new(&config), Scratch::new(&config));
        let points: Vec<_> = lap(20).z;
        for (first, end) in [(0, 1), (0, 3), (1, 4), (3, 4), (4, 4)] {
            grown.forget_before(first);
            let next = grown.next_lap(first);
            for (i, lap) in laps.iter().enumerate().take(end).skip(next) {
                grown.add(i, lap);
            }
            let mut once = RegressionData::new(&config);
            (first..end).for_each(|i| once.add(i, &laps[i]));
            for z in &points {
                // The one begins where it was before, the other anywhere.
                let fit = grown.fit(z, &config, &mut scratch);
                assert_eq!(fit, once.fit(z, &config, &mut Scratch::new(&config)));
                assert_eq!(fit.1 > 0.0, first < 4);
            }
        }
    }
}
