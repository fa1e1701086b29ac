//! Error dynamics regression, (8) of the paper: a local affine model of what the nominal model gets wrong in the
//! velocity rows. `ridge.rs` solves it for the features of (7) and gives the matrices of (6).
//!
//! For a point z_bar = [v_x, v_y, omega_z, a, delta] of the horizon, with the M nearest stored
//! samples z_m and their targets y_m,
//!
//! ```text
//! u_m    = (z_m - z_bar)' Q (z_m - z_bar)
//! K(u)   = 3/4 (1 - u^2/h^2)  for u < h, else 0                   (Epanechnikov)
//! Gamma* = argmin  sum_m K(u_m) (y_m - Gamma' phi_m)^2 + eps |Gamma|^2            (8)
//! ```
//!
//! The kernel takes the squared distance u: with it the paper's study of h is reproduced.
//! Neither s, e_y nor e_psi are in z, so that data of other corners count.

use std::ops::Range;

use neighbors::{DIMENSIONS, Found, Point, Tree, squared_distance};
use pulp::{Arch, Simd, WithSimd};
use vehicle_model::{Input, State};

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

/// A regression sample: one line of the processor's cache, as neighbours lie anywhere in memory.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
pub(crate) struct Target {
    z: [f64; DIMENSIONS],
    y: [f64; ROWS],
}

impl Target {
    /// The target `y` at (x, u).
    pub(crate) fn new(x: &State, u: &Input, y: [f64; ROWS]) -> Self {
        Self { z: regressor(x, u), y }
    }
}

/// Places in a lap of `count` samples, `range` of an order in leaps through the lap: samples in the
/// order they were driven would make a lopsided tree.
pub(crate) fn leap_order(count: usize, range: Range<usize>) -> impl Iterator<Item = usize> {
    let least = (3 * count).div_ceil(5).max(1);
    let leap = (least..).find(|leap| coprime(*leap, count.max(1))).unwrap_or(1);
    range.map(move |k| (k * leap) % count.max(1))
}

fn coprime(a: usize, b: usize) -> bool {
    if b == 0 { a == 1 } else { coprime(b, a % b) }
}

/// The samples of all laps in use, with a tree over them.
#[derive(Debug, Clone, Default)]
pub(crate) struct RegressionData {
    samples: Vec<Target>,
    tree: Tree,
    scale: [f64; DIMENSIONS],
}

/// Memory that fits need, reused from step to step.
#[derive(Debug, Clone)]
pub(crate) struct Scratch {
    /// The widest vectors this processor has.
    arch: Arch,
    found: Found,
    /// Neighbours found last at each stage of the horizon.
    last: Vec<Vec<u32>>,
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
            samples: Columns::with_capacity(count),
        }
    }
}

impl RegressionData {
    /// No samples yet.
    pub(crate) fn new(config: &RegressionConfig) -> Self {
        Self { scale: config.metric.map(f64::sqrt), ..Self::default() }
    }

    /// Adds a sample.
    pub(crate) fn add(&mut self, target: Target) {
        self.tree.push(&point(&target.z, &self.scale));
        self.samples.push(target);
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
        let Scratch { found, last, samples, .. } = scratch;
        let query = point(z_bar, &data.scale);
        let h = config.bandwidth;
        // The plan was shifted: what is stage t now was the stage behind it a period ago.
        let before = last.get((t + 1).min(last.len().saturating_sub(1)));
        let reach = data.reach(&query, config.neighbors, before.map_or(&[], Vec::as_slice));
        // From the bandwidth on the weight is 0.
        found.nearest(&data.tree, &query, config.neighbors, reach.min(h as f32));
        let near = found.indices().iter().map(|index| &data.samples[*index as usize]);
        samples.set(near.map(|sample| (&sample.z, &sample.y)));
        let z_bar = scaled(z_bar, &data.scale);
        let support = samples.weigh(&z_bar, &data.scale, |squared| epanechnikov(squared, h));
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
    fn an_order_in_leaps_holds_every_place_once() {
        for count in [0, 1, 2, 5, 6, 42, 97, 730] {
            let mut places: Vec<usize> = leap_order(count, 0..count / 3).collect();
            places.extend(leap_order(count, count / 3..count));
            places.sort_unstable();
            assert!(places.into_iter().eq(0..count));
        }
    }

    #[test]
    fn fits_do_not_depend_on_where_the_search_begins() {
        let config = RegressionConfig { laps: 0, ..RegressionConfig::default() };
        let mut rng = rand_pcg::Pcg64::seed_from_u64(3);
        let mut any = || rng.random_range(-1.0..1.0);
        let mut target =
            || Target { z: [(); DIMENSIONS].map(|()| any()), y: [any(), any(), any()] };
        let (mut data, mut scratch) = (RegressionData::new(&config), Scratch::new(&config, 3));
        for count in [0, 150, 90, 200] {
            (0..count).for_each(|_| data.add(target()));
            for t in 0..20 {
                let z = target().z;
                // The one begins where it was before, the other anywhere.
                let fit = data.fit(t % 4, &z, &config, &mut scratch);
                assert_eq!(fit, data.fit(0, &z, &config, &mut Scratch::new(&config, 0)));
                assert_eq!(fit.1 > 0.0, !data.samples.is_empty());
            }
        }
    }
}
