//! Newton's system of one stage, its slacks eliminated.
//!
//! A soft constraint on y with slack s has the penalty `l s + q s^2` and the rows high, low and
//! slack with curvatures `h`, `g`, `k` (their sigma) and pulls `h'`, `g'`, `k'`. Its part of the
//! system is
//!
//! ```text
//! [ h + g    g - h         ] [dy]     [ h' - g'                    ]
//! [ g - h    2q + h + g + k ] [ds] = - [ l + 2 q s - h' - g' - k'  ]
//! ```
//!
//! and eliminating ds leaves the curvature `((h + g)(2q + k) + 4 h g) / (2q + h + g + k)` on y,
//! written so that no two large numbers are subtracted.

use nalgebra::{Vector2, Vector6};
use vehicle_model::NU;

use super::super::Fhocp;
use super::rows::{FRONT, LANE, REAR, Rows, SOFT, SPEED};

/// Hessian of a stage: all of it is diagonal in the right quantities.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Curvature {
    /// On u_t: cost and box.
    pub(super) input: Vector2<f64>,
    /// On u_t - u_{t-1}: cost and rate limits.
    pub(super) rate: Vector2<f64>,
    /// On each soft quantity.
    pub(super) soft: [f64; SOFT],
    /// (g - h) / (2q + h + g + k) of each slack.
    cross: [f64; SOFT],
    /// 1 / (2q + h + g + k) of each slack.
    inverse: [f64; SOFT],
}

/// Gradient of a stage.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Gradient {
    /// On u_t: cost and box.
    pub(super) input: Vector2<f64>,
    /// On u_t - u_{t-1}: cost and rate limits.
    pub(super) rate: Vector2<f64>,
    /// On each soft quantity.
    pub(super) soft: [f64; SOFT],
    /// On each slack.
    pub(super) slack: [f64; SOFT],
}

/// Penalty l s + q s^2 of each slack.
#[inline(always)]
pub(super) fn penalty(problem: &Fhocp) -> [(f64, f64); SOFT] {
    let mut penalty = [(0.0, 0.0); SOFT];
    penalty[LANE] = (problem.lane_linear, problem.lane_quadratic);
    penalty[REAR] = (problem.slip_linear, 0.0);
    penalty[SPEED] = (problem.speed_linear, 0.0);
    penalty[FRONT] = (problem.slip_linear, 0.0);
    penalty
}

impl Curvature {
    /// Curvature of a stage from the sigma of its rows.
    #[inline(always)]
    pub(super) fn of(problem: &Fhocp, t: usize, rows: &Rows, sigma: &[f64]) -> Self {
        let mut out = Self::default();
        for i in 0..NU {
            out.input[i] = 2.0 * problem.input_cost[i] + sigma[2 * i] + sigma[2 * i + 1];
            out.rate[i] = 2.0 * problem.rate_cost[i] + rows.rate(sigma, i).0;
        }
        for (k, (_, quadratic)) in penalty(problem).into_iter().enumerate() {
            if let Some([h, g, slack]) = rows.soft(sigma, k) {
                let own = 2.0 * quadratic + slack;
                out.inverse[k] = 1.0 / (own + h + g);
                out.cross[k] = (g - h) * out.inverse[k];
                out.soft[k] = ((h + g) * own + 4.0 * h * g) * out.inverse[k];
            }
        }
        out.soft[REAR] += 2.0 * problem.rear[t].weight;
        out.soft[FRONT] += 2.0 * problem.front[t].weight;
        out
    }

    /// The gradient with the slacks eliminated.
    #[inline(always)]
    pub(super) fn eliminate(&self, gradient: &mut Gradient) {
        for k in 0..SOFT {
            gradient.soft[k] -= self.cross[k] * gradient.slack[k];
        }
    }

    /// Steps of the slacks, from those of the soft quantities.
    #[inline(always)]
    pub(super) fn slacks(&self, gradient: &Gradient, dy: &[f64; SOFT]) -> [f64; SOFT] {
        std::array::from_fn(|k| -self.inverse[k] * gradient.slack[k] - self.cross[k] * dy[k])
    }
}

/// Where a stage's gradient is taken.
pub(super) struct At {
    /// Input of the stage.
    pub(super) u: Vector2<f64>,
    /// Input of the stage before.
    pub(super) u_before: Vector2<f64>,
    /// Slacks.
    pub(super) s: [f64; SOFT],
    /// Soft quantities without their constant parts.
    pub(super) y: [f64; SOFT],
}

impl Gradient {
    /// Gradient of the Lagrangian of a stage, given the multipliers (or pulls) of its rows.
    #[inline(always)]
    pub(super) fn of(problem: &Fhocp, t: usize, rows: &Rows, multipliers: &[f64], at: &At) -> Self {
        let At { u, u_before, s, y } = at;
        let mut out = Self::default();
        for i in 0..NU {
            out.input[i] =
                2.0 * problem.input_cost[i] * u[i] + multipliers[2 * i] - multipliers[2 * i + 1];
            out.rate[i] =
                2.0 * problem.rate_cost[i] * (u[i] - u_before[i]) + rows.rate(multipliers, i).1;
        }
        for (k, (linear, quadratic)) in penalty(problem).into_iter().enumerate() {
            if let Some([high, low, slack]) = rows.soft(multipliers, k) {
                out.soft[k] = high - low;
                out.slack[k] = linear + 2.0 * quadratic * s[k] - (high + low + slack);
            }
        }
        for (k, row) in [(REAR, &problem.rear[t]), (FRONT, &problem.front[t])] {
            out.soft[k] += row.pull(y[k] + row.offset);
        }
        out
    }

    /// The part of stage t on x_{t+1}.
    #[inline(always)]
    pub(super) fn next_state(&self, problem: &Fhocp, t: usize) -> Vector6<f64> {
        let rear = problem.rear[t].velocity.map(|g| g * self.soft[REAR]);
        Vector6::new(rear[0] + self.soft[SPEED], rear[1], rear[2], 0.0, 0.0, self.soft[LANE])
    }

    /// The part of stage t on x_t, from the front slip angle.
    #[inline(always)]
    pub(super) fn state(&self, problem: &Fhocp, t: usize) -> Vector6<f64> {
        let front = problem.front[t].velocity.map(|g| g * self.soft[FRONT]);
        Vector6::new(front[0], front[1], front[2], 0.0, 0.0, 0.0)
    }

    /// The part on u_t, the rate apart.
    #[inline(always)]
    pub(super) fn input(&self, problem: &Fhocp, t: usize) -> Vector2<f64> {
        let front = problem.front[t].steering * self.soft[FRONT];
        self.input + Vector2::new(0.0, front)
    }
}
