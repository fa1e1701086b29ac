//! The inequality rows a' v + w = b, w >= 0 of the FHOCP.
//!
//! A row acts on the inputs, states, slacks and hull weights of a [`Point`], which may be an
//! iterate or a direction: [`Rows::image`] is linear, all constants stand in [`Rows::bounds`].
//!
//! Each row bounds one of eight quantities q of a stage: the inputs, their rates, and those of the soft
//! constraints. Quantities stand in columns, stage after stage and column after column, and rows likewise,
//! all upper bounds first, then all lower ones, then those of the slacks:
//!
//! ```text
//! q - s <= high      -q - s <= -low      -s <= 0
//! ```
//!
//! without s for inputs and rates, and without a lower bound for the speed, which is the last of the columns
//! that have rows. So what is done to all of them is one loop over one array, which becomes vector
//! instructions. After them: `-lambda_j <= 0`.

use std::ops::Range;

use nalgebra::{Vector2, Vector6};
use vehicle_model::NU;

use super::super::layout::Shape;
use super::super::{Fhocp, SlipRow};
use super::columns::each;

/// Number of quantities of a stage that rows may bound.
pub(super) const QUANTITIES: usize = 8;
/// The inputs u_t.
pub(super) const INPUT: [usize; NU] = [0, 1];
/// Their differences u_t - u_{t-1}.
pub(super) const RATE: [usize; NU] = [2, 3];
/// Lane, on e_y and e_psi of x_{t+1}.
pub(super) const LANE: usize = 4;
/// Rear slip angle, on x_{t+1}.
pub(super) const REAR: usize = 5;
/// Front slip angle, on x_t and u_t.
pub(super) const FRONT: usize = 6;
/// Speed cap, on v_x of x_{t+1}.
pub(super) const SPEED: usize = 7;

/// Least width of a row: a corridor may be closed, or turned inside out, by a wide margin.
const LEAST_WIDTH: f64 = 1e-2;

/// Iterate or direction: x_0..x_N, u_0..u_{N-1}, slacks of each stage, lambda.
#[derive(Debug, Clone, Default)]
pub(super) struct Point {
    pub(super) x: Vec<Vector6<f64>>,
    pub(super) u: Vec<Vector2<f64>>,
    /// Slacks, column after column.
    pub(super) s: Vec<f64>,
    pub(super) lambda: Vec<f64>,
}

impl Point {
    pub(super) fn resize(&mut self, rows: &Rows) {
        let shape = rows.shape;
        self.x.resize(shape.horizon + 1, Vector6::zeros());
        self.u.resize(shape.horizon, Vector2::zeros());
        self.s.resize(rows.slacks().len(), 0.0);
        self.lambda.resize(shape.hull, 0.0);
    }

    /// Whether every entry is finite.
    #[inline(always)]
    pub(super) fn is_finite(&self) -> bool {
        // A factor of 0 leaves 0 of what is finite and NaN of the rest.
        let mut sum = 0.0;
        for (x, u) in self.x.iter().skip(1).zip(&self.u) {
            sum += x.sum() * 0.0 + u.sum() * 0.0;
        }
        for lambda in &self.lambda {
            sum += lambda * 0.0;
        }
        sum == 0.0
    }

    /// Copies without allocating.
    #[inline(always)]
    pub(super) fn copy(&mut self, other: &Self) {
        self.x.copy_from_slice(&other.x);
        self.u.copy_from_slice(&other.u);
        self.s.copy_from_slice(&other.s);
        self.lambda.copy_from_slice(&other.lambda);
    }

    /// self = other + part (self - other)
    #[inline(always)]
    pub(super) fn blend(&mut self, part: f64, other: &Self) {
        for (x, kept) in self.x.iter_mut().zip(&other.x) {
            *x = kept + (*x - kept) * part;
        }
        for (u, kept) in self.u.iter_mut().zip(&other.u) {
            *u = kept + (*u - kept) * part;
        }
        for (s, kept) in self.s.iter_mut().zip(&other.s) {
            *s = kept + (*s - kept) * part;
        }
        for (lambda, kept) in self.lambda.iter_mut().zip(&other.lambda) {
            *lambda = kept + (*lambda - kept) * part;
        }
    }

    /// self += step direction
    #[inline(always)]
    pub(super) fn advance(&mut self, step: f64, direction: &Self) {
        for (x, dx) in self.x.iter_mut().zip(&direction.x) {
            *x += dx * step;
        }
        for (u, du) in self.u.iter_mut().zip(&direction.u) {
            *u += du * step;
        }
        for (s, ds) in self.s.iter_mut().zip(&direction.s) {
            *s += step * ds;
        }
        for (lambda, step_of) in self.lambda.iter_mut().zip(&direction.lambda) {
            *lambda += step * step_of;
        }
    }
}

/// Where quantities and rows of a shape stand.
#[derive(Debug, Clone, Copy)]
pub(super) struct Rows {
    pub(super) shape: Shape,
    /// Column of each quantity; those without rows come last.
    column: [usize; QUANTITIES],
    /// Columns with an upper bound.
    high: usize,
    /// Columns with a lower one.
    low: usize,
    /// First of the columns with a slack, which reach to `high`.
    soft: usize,
}

impl Rows {
    pub(super) fn of(shape: Shape) -> Self {
        let [rate_0, rate_1] = shape.rate;
        let bounded = [true, true, rate_0, rate_1, true, shape.rear, shape.front, shape.speed];
        let high = bounded.into_iter().filter(|bounded| *bounded).count();
        let (mut next, mut next_free) = (0, high);
        let column = bounded.map(|bounded| {
            let place = if bounded { &mut next } else { &mut next_free };
            *place += 1;
            *place - 1
        });
        Self { shape, column, high, low: high - usize::from(shape.speed), soft: column[LANE] }
    }

    /// Number of rows.
    pub(super) fn count(&self) -> usize {
        self.hull() + self.shape.hull
    }

    /// First row of the hull weights.
    pub(super) fn hull(&self) -> usize {
        self.shape.horizon * (self.high + self.low + self.high - self.soft)
    }

    /// Numbers of all columns.
    pub(super) fn quantities(&self) -> usize {
        QUANTITIES * self.shape.horizon
    }

    /// Those of the columns with two bounds, and with one.
    #[inline(always)]
    pub(super) fn bounded(&self) -> [usize; 2] {
        [self.low * self.shape.horizon, self.high * self.shape.horizon]
    }

    /// Those of the columns with a slack.
    #[inline(always)]
    pub(super) fn slacks(&self) -> Range<usize> {
        self.soft * self.shape.horizon..self.high * self.shape.horizon
    }

    /// The column of a quantity.
    #[inline(always)]
    pub(super) fn column<'a>(&self, quantity: usize, values: &'a [f64]) -> &'a [f64] {
        &values[self.range(quantity)]
    }

    #[inline(always)]
    pub(super) fn range(&self, quantity: usize) -> Range<usize> {
        let n = self.shape.horizon;
        self.column[quantity] * n..(self.column[quantity] + 1) * n
    }

    /// Whether a quantity is bounded.
    pub(super) fn bounds(&self, quantity: usize) -> bool {
        self.column[quantity] < self.high
    }

    /// Rows of the upper bounds, the lower ones, the slacks and the hull weights.
    #[inline(always)]
    pub(super) fn split<'a>(&self, values: &'a [f64]) -> [&'a [f64]; 4] {
        let [low, high] = self.bounded();
        let (highs, rest) = values.split_at(high);
        let (lows, rest) = rest.split_at(low);
        let (slacks, hull) = rest.split_at(self.slacks().len());
        [highs, lows, slacks, hull]
    }

    #[inline(always)]
    fn split_mut<'a>(&self, values: &'a mut [f64]) -> [&'a mut [f64]; 4] {
        let [low, high] = self.bounded();
        let (highs, rest) = values.split_at_mut(high);
        let (lows, rest) = rest.split_at_mut(low);
        let (slacks, hull) = rest.split_at_mut(self.slacks().len());
        [highs, lows, slacks, hull]
    }

    /// a' v of every row, `q` being the quantities of the point.
    #[inline(always)]
    pub(super) fn image(&self, q: &[f64], point: &Point, out: &mut [f64]) {
        let [highs, lows, slacks, hull] = self.split_mut(out);
        let Range { start, end } = self.slacks();
        let lower = lows.len();
        each(&mut highs[..start], [&q[..start]], |[q]| q);
        each(&mut highs[start..], [&q[start..end], &point.s], |[q, s]| q - s);
        each(&mut lows[..start], [&q[..start]], |[q]| -q);
        each(&mut lows[start..], [&q[start..lower], &point.s], |[q, s]| -q - s);
        each(slacks, [&point.s], |[s]| -s);
        each(hull, [&point.lambda], |[lambda]| -lambda);
    }

    /// b of every row.
    #[inline(always)]
    pub(super) fn limits(&self, problem: &Fhocp, out: &mut [f64]) {
        let n = self.shape.horizon;
        let [highs, lows, slacks, hull] = self.split_mut(out);
        let mut write = |quantity: usize, t: usize, bounds: [f64; 2]| {
            let at = self.column[quantity] * n + t;
            if self.bounds(quantity) {
                highs[at] = bounds[0];
                if quantity != SPEED {
                    lows[at] = bounds[1];
                }
            }
        };
        for t in 0..n {
            let [least, greatest] = problem.box_of(t);
            for i in 0..NU {
                write(INPUT[i], t, [greatest[i], -least[i]]);
                write(RATE[i], t, [problem.du_max[i]; 2]);
            }
            write(LANE, t, [problem.e_y_max[t], -problem.e_y_min[t]]);
            for (quantity, row, max) in [
                (REAR, &problem.rear[t], problem.rear_max * problem.rear_share[t]),
                (FRONT, &problem.front[t], problem.front_max * problem.front_share[t]),
            ] {
                write(quantity, t, [max - row.offset, max + row.offset]);
            }
            write(SPEED, t, [problem.speed_max[t]; 2]);
        }
        slacks.fill(0.0);
        hull.fill(0.0);
    }

    /// The width of what each row bounds, its scale; that of the hull weights is their mean.
    #[inline(always)]
    pub(super) fn widths(&self, problem: &Fhocp, out: &mut [f64]) {
        let n = self.shape.horizon;
        let range = problem.u_max - problem.u_min;
        let [highs, lows, slacks, hull] = self.split_mut(out);
        let mut write = |quantity: usize, t: usize, width: f64| {
            if self.bounds(quantity) {
                highs[self.column[quantity] * n + t] = width.abs().max(LEAST_WIDTH);
            }
        };
        for t in 0..n {
            for i in 0..NU {
                write(INPUT[i], t, range[i]);
                write(RATE[i], t, problem.du_max[i] * 2.0);
            }
            write(LANE, t, problem.e_y_max[t] - problem.e_y_min[t]);
            write(REAR, t, 2.0 * problem.rear_max * problem.rear_share[t]);
            write(FRONT, t, 2.0 * problem.front_max * problem.front_share[t]);
            write(SPEED, t, problem.speed_max[t]);
        }
        lows.copy_from_slice(&highs[..lows.len()]);
        slacks.copy_from_slice(&highs[self.slacks()]);
        hull.fill(1.0 / self.shape.hull as f64);
    }

    /// The quantities of a point, without their constant parts; `u_before` is the input before u_0 (zero for
    /// a direction).
    #[inline(always)]
    pub(super) fn set(
        &self,
        problem: &Fhocp,
        point: &Point,
        u_before: Vector2<f64>,
        q: &mut [f64],
    ) {
        let along = |row: &SlipRow, x: &Vector6<f64>| {
            row.velocity[0] * x[0] + row.velocity[1] * x[1] + row.velocity[2] * x[2]
        };
        let n = self.shape.horizon;
        let at = self.column.map(|column| column * n);
        let (x, u) = (&point.x[..n + 1], &point.u[..n]);
        let (rear, front) = (&problem.rear[..n], &problem.front[..n]);
        let heading = &problem.lane_heading[..n];
        let mut v = u_before;
        for t in 0..n {
            let (u, next) = (&u[t], &x[t + 1]);
            q[at[0] + t] = u[0];
            q[at[1] + t] = u[1];
            q[at[2] + t] = u[0] - v[0];
            q[at[3] + t] = u[1] - v[1];
            q[at[LANE] + t] = next[5] + heading[t] * next[3];
            q[at[REAR] + t] = along(&rear[t], next);
            q[at[FRONT] + t] = along(&front[t], &x[t]) + front[t].steering * u[1];
            q[at[SPEED] + t] = next[0];
            v = *u;
        }
    }
}
