//! The inequality rows a' v + w = b, w >= 0 of the FHOCP, stage by stage.
//!
//! A row acts on the inputs, states, slacks and hull weights of a [`Point`], which may be an
//! iterate or a direction: [`Rows::image`] is linear, all constants stand in [`Rows::bounds`].
//!
//! Rows of stage t, in order: input box (4), rate limits (2 per limited input), then per soft
//! constraint on a quantity y with slack s: `y - s <= high`, `-y - s <= -low`, `-s <= 0` (the
//! speed cap has no lower side). After all stages: `-lambda_j <= 0`.

use nalgebra::{Vector2, Vector6};
use vehicle_model::NU;

use super::super::layout::Shape;
use super::super::{Fhocp, SlipRow};

/// Number of kinds of soft constraints.
pub(super) const SOFT: usize = 4;
/// Lane, on e_y of x_{t+1}.
pub(super) const LANE: usize = 0;
/// Rear slip angle, on x_{t+1}.
pub(super) const REAR: usize = 1;
/// Speed cap, on v_x of x_{t+1}.
pub(super) const SPEED: usize = 2;
/// Front slip angle, on x_t and u_t.
pub(super) const FRONT: usize = 3;

/// Least width of a row: a corridor may be closed, or turned inside out, by a wide margin.
const LEAST_WIDTH: f64 = 1e-2;

/// Iterate or direction: x_0..x_N, u_0..u_{N-1}, slacks of each stage, lambda.
#[derive(Debug, Clone, Default)]
pub(super) struct Point {
    pub(super) x: Vec<Vector6<f64>>,
    pub(super) u: Vec<Vector2<f64>>,
    pub(super) s: Vec<[f64; SOFT]>,
    pub(super) lambda: Vec<f64>,
}

impl Point {
    pub(super) fn resize(&mut self, shape: &Shape) {
        self.x.resize(shape.horizon + 1, Vector6::zeros());
        self.u.resize(shape.horizon, Vector2::zeros());
        self.s.resize(shape.horizon, [0.0; SOFT]);
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
            for k in 0..SOFT {
                s[k] = kept[k] + (s[k] - kept[k]) * part;
            }
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
            for k in 0..SOFT {
                s[k] += step * ds[k];
            }
        }
        for (lambda, step_of) in self.lambda.iter_mut().zip(&direction.lambda) {
            *lambda += step * step_of;
        }
    }
}

/// Where the rows of a shape stand.
#[derive(Debug, Clone, Copy)]
pub(super) struct Rows {
    pub(super) shape: Shape,
    /// Rows of one stage.
    stride: usize,
    /// First row of each limited rate within its stage.
    rate: [Option<usize>; NU],
    /// First row of each soft constraint present within its stage.
    soft: [Option<usize>; SOFT],
}

impl Rows {
    pub(super) fn of(shape: Shape) -> Self {
        let mut stride = 2 * NU;
        let mut place = |present: bool, rows: usize| {
            let first = stride;
            stride += if present { rows } else { 0 };
            present.then_some(first)
        };
        let rate = shape.rate.map(|limited| place(limited, 2));
        let soft =
            [place(true, 3), place(shape.rear, 3), place(shape.speed, 2), place(shape.front, 3)];
        Self { shape, stride, rate, soft }
    }

    /// Number of rows.
    pub(super) fn count(&self) -> usize {
        self.hull() + self.shape.hull
    }

    /// First row of the hull weights.
    pub(super) fn hull(&self) -> usize {
        self.shape.horizon * self.stride
    }

    /// Rows of stage t.
    #[inline(always)]
    pub(super) fn stage<'a>(&self, t: usize, values: &'a [f64]) -> &'a [f64] {
        &values[t * self.stride..(t + 1) * self.stride]
    }

    /// Sum over both signs of each rate's rows, and their difference; 0 for an unlimited rate.
    #[inline(always)]
    pub(super) fn rate(&self, stage: &[f64], i: usize) -> (f64, f64) {
        self.rate[i].map_or((0.0, 0.0), |r| (stage[r] + stage[r + 1], stage[r] - stage[r + 1]))
    }

    /// Values of the rows (high, low, slack) of soft constraint k, if it is present.
    #[inline(always)]
    pub(super) fn soft(&self, stage: &[f64], k: usize) -> Option<[f64; 3]> {
        let first = self.soft[k]?;
        Some(if k == SPEED {
            [stage[first], 0.0, stage[first + 1]]
        } else {
            [stage[first], stage[first + 1], stage[first + 2]]
        })
    }

    /// a' v of every row; `u_before` is the input before u_0 (zero for a direction).
    #[inline(always)]
    pub(super) fn image(
        &self,
        problem: &Fhocp,
        point: &Point,
        u_before: Vector2<f64>,
        out: &mut [f64],
    ) {
        let (stages, hull) = out.split_at_mut(self.hull());
        let mut v = u_before;
        for (t, out) in stages.chunks_exact_mut(self.stride).enumerate() {
            let u = point.u[t];
            let y = quantities(problem, t, &point.x[t], &u, &point.x[t + 1]);
            for i in 0..NU {
                out[2 * i] = u[i];
                out[2 * i + 1] = -u[i];
                if let Some(r) = self.rate[i] {
                    out[r] = u[i] - v[i];
                    out[r + 1] = v[i] - u[i];
                }
            }
            let s = &point.s[t];
            for k in 0..SOFT {
                self.write(out, k, [y[k] - s[k], -y[k] - s[k], -s[k]]);
            }
            v = u;
        }
        for (out, lambda) in hull.iter_mut().zip(&point.lambda) {
            *out = -lambda;
        }
    }

    /// b of every row.
    #[inline(always)]
    pub(super) fn bounds(&self, problem: &Fhocp, out: &mut [f64]) {
        let (stages, hull) = out.split_at_mut(self.hull());
        for (t, out) in stages.chunks_exact_mut(self.stride).enumerate() {
            let [least, greatest] = problem.box_of(t);
            self.inputs(out, [greatest, -least], problem.du_max);
            self.write(out, LANE, [problem.e_y_max[t], -problem.e_y_min[t], 0.0]);
            for (k, row, max) in [
                (REAR, &problem.rear[t], problem.rear_max * problem.rear_share[t]),
                (FRONT, &problem.front[t], problem.front_max),
            ] {
                self.write(out, k, [max - row.offset, max + row.offset, 0.0]);
            }
            self.write(out, SPEED, [problem.speed_max[t], 0.0, 0.0]);
        }
        hull.fill(0.0);
    }

    /// The width of what each row bounds, its scale; that of the hull weights is their mean.
    #[inline(always)]
    pub(super) fn widths(&self, problem: &Fhocp, out: &mut [f64]) {
        let (stages, hull) = out.split_at_mut(self.hull());
        let range = problem.u_max - problem.u_min;
        for (t, out) in stages.chunks_exact_mut(self.stride).enumerate() {
            self.inputs(out, [range, range], problem.du_max * 2.0);
            self.write(out, LANE, [problem.e_y_max[t] - problem.e_y_min[t]; 3]);
            self.write(out, REAR, [2.0 * problem.rear_max * problem.rear_share[t]; 3]);
            self.write(out, FRONT, [2.0 * problem.front_max; 3]);
            self.write(out, SPEED, [problem.speed_max[t]; 3]);
            for width in out {
                *width = width.abs().max(LEAST_WIDTH);
            }
        }
        hull.fill(1.0 / self.shape.hull as f64);
    }

    #[inline(always)]
    fn inputs(&self, stage: &mut [f64], box_rows: [Vector2<f64>; 2], rate: Vector2<f64>) {
        for i in 0..NU {
            stage[2 * i] = box_rows[0][i];
            stage[2 * i + 1] = box_rows[1][i];
            if let Some(r) = self.rate[i] {
                stage[r] = rate[i];
                stage[r + 1] = rate[i];
            }
        }
    }

    #[inline(always)]
    fn write(&self, stage: &mut [f64], k: usize, [high, low, slack]: [f64; 3]) {
        let Some(first) = self.soft[k] else { return };
        stage[first] = high;
        if k == SPEED {
            stage[first + 1] = slack;
        } else {
            stage[first + 1] = low;
            stage[first + 2] = slack;
        }
    }
}

/// The quantities y of stage t's soft constraints, without their constant parts.
#[inline(always)]
pub(super) fn quantities(
    problem: &Fhocp,
    t: usize,
    x: &Vector6<f64>,
    u: &Vector2<f64>,
    next: &Vector6<f64>,
) -> [f64; SOFT] {
    let along = |row: &SlipRow, x: &Vector6<f64>| {
        row.velocity[0] * x[0] + row.velocity[1] * x[1] + row.velocity[2] * x[2]
    };
    let (front, rear) = (&problem.front[t], &problem.rear[t]);
    [next[5], along(rear, next), next[0], along(front, x) + front.steering * u[1]]
}
