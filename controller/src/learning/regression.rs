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

use pulp::{Arch, Simd, WithSimd};
use vehicle_model::{Input, State};

use super::dataset::Lap;
use super::neighbors::{DIMENSIONS, Found, Point, Tree, squared_distance};
use super::ridge::Columns;
pub use super::ridge::{Gamma, ROWS, Weighted, ridge};
use crate::config::RegressionConfig;

/// Point of the regression's space: [v_x, v_y, omega_z, a, delta].
#[must_use]
pub fn regressor(x: &State, u: &Input) -> [f64; DIMENSIONS] {
    [x.v_x, x.v_y, x.omega_z, u.a, u.delta]
}

/// Epanechnikov kernel of the squared distance u with bandwidth h.
#[must_use]
#[inline]
pub fn epanechnikov(u: f64, h: f64) -> f64 {
    if u < h { 0.75 * (1.0 - (u / h) * (u / h)) } else { 0.0 }
}

/// Regression samples of one lap. They depend on the lap and on the nominal model alone, so that
/// each lap's residuals are computed once.
#[derive(Debug, Clone, Default)]
pub(crate) struct Targets(Vec<Target>);

/// A regression sample: one line of the processor's cache, as neighbours lie anywhere in memory.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
struct Target {
    z: [f64; DIMENSIONS],
    y: [f64; ROWS],
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
                targets.0.push(Target { z: regressor(&sample.x, &sample.u), y });
            }
        }
        targets
    }
}

/// The samples of all laps in use, with a tree over them.
#[derive(Debug, Clone, Default)]
pub(crate) struct RegressionData {
    samples: Vec<Target>,
    tree: Tree,
    scale: [f64; DIMENSIONS],
    /// Number of each lap and where its samples begin; laps follow one another.
    laps: Vec<(usize, usize)>,
}

/// Memory that fits need, reused from step to step.
#[derive(Debug, Clone)]
pub(crate) struct Scratch {
    /// The widest vectors this processor has.
    arch: Arch,
    found: Found,
    /// Neighbours found last at each stage of the horizon.
    last: Vec<Vec<u32>>,
    weights: Vec<f64>,
    samples: Columns,
}

impl Scratch {
    /// Room for the neighbours of every stage.
    pub(crate) fn new(config: &RegressionConfig, stages: usize) -> Self {
        let count = config.neighbors;
        Self {
            arch: Arch::new(),
            found: Found::new(count),
            last: (0..stages).map(|_| Vec::with_capacity(count)).collect(),
            weights: Vec::with_capacity(count),
            samples: Columns::with_capacity(count),
        }
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
        let begin = self.samples.len();
        self.laps.push((lap, begin));
        self.samples.extend_from_slice(&targets.0);
        self.grow(begin);
    }

    /// Takes away the laps before `first`.
    pub(crate) fn forget_before(&mut self, first: usize) {
        let gone = self.laps.partition_point(|(lap, _)| *lap < first);
        if gone == 0 {
            return;
        }
        let begin = self.laps.get(gone).map_or(self.samples.len(), |(_, begin)| *begin);
        self.samples.drain(..begin);
        self.laps.drain(..gone);
        for (_, old) in &mut self.laps {
            *old -= begin;
        }
        self.tree = Tree::default();
        self.grow(0);
    }

    /// Brings the samples from `begin` on into the tree.
    fn grow(&mut self, begin: usize) {
        let samples = self.samples[begin..].iter();
        let points: Vec<Point> = samples.map(|sample| point(&sample.z, &self.scale)).collect();
        self.tree.extend(&points);
    }

    /// Fit around z_bar, the point of stage `t`: Gamma, and the sum of the kernel weights that
    /// support it.
    ///
    /// Without data inside the bandwidth Gamma is exactly zero.
    pub(crate) fn fit(
        &self,
        t: usize,
        z_bar: &[f64; DIMENSIONS],
        config: &RegressionConfig,
        scratch: &mut Scratch,
    ) -> (Gamma, f64) {
        scratch.arch.dispatch(Fit { data: self, t, z_bar, config, scratch })
    }

    /// A squared distance within which `count` samples lie for certain: those found before for a
    /// point that was near. Where the search looks first makes no difference to what it finds.
    #[inline(always)]
    fn reach(&self, query: &Point, count: usize, before: &[u32]) -> f32 {
        if before.len() < count {
            return f32::INFINITY;
        }
        let mut farthest: f32 = 0.0;
        for index in before {
            // Indices may be those of data that are no more.
            let Some(sample) = self.samples.get(*index as usize) else { return f32::INFINITY };
            let squared = squared_distance(&point(&sample.z, &self.scale), query);
            farthest = if squared > farthest { squared } else { farthest };
        }
        farthest
    }
}

/// One fit, compiled once for each instruction set.
struct Fit<'a> {
    data: &'a RegressionData,
    t: usize,
    z_bar: &'a [f64; DIMENSIONS],
    config: &'a RegressionConfig,
    scratch: &'a mut Scratch,
}

impl WithSimd for Fit<'_> {
    type Output = (Gamma, f64);

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> (Gamma, f64) {
        let Self { data, t, z_bar, config, scratch } = self;
        let Scratch { found, last, weights, samples, .. } = scratch;
        let query = point(z_bar, &data.scale);
        let h = config.bandwidth;
        // The plan was shifted: what is stage t now was the stage behind it a period ago.
        let before = last.get((t + 1).min(last.len().saturating_sub(1)));
        let reach = data.reach(&query, config.neighbors, before.map_or(&[], Vec::as_slice));
        // From the bandwidth on the weight is 0.
        found.nearest(&data.tree, &query, config.neighbors, reach.min(h as f32));
        let near = || found.indices().iter().map(|index| &data.samples[*index as usize]);
        weights.clear();
        let z_bar = scaled(z_bar, &data.scale);
        for sample in near() {
            let z = scaled(&sample.z, &data.scale);
            weights.push(epanechnikov(squared_distance(&z, &z_bar), h));
        }
        let support = weights.iter().sum();
        samples.set(weights, near().map(|sample| (&sample.z, &sample.y)));
        if let Some(last) = last.get_mut(t) {
            last.clear();
            last.extend_from_slice(found.indices());
        }
        if support > 0.0 {
            (samples.ridge(config.ridge, config.features), support)
        } else {
            (Gamma::default(), 0.0)
        }
    }
}

/// A point of the space whose metric is 1.
#[inline(always)]
fn scaled(z: &[f64; DIMENSIONS], scale: &[f64; DIMENSIONS]) -> [f64; DIMENSIONS] {
    std::array::from_fn(|i| z[i] * scale[i])
}

/// The same as the search has it.
#[inline(always)]
fn point(z: &[f64; DIMENSIONS], scale: &[f64; DIMENSIONS]) -> Point {
    scaled(z, scale).map(|z| z as f32)
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
                let mut any = || rng.random_range(-1.0..1.0);
                let (z, y) = ([(); DIMENSIONS].map(|()| any()), [(); ROWS].map(|()| any()));
                lap.0.push(Target { z, y });
            }
            lap
        };
        let laps = [lap(150), lap(0), lap(90), lap(200)];
        let (mut grown, mut scratch) = (RegressionData::new(&config), Scratch::new(&config, 3));
        let points: Vec<_> = lap(20).0.iter().map(|sample| sample.z).collect();
        for (first, end) in [(0, 1), (0, 3), (1, 4), (3, 4), (4, 4)] {
            grown.forget_before(first);
            let next = grown.next_lap(first);
            for (i, lap) in laps.iter().enumerate().take(end).skip(next) {
                grown.add(i, lap);
            }
            let mut once = RegressionData::new(&config);
            (first..end).for_each(|i| once.add(i, &laps[i]));
            for (t, z) in points.iter().enumerate() {
                // The one begins where it was before, the other anywhere.
                let fit = grown.fit(t % 4, z, &config, &mut scratch);
                assert_eq!(fit, once.fit(0, z, &config, &mut Scratch::new(&config, 0)));
                assert_eq!(fit.1 > 0.0, first < 4);
            }
        }
    }
}
