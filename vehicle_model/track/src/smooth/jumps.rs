//! A curve near noisy points whose curvature changes in few places, as that of straights and arcs
//! does.
//!
//! A penalty of one strength everywhere spreads a jump of the curvature over its own length. Here
//! every knot j has a variance v_j of its own for the step of the curvature across it, and the
//! points decide on all of them by the evidence for them (MacKay, Neural Computation 4, 1992;
//! Tipping, JMLR 1, 2001): most v_j go to zero, and the curvature is constant there. The curve is
//! an offset e(t) along the normal of the smooth curve; to first order in e its curvature is
//! kappa + e'' + kappa^2 e, so that the estimate is one banded linear system a round.

use super::curve::{ACTIVE, Curve, Grid, Row};
use super::cyclic::Cyclic;

/// Rounds, and how many of them take the slow but safe step of the variances.
const ROUNDS: (usize, usize) = (40, 6);
/// Least variance, in variances that let the curvature drift by its largest value in a lap.
const LEAST: f64 = 1e-6;
/// Variance to begin with, in the same unit.
const FIRST: f64 = 4.0;
/// Share of a variance that is at least taken as decided by the points.
const DECIDED: f64 = 1e-3;
/// Noise is sought within this factor of that of the smooth curve.
const NOISE: f64 = 2.0;
/// Newton steps to the foot of a point.
const FOOT_STEPS: usize = 6;

/// The offset from a smooth curve.
#[derive(Debug, Clone)]
pub(super) struct Offset {
    coefficients: Vec<f64>,
    /// Degrees of freedom of the curve.
    pub freedom: f64,
    /// Standard deviation of the points from the curve [m].
    pub noise: f64,
    /// Largest distance of a point from the curve [m].
    pub largest: f64,
}

/// Values in six splines that follow one another around the lap.
type Six = [f64; ACTIVE];

/// The equations of the offset.
struct Equations {
    grid: Grid,
    /// The splines at each point's foot.
    rows: Vec<Row>,
    /// Distance of each point from the smooth curve, positive to the left.
    distance: Vec<f64>,
    /// Step of the smooth curve's curvature from each knot to the next.
    step: Vec<f64>,
    /// The step of the offset's curvature there, in the splines from the knot's number on.
    change: Vec<Six>,
    /// Largest curvature of the smooth curve.
    kappa: f64,
}

/// The frame of a curve at t: unit tangent, curvature, speed.
fn frame(curve: &Curve, t: f64) -> ((f64, f64), f64, f64) {
    let ((x, y), (xx, yy)) = (curve.tangent(t), curve.bend(t));
    let speed = (x * x + y * y).sqrt();
    ((x / speed, y / speed), (x * yy - y * xx) / (speed * speed * speed), speed)
}

/// Parameter of the point of the curve nearest to (x, y), begun at t, at most a spacing a step.
fn foot(curve: &Curve, (x, y): (f64, f64), mut t: f64, spacing: f64) -> f64 {
    let end = curve.grid.end();
    for _ in 0..FOOT_STEPS {
        let (place, first, second) = (curve.point(t), curve.tangent(t), curve.bend(t));
        let (dx, dy) = (x - place.0, y - place.1);
        let square = first.0 * first.0 + first.1 * first.1;
        let stretch = (square - (dx * second.0 + dy * second.1)).max(0.3 * square);
        let step = (dx * first.0 + dy * first.1) / stretch;
        t = (t + step.clamp(-spacing, spacing)).rem_euclid(end);
    }
    t
}

impl Equations {
    /// The equations around a smooth curve near the points, whose places on it are about t.
    fn new(curve: &Curve, points: &[(f64, f64)], t: &[f64]) -> Self {
        let grid = curve.grid;
        let spacing = grid.end() / points.len() as f64;
        let feet: Vec<f64> =
            points.iter().zip(t).map(|(&p, &t)| foot(curve, p, t, spacing)).collect();
        let distance = points.iter().zip(&feet).map(|(p, &t)| {
            let (place, (tangent, ..)) = (curve.point(t), frame(curve, t));
            tangent.0 * (p.1 - place.1) - tangent.1 * (p.0 - place.0)
        });
        let mut kappas = Vec::with_capacity(grid.count);
        let curvature: Vec<Six> = (0..grid.count)
            .map(|j| {
                let t = j as f64 * grid.interval;
                let (_, kappa, speed) = frame(curve, t);
                kappas.push(kappa);
                let (value, bend) = (grid.knot_row(), grid.knot_bend());
                std::array::from_fn(|k| bend[k] / (speed * speed) + kappa * kappa * value[k])
            })
            .collect();
        let next = |j: usize| (j + 1) % grid.count;
        let change = (0..grid.count).map(|j| {
            let (own, after) = (&curvature[j], &curvature[next(j)]);
            std::array::from_fn(|k| if k > 0 { after[k - 1] } else { 0.0 } - own[k])
        });
        Self {
            grid,
            rows: feet.iter().map(|&t| grid.row(t)).collect(),
            distance: distance.collect(),
            step: (0..grid.count).map(|j| kappas[next(j)] - kappas[j]).collect(),
            change: change.collect(),
            kappa: kappas.iter().fold(0.0, |most, kappa| kappa.abs().max(most)),
        }
    }

    /// Numbers of the splines that the change at a knot has.
    fn splines(&self, j: usize) -> [usize; ACTIVE] {
        std::array::from_fn(|k| (j + k) % self.grid.count)
    }

    /// Factor of the equations, and the coefficients, for a weight of each knot's step.
    fn solve(&self, weights: &[f64]) -> (Cyclic, Vec<f64>) {
        let count = self.grid.count;
        let mut a = Cyclic::zero(count, ACTIVE - 1);
        let mut b = vec![0.0; count];
        let mut add = |entries: &[(usize, f64)], weight: f64, value: f64| {
            for (k, (i, c)) in entries.iter().enumerate() {
                b[*i] += weight * c * value;
                for (j, d) in &entries[..=k] {
                    a.add(*i, *j, weight * c * d);
                }
            }
        };
        for (row, distance) in self.rows.iter().zip(&self.distance) {
            add(&row.entries(count), 1.0, *distance);
        }
        for (j, change) in self.change.iter().enumerate() {
            let splines = self.splines(j);
            let entries: [(usize, f64); ACTIVE] = std::array::from_fn(|k| (splines[k], change[k]));
            add(&entries, weights[j], -self.step[j]);
        }
        let factor = a.factor();
        factor.solve(&mut b);
        (factor, b)
    }

    /// Sum and largest of the squared distances of the points from the curve.
    fn squares(&self, coefficients: &[f64]) -> (f64, f64) {
        self.rows
            .iter()
            .zip(&self.distance)
            .map(|(row, distance)| {
                let left = distance - row.times(coefficients);
                left * left
            })
            .fold((0.0, 0.0), |(sum, most), square| (sum + square, square.max(most)))
    }
}

/// The form c' Z c of six numbers with the entries of Z at their places.
fn form(z: &Cyclic, places: [usize; ACTIVE], c: &Six) -> f64 {
    let mut sum = 0.0;
    for k in 0..ACTIVE {
        for l in 0..k {
            sum += 2.0 * c[k] * c[l] * z.entry(places[k], places[l]);
        }
        sum += c[k] * c[k] * z.entry(places[k], places[k]);
    }
    sum
}

/// The offset of a curve whose curvature changes in few places, from a smooth curve near the
/// points with this noise [m]; none for a straight line.
pub(super) fn offset(
    curve: &Curve,
    points: &[(f64, f64)],
    t: &[f64],
    noise: f64,
) -> Option<Offset> {
    let equations = Equations::new(curve, points, t);
    let count = equations.grid.count;
    let unit = equations.kappa * equations.kappa / count as f64;
    if !(unit > 0.0 && noise > 0.0) {
        return None;
    }
    let least = LEAST * unit;
    let mut variances = vec![FIRST * unit; count];
    let mut square = noise * noise;
    let mut offset = None;
    for round in 0..ROUNDS.0 {
        let weights: Vec<f64> = variances.iter().map(|v| square / v).collect();
        let (factor, coefficients) = equations.solve(&weights);
        let z = factor.inverse();
        for (j, variance) in variances.iter_mut().enumerate() {
            let (places, change) = (equations.splines(j), &equations.change[j]);
            let own: f64 = places.iter().zip(change).map(|(&i, c)| c * coefficients[i]).sum();
            let step = equations.step[j] + own;
            let uncertain = square * form(&z, places, change);
            *variance = if round < ROUNDS.1 {
                step * step + uncertain
            } else {
                step * step / (1.0 - uncertain / *variance).clamp(DECIDED, 1.0)
            };
            *variance = variance.max(least);
        }
        let freedom: f64 = equations
            .rows
            .iter()
            .map(|row| form(&z, row.entries(count).map(|(i, _)| i), row.values()))
            .sum();
        let (squares, largest) = equations.squares(&coefficients);
        let range = (noise * noise / (NOISE * NOISE), noise * noise * NOISE * NOISE);
        square = (squares / (points.len() as f64 - freedom).max(1.0)).clamp(range.0, range.1);
        let (noise, largest) = (square.sqrt(), largest.sqrt());
        offset = Some(Offset { coefficients, freedom, noise, largest });
    }
    offset.filter(|offset| offset.coefficients.iter().all(|c| c.is_finite()))
}

impl Offset {
    /// Point of the curve at t.
    pub(super) fn point(&self, curve: &Curve, t: f64) -> (f64, f64) {
        let ((x, y), (tangent, ..)) = (curve.point(t), frame(curve, t));
        let e = curve.grid.row(t).times(&self.coefficients);
        (x - e * tangent.1, y + e * tangent.0)
    }

    /// Tangent of the curve at t, not normalised.
    pub(super) fn tangent(&self, curve: &Curve, t: f64) -> (f64, f64) {
        let ((x, y), kappa, speed) = frame(curve, t);
        let e = curve.grid.row(t).times(&self.coefficients);
        let slope = curve.grid.slope(t).times(&self.coefficients);
        let along = speed * (1.0 - kappa * e);
        (along * x - slope * y, along * y + slope * x)
    }
}
