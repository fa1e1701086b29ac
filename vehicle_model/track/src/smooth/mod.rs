//! A smooth closed curve near noisy points: the penalised spline of O'Sullivan, and of Eilers and
//! Marx (Statistical Science 11, 1996), with the smoothing that the points themselves ask for.
//!
//! The curve r(t) minimises the sum of its squared distances from the points plus the integral of
//! lambda |r'''|^2, on a grid of quintic B-splines twice as dense as
//! the points. The penalty on
//! the third derivative leaves arcs nearly untouched: a wave of length 2 pi / w along the curve
//! keeps the share 1 / (1 + (lambda / h) w^6) of its height, h being the spacing of the points.
//! lambda is c h^5 with the spacing h of the neighbourhood, so that points set densely in bends
//! and sparsely on straights are smoothed alike.
//!
//! The strength c minimises the generalised cross-validation of Craven and Wahba (Numerische
//! Mathematik 31, 1979), degrees of freedom counted 1.4 times against its known bent to smooth
//! too little (Kim and Gu, JRSS B 66, 2004), and is at least 1: waves shorter than about six
//! spacings are not resolved by the points.

mod curve;
mod cyclic;
mod jumps;

use curve::{Curve, Grid, Row};
use cyclic::Cyclic;
use jumps::Offset;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// Splines per spacing of the points where they are dense.
const DENSITY: f64 = 2.0;
/// Share of the points that count as dense.
const DENSE: f64 = 0.1;
/// Most splines per point, and most splines where the points are fewer.
const MOST_SPLINES: (usize, usize) = (10, 100_000);
/// Entries of the equations reach this far from the diagonal.
const BAND: usize = curve::ACTIVE - 1;
/// Factor from one strength to the next: the fourth root of 10.
const STEP: f64 = 1.778_279_410_038_922_8;
/// Number of strengths, from 1 up to a million.
const STRENGTHS: usize = 25;
/// Steps below 1 in the search for a strength that moves the points by a given distance.
const WEAKER: usize = 60;
/// Weight of the degrees of freedom in the cross-validation.
const FREEDOM: f64 = 1.4;
/// Rounds in which the parameter becomes the arc length.
const ROUNDS: usize = 2;
/// Points on each side whose spacing makes that of the neighbourhood.
const NEIGHBOURS: usize = 3;
/// Numbers in all the random vectors that estimate the degrees of freedom, and the least and
/// the most vectors.
const PROBES: (usize, usize, usize) = (20_000, 2, 20);

/// The curve with few changes of curvature is taken if it has no more than this share of the
/// freedom of the smooth one and no less than this share of its noise: it explains as much of the
/// points with less.
const FEW: (f64, f64) = (0.5, 0.9);

/// How strongly points are smoothed.
#[derive(Debug, Clone, Copy)]
pub(super) enum Strength {
    /// As the points ask for, but no stronger than moves a point by this [m].
    Automatic(f64),
    /// So that the points move by this in the root mean square [m].
    Moves(f64),
}

/// A smooth curve and what it made of the points.
pub(super) struct Smoothed {
    curve: Curve,
    /// Offset from the curve, where its curvature changes in few places.
    offset: Option<Offset>,
    /// Parameter of each point.
    t: Vec<f64>,
    /// Standard deviation of the points from the curve, in each coordinate, corrected for the
    /// freedom of the curve [m].
    pub noise: f64,
    /// Share of a point's own error that the curve follows.
    pub leverage: f64,
}

impl Smoothed {
    /// The place on the curve of point i.
    pub(super) fn point(&self, i: usize) -> (f64, f64) {
        self.place(self.t[i])
    }

    /// Place of the curve at a parameter.
    fn place(&self, t: f64) -> (f64, f64) {
        self.offset.as_ref().map_or_else(|| self.curve.point(t), |o| o.point(&self.curve, t))
    }

    /// Tangent of the curve at point i, not normalised.
    pub(super) fn tangent(&self, i: usize) -> (f64, f64) {
        let (curve, t) = (&self.curve, self.t[i]);
        self.offset.as_ref().map_or_else(|| curve.tangent(t), |offset| offset.tangent(curve, t))
    }

    /// Places at equal steps of the parameter, one per spline, or two where the curvature jumps,
    /// each with the number of the point before it and the part of the way to the next.
    pub(super) fn resample(&self) -> Vec<((f64, f64), usize, f64)> {
        let count = self.curve.grid.count * if self.offset.is_some() { 2 } else { 1 };
        let end = self.curve.grid.end();
        let n = self.t.len();
        let mut i = 0;
        (0..count)
            .map(|k| {
                let t = end * k as f64 / count as f64;
                while i + 1 < n && self.t[i + 1] <= t {
                    i += 1;
                }
                let next = if i + 1 < n { self.t[i + 1] } else { end };
                (self.place(t), i, (t - self.t[i]) / (next - self.t[i]))
            })
            .collect()
    }
}

/// The equations of one parametrisation.
struct Fit<'p> {
    points: &'p [(f64, f64)],
    t: Vec<f64>,
    grid: Grid,
    rows: Vec<Row>,
    /// Weight of the third difference that begins at each spline, at the strength 1.
    penalty: Vec<f64>,
}

/// Distance of two points. Not hypot: its last bit depends on the platform.
fn distance(a: (f64, f64), b: (f64, f64)) -> f64 {
    let (x, y) = (b.0 - a.0, b.1 - a.1);
    (x * x + y * y).sqrt()
}

impl<'p> Fit<'p> {
    /// The equations with point i at the parameter t_i; `end` is that of the first point one lap
    /// later.
    fn new(points: &'p [(f64, f64)], t: Vec<f64>, end: f64) -> Self {
        let n = points.len();
        let reach = NEIGHBOURS.min(n / 2);
        let around: Vec<f64> = (0..n)
            .map(|i| {
                let (before, after) = (i + n - reach, i + n + reach);
                let lap = |k: usize| (k / n) as f64 * end + t[k % n];
                (lap(after) - lap(before)) / (after - before) as f64
            })
            .collect();
        let mut sorted = around.clone();
        sorted.sort_by(f64::total_cmp);
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let count = {
            let dense = sorted[(DENSE * n as f64) as usize];
            let most = (MOST_SPLINES.0 * n).min(MOST_SPLINES.1.max(n));
            ((DENSITY * end / dense).ceil() as usize).clamp(n, most)
        };
        let grid = Grid { count, interval: end / count as f64 };
        let rows = t.iter().map(|&t| grid.row(t)).collect();
        let mut i = 0;
        let penalty = (0..count)
            .map(|j| {
                let middle = (j as f64 + 0.5) * grid.interval;
                while i + 1 < n && t[i + 1] <= middle {
                    i += 1;
                }
                let ratio = around[i] / grid.interval;
                ratio * ratio * ratio * ratio * ratio
            })
            .collect();
        Self { points, t, grid, rows, penalty }
    }

    /// The factor of the equations at a strength.
    fn factor(&self, strength: f64) -> Cyclic {
        let count = self.grid.count;
        let mut a = Cyclic::zero(count, BAND);
        let mut add = |entries: &[(usize, f64)], weight: f64| {
            for (k, (i, b)) in entries.iter().enumerate() {
                for (j, c) in &entries[..=k] {
                    a.add(*i, *j, weight * b * c);
                }
            }
        };
        for row in &self.rows {
            add(&row.entries(count), 1.0);
        }
        for (j, weight) in self.penalty.iter().enumerate() {
            // The splines before and after the interval j are those from j + 1 to j + 4.
            let at = |k: usize| (j + k) % count;
            add(&[(at(1), -1.0), (at(2), 3.0), (at(3), -3.0), (at(4), 1.0)], strength * weight);
        }
        a.factor()
    }

    /// Coefficients of the curve nearest to a value at each point.
    fn coefficients(&self, factor: &Cyclic, value: impl Fn(usize) -> f64) -> Vec<f64> {
        let mut b = vec![0.0; self.grid.count];
        for (i, row) in self.rows.iter().enumerate() {
            for (j, weight) in row.entries(self.grid.count) {
                b[j] += weight * value(i);
            }
        }
        factor.solve(&mut b);
        b
    }

    /// The curve of a factor, and the sum of the squared distances of the points from it.
    fn curve(&self, factor: &Cyclic) -> (Curve, f64) {
        let x = self.coefficients(factor, |i| self.points[i].0);
        let y = self.coefficients(factor, |i| self.points[i].1);
        let squares = self
            .rows
            .iter()
            .zip(self.points)
            .map(|(row, p)| {
                let d = distance(*p, (row.times(&x), row.times(&y)));
                d * d
            })
            .sum();
        (Curve { grid: self.grid, x, y }, squares)
    }

    /// Largest distance of a point from the curve.
    fn largest(&self, curve: &Curve) -> f64 {
        let at = |row: &Row| (row.times(&curve.x), row.times(&curve.y));
        self.rows.iter().zip(self.points).map(|(row, p)| distance(*p, at(row))).fold(0.0, f64::max)
    }

    /// Degrees of freedom of the curve in each coordinate, estimated with random signs
    /// (Hutchinson, Communications in Statistics 18, 1989).
    fn freedom(&self, factor: &Cyclic) -> f64 {
        let n = self.rows.len();
        let probes = (PROBES.0 / n).clamp(PROBES.1, PROBES.2);
        let mut rng = Pcg64Mcg::seed_from_u64(1);
        let mut sum = 0.0;
        for _ in 0..probes {
            let signs: Vec<f64> =
                (0..n).map(|_| if rng.random::<bool>() { 1.0 } else { -1.0 }).collect();
            let c = self.coefficients(factor, |i| signs[i]);
            sum += self.rows.iter().zip(&signs).map(|(row, z)| z * row.times(&c)).sum::<f64>();
        }
        (sum / probes as f64).clamp(1.0, n as f64)
    }

    /// The strength with the least cross-validation among those that move no point further than
    /// `most`, and at least 1.
    fn automatic(&self, most: f64) -> f64 {
        let n = self.points.len() as f64;
        let mut strength = 1.0;
        let mut best = (f64::INFINITY, strength);
        for _ in 0..STRENGTHS {
            let factor = self.factor(strength);
            let (curve, squares) = self.curve(&factor);
            if strength > 1.0 && self.largest(&curve) > most {
                break;
            }
            let left = n - FREEDOM * self.freedom(&factor);
            if left > 0.0 {
                let score = squares / (left * left);
                if score < best.0 {
                    best = (score, strength);
                }
            }
            strength *= STEP;
        }
        best.1
    }

    /// The strength that moves the points by this in the root mean square, within a step.
    fn moving(&self, distance: f64) -> f64 {
        let wanted = distance * distance * self.points.len() as f64;
        let moves = |strength: f64| self.curve(&self.factor(strength)).1;
        let mut strength = 1.0;
        if moves(strength) > wanted {
            for _ in 0..WEAKER {
                strength /= STEP;
                if moves(strength) <= wanted {
                    break;
                }
            }
            return strength;
        }
        for _ in 1..STRENGTHS {
            if moves(strength * STEP) > wanted {
                break;
            }
            strength *= STEP;
        }
        strength
    }
}

/// Rise per metre of the smooth closed profile near heights \[m\] at places s \[m\], ascending and
/// distinct, of a lap of this length: at equal steps, as the heights themselves ask for.
pub(super) fn slopes(places: &[(f64, f64)], length: f64) -> Vec<(f64, f64)> {
    let heights: Vec<(f64, f64)> = places.iter().map(|(_, height)| (*height, 0.0)).collect();
    let Some((first, _)) = places.first() else { return Vec::new() };
    let fit = Fit::new(&heights, places.iter().map(|(s, _)| s - first).collect(), length);
    let (profile, _) = fit.curve(&fit.factor(fit.automatic(f64::INFINITY)));
    let at = |k: usize| k as f64 * fit.grid.interval;
    (0..fit.grid.count).map(|k| (first + at(k), fit.grid.slope(at(k)).times(&profile.x))).collect()
}

/// The smooth curve near distinct points, in the order of driving.
pub(super) fn smooth(points: &[(f64, f64)], strength: Strength) -> Smoothed {
    let n = points.len();
    let mut t = Vec::with_capacity(n);
    let mut end = 0.0;
    for (i, &p) in points.iter().enumerate() {
        t.push(end);
        end += distance(p, points[(i + 1) % n]);
    }
    let mut fit = Fit::new(points, t, end);
    let choose = |fit: &Fit<'_>| match strength {
        Strength::Automatic(most) => fit.automatic(most),
        Strength::Moves(distance) => fit.moving(distance),
    };
    let mut chosen = choose(&fit);
    for _ in 0..ROUNDS {
        let (curve, _) = fit.curve(&fit.factor(chosen));
        let lengths = curve.lengths();
        let t = fit.t.iter().map(|&t| curve.length_at(t, &lengths)).collect();
        fit = Fit::new(points, t, lengths[lengths.len() - 1]);
        chosen = choose(&fit);
    }
    let factor = fit.factor(chosen);
    let (curve, squares) = fit.curve(&factor);
    let freedom = fit.freedom(&factor);
    let noise = (0.5 * squares / (n as f64 - freedom).max(1.0)).sqrt();
    let offset = match strength {
        Strength::Automatic(most) => {
            jumps::offset(&curve, points, &fit.t, noise).filter(|offset| {
                let few = offset.freedom < FEW.0 * freedom && offset.noise > FEW.1 * noise;
                few && offset.largest <= most
            })
        }
        Strength::Moves(_) => None,
    };
    let (noise, freedom) =
        offset.as_ref().map_or((noise, freedom), |offset| (offset.noise, offset.freedom));
    Smoothed { curve, offset, t: fit.t, noise, leverage: freedom / n as f64 }
}
