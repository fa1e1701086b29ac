//! Complementarity of the rows: w z = mu, gap w of each row and its multiplier z.
//!
//! Newton's step on `a'v + w = b`, `w z = target` for a row with residual `r = a'v + w - b`, its
//! first equation regularised to `a'dv + dw - delta dz = -r`:
//!
//! ```text
//! dw     = delta dz - r - a'dv
//! z + dz = pull + sigma a'dv
//! sigma  = z / (w + delta z)
//! pull   = (target - dw_aff dz_aff + z (r + delta z)) / (w + delta z)
//! ```
//!
//! so a row adds `sigma a a'` to the Hessian and `pull a` to the gradient. Without delta the
//! curvature of an active row grows without bound (as 1 / mu), and with it the rounding errors of
//! the Riccati recursion; with it, sigma stays below 1 / delta. What is left of r vanishes with
//! dz: the point of convergence is not moved.

use std::ops::Range;

use super::columns::{each, greatest};
use vector_sums::{dot, sum};

/// Lanes of a search for the greatest.
const LANES: usize = 4;
/// Parts of a corrector that are tried.
const PARTS: usize = 4;

/// Rows as flat arrays of one length.
#[derive(Debug, Clone, Default)]
pub(super) struct Barrier {
    /// Gaps, positive.
    pub(super) w: Vec<f64>,
    /// Multipliers, positive.
    pub(super) z: Vec<f64>,
    /// Right-hand sides.
    pub(super) b: Vec<f64>,
    /// a'v + w - b.
    pub(super) r: Vec<f64>,
    /// Image a'v of the iterate or a'dv of the direction.
    pub(super) image: Vec<f64>,
    /// Curvature z / w.
    pub(super) sigma: Vec<f64>,
    /// Gradient's coefficient.
    pub(super) pull: Vec<f64>,
    /// Scale of each row.
    pub(super) width: Vec<f64>,
    /// Regularisation of each row.
    pub(super) delta: Vec<f64>,
    inverse: Vec<f64>,
    inverse_w: Vec<f64>,
    inverse_z: Vec<f64>,
    dw: Vec<f64>,
    dz: Vec<f64>,
    /// dw and dz of the predictor.
    kept_dw: Vec<f64>,
    kept_dz: Vec<f64>,
}

impl Barrier {
    pub(super) fn resize(&mut self, rows: usize) {
        for values in [
            &mut self.w,
            &mut self.z,
            &mut self.b,
            &mut self.r,
            &mut self.image,
            &mut self.sigma,
            &mut self.pull,
            &mut self.width,
            &mut self.delta,
            &mut self.inverse,
            &mut self.inverse_w,
            &mut self.inverse_z,
            &mut self.dw,
            &mut self.dz,
            &mut self.kept_dw,
            &mut self.kept_dz,
        ] {
            values.resize(rows, 0.0);
        }
    }

    /// Sum of w z: the duality gap of a feasible point.
    #[inline(always)]
    pub(super) fn gap(&self) -> f64 {
        dot(&self.w, &self.z)
    }

    /// Residuals from the image of the iterate; returns the greatest.
    #[inline(always)]
    pub(super) fn residuals(&mut self) -> f64 {
        each(&mut self.r, [&self.image, &self.w, &self.b], |[image, w, b]| image + w - b);
        greatest(&self.r, 0.0)
    }

    /// Curvature of the penalty 1/2 weight ((a'v - b) / width)^2 on each row.
    #[inline(always)]
    pub(super) fn penalise(&mut self, weight: f64) {
        for (sigma, width) in self.sigma.iter_mut().zip(&self.width) {
            *sigma = weight / (width * width);
        }
    }

    /// Pull of that penalty, from the image.
    #[inline(always)]
    pub(super) fn pull_back(&mut self) {
        let rows = self.image.iter().zip(&self.b).zip(&self.sigma);
        for (pull, ((image, b), sigma)) in self.pull.iter_mut().zip(rows) {
            *pull = sigma * (image - b);
        }
    }

    /// Gaps of some rows from the image, no less than `least` of the width, and multipliers mu / w.
    #[inline(always)]
    pub(super) fn enter(&mut self, rows: Range<usize>, least: f64, mu: f64) {
        for i in rows {
            self.w[i] = (self.b[i] - self.image[i]).max(least * self.width[i]);
            self.z[i] = mu / self.w[i];
        }
    }

    /// sigma, and the pull of the predictor (target 0).
    #[inline(always)]
    pub(super) fn predict(&mut self) {
        let rows = self.w.iter().zip(&self.z).zip(&self.r).zip(&self.delta);
        let out = self.inverse.iter_mut().zip(&mut self.sigma).zip(&mut self.pull);
        for ((((w, z), r), delta), ((inverse, sigma), pull)) in rows.zip(out) {
            *inverse = 1.0 / (w + delta * z);
            *sigma = z * *inverse;
            *pull = *sigma * (r + delta * z);
        }
        for (inverse, w) in self.inverse_w.iter_mut().zip(&self.w) {
            *inverse = 1.0 / w;
        }
        for (inverse, z) in self.inverse_z.iter_mut().zip(&self.z) {
            *inverse = 1.0 / z;
        }
    }

    /// The pull of the corrector; `second` weights the second-order term of the direction that was
    /// kept.
    #[inline(always)]
    pub(super) fn correct(&mut self, target: f64, second: f64) {
        let rows =
            self.kept_dw.iter().zip(&self.kept_dz).zip(&self.z).zip(&self.r).zip(&self.delta);
        for (((((dw, dz), z), r), delta), (pull, inverse)) in
            rows.zip(self.pull.iter_mut().zip(&self.inverse))
        {
            *pull = (target - second * dw * dz + z * (r + delta * z)) * inverse;
        }
    }

    /// dw and dz from the image of the direction.
    #[inline(always)]
    pub(super) fn direction(&mut self) {
        let rows = self.image.iter().zip(&self.r).zip(&self.z).zip(&self.sigma).zip(&self.pull);
        for ((((((image, r), z), sigma), pull), delta), (dw, dz)) in
            rows.zip(&self.delta).zip(self.dw.iter_mut().zip(&mut self.dz))
        {
            *dz = pull + sigma * image - z;
            *dw = delta * *dz - r - image;
        }
    }

    /// Greatest step in [0, 1] that keeps w and z from crossing 0.
    #[inline(always)]
    pub(super) fn step(&self) -> f64 {
        // Greatest of -dw/w and -dz/z in independent lanes, so that it can be vectorised.
        let mut worst = [1.0; LANES];
        let rows = self.w.len() / LANES * LANES;
        let inverses = self.inverse_w.chunks_exact(LANES).zip(self.inverse_z.chunks_exact(LANES));
        let steps = self.dw.chunks_exact(LANES).zip(self.dz.chunks_exact(LANES));
        for ((w, z), (dw, dz)) in inverses.zip(steps) {
            for l in 0..LANES {
                let (primal, dual) = (-dw[l] * w[l], -dz[l] * z[l]);
                let ratio = if primal > dual { primal } else { dual };
                worst[l] = if ratio > worst[l] { ratio } else { worst[l] };
            }
        }
        let mut greatest = worst.iter().copied().fold(1.0, f64::max);
        for i in rows..self.w.len() {
            let (primal, dual) = (-self.dw[i] * self.inverse_w[i], -self.dz[i] * self.inverse_z[i]);
            greatest = greatest.max(primal).max(dual);
        }
        1.0 / greatest
    }

    /// Keeps the direction in place, which is to be replaced.
    #[inline(always)]
    pub(super) fn keep(&mut self) {
        std::mem::swap(&mut self.kept_dw, &mut self.dw);
        std::mem::swap(&mut self.kept_dz, &mut self.dz);
    }

    /// The direction that is `part` of the way from the one that was kept to the one in place.
    #[inline(always)]
    pub(super) fn blend(&mut self, part: f64) {
        for (d, kept) in self.dw.iter_mut().zip(&self.kept_dw) {
            *d = kept + part * (*d - kept);
        }
        for (d, kept) in self.dz.iter_mut().zip(&self.kept_dz) {
            *d = kept + part * (*d - kept);
        }
    }

    /// The part, among some from `least` to less than 1, with the longest step of [`Barrier::blend`],
    /// and that step.
    #[inline(always)]
    pub(super) fn longest(&self, least: f64) -> (f64, f64) {
        let parts: [f64; PARTS] =
            std::array::from_fn(|i| least + (1.0 - least) * (i as f64 / PARTS as f64));
        let mut worst = [[1.0_f64; LANES]; PARTS];
        let whole = self.w.len() / LANES * LANES;
        let mut compare = |i: usize, lane: usize| {
            let (primal, dual) =
                (-self.kept_dw[i] * self.inverse_w[i], -self.kept_dz[i] * self.inverse_z[i]);
            let more = (self.kept_dw[i] - self.dw[i]) * self.inverse_w[i];
            let more_dual = (self.kept_dz[i] - self.dz[i]) * self.inverse_z[i];
            for (worst, part) in worst.iter_mut().zip(&parts) {
                let (primal, dual) = (primal + part * more, dual + part * more_dual);
                let ratio = if primal > dual { primal } else { dual };
                worst[lane] = if ratio > worst[lane] { ratio } else { worst[lane] };
            }
        };
        for i in whole..self.w.len() {
            compare(i, 0);
        }
        let inverses = self.inverse_w.chunks_exact(LANES).zip(self.inverse_z.chunks_exact(LANES));
        let kept = self.kept_dw.chunks_exact(LANES).zip(self.kept_dz.chunks_exact(LANES));
        let steps = self.dw.chunks_exact(LANES).zip(self.dz.chunks_exact(LANES));
        for (((w, z), (kept_w, kept_z)), (dw, dz)) in inverses.zip(kept).zip(steps) {
            let [mut primal, mut dual, mut more, mut more_dual] = [[0.0; LANES]; 4];
            for l in 0..LANES {
                primal[l] = -kept_w[l] * w[l];
                dual[l] = -kept_z[l] * z[l];
                more[l] = (kept_w[l] - dw[l]) * w[l];
                more_dual[l] = (kept_z[l] - dz[l]) * z[l];
            }
            for (worst, part) in worst.iter_mut().zip(&parts) {
                for l in 0..LANES {
                    let (primal, dual) =
                        (primal[l] + part * more[l], dual[l] + part * more_dual[l]);
                    let ratio = if primal > dual { primal } else { dual };
                    worst[l] = if ratio > worst[l] { ratio } else { worst[l] };
                }
            }
        }
        let steps = worst.map(|worst| 1.0 / worst.into_iter().fold(1.0, f64::max));
        let longer = |best, i| if steps[i] > steps[best] { i } else { best };
        let best = (1..PARTS).fold(0, longer);
        (parts[best], steps[best])
    }

    /// The gap after a step, from that before it.
    #[inline(always)]
    pub(super) fn gap_after(&self, gap: f64, step: f64) -> f64 {
        let mut sums = [0.0; 2 * LANES];
        let (w, z) = (self.w.chunks_exact(2 * LANES), self.z.chunks_exact(2 * LANES));
        let (dw, dz) = (self.dw.chunks_exact(2 * LANES), self.dz.chunks_exact(2 * LANES));
        let (rest, rest_d) =
            (w.remainder().iter().zip(z.remainder()), dw.remainder().iter().zip(dz.remainder()));
        let change = |w: f64, z: f64, dw: f64, dz: f64| w * dz + dw * (z + step * dz);
        let last: f64 = rest.zip(rest_d).map(|((w, z), (dw, dz))| change(*w, *z, *dw, *dz)).sum();
        for ((w, z), (dw, dz)) in w.zip(z).zip(dw.zip(dz)) {
            for l in 0..2 * LANES {
                sums[l] += change(w[l], z[l], dw[l], dz[l]);
            }
        }
        gap + step * (sum(&sums) + last)
    }

    /// Takes the step.
    #[inline(always)]
    pub(super) fn advance(&mut self, step: f64) {
        for (w, dw) in self.w.iter_mut().zip(&self.dw) {
            *w += step * dw;
        }
        for (z, dz) in self.z.iter_mut().zip(&self.dz) {
            *z += step * dz;
        }
    }
}
