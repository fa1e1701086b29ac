//! Iterates of the interior-point method and their barrier.

use crate::interval::{Defect, NZ, Node};
use crate::problem::{Evaluation, Expansion, Problem};

use super::filter::Point;

/// How far variables start from their bounds, absolutely and as a share of their range.
const PUSH: f64 = 1e-2;
/// Bounds on the ratio of a multiplier to the one its slack implies.
const MULTIPLIER_RANGE: f64 = 1e8;

/// Primal and dual variables.
#[derive(Debug, Clone)]
pub(crate) struct Iterate {
    /// Nodes, scaled.
    pub(crate) z: Vec<Node>,
    /// Slacks of the inequalities, above 0.
    pub(crate) s: Vec<f64>,
    /// Multipliers of the defects.
    pub(crate) lambda: Vec<Defect>,
    /// Multipliers of the inequalities, above 0.
    pub(crate) y: Vec<f64>,
    /// Multipliers of the bounds, above 0; 0 where there is none.
    pub(crate) on_lower: Vec<Node>,
    pub(crate) on_upper: Vec<Node>,
}

/// A step of all variables.
#[derive(Debug, Clone)]
pub(crate) struct Step {
    pub(crate) z: Vec<Node>,
    pub(crate) s: Vec<f64>,
    pub(crate) lambda: Vec<Defect>,
    pub(crate) y: Vec<f64>,
    pub(crate) on_lower: Vec<Node>,
    pub(crate) on_upper: Vec<Node>,
}

/// Where a run starts: nodes, scaled, and multipliers if it goes on from a solution.
#[derive(Debug, Clone)]
pub(crate) struct Start {
    pub(crate) z: Vec<Node>,
    pub(crate) multipliers: Option<Multipliers>,
}

/// Multipliers of a solution.
#[derive(Debug, Clone)]
pub(crate) struct Multipliers {
    pub(crate) lambda: Vec<Defect>,
    pub(crate) y: Vec<f64>,
    pub(crate) on_lower: Vec<Node>,
    pub(crate) on_upper: Vec<Node>,
}

/// The nodes of a start moved into the interior of the bounds: as far as the barrier `mu` keeps
/// them away where multipliers are known.
pub(crate) fn inside(problem: &Problem, start: &Start, mu: f64) -> Vec<Node> {
    let mut z = start.z.clone();
    for (k, z) in z.iter_mut().enumerate() {
        for i in 0..NZ {
            let (lower, upper) = (problem.lower[k][i], problem.upper[k][i]);
            let room = |bound: f64, side: fn(&Multipliers) -> &[Node]| {
                let push = match &start.multipliers {
                    Some(known) => (mu / side(known)[k][i].max(f64::MIN_POSITIVE)).min(PUSH),
                    None => PUSH,
                };
                (push * bound.abs().max(1.0)).min(0.5 * push * (upper - lower))
            };
            if lower.is_finite() {
                z[i] = z[i].max(lower + room(lower, |known| &known.on_lower));
            }
            if upper.is_finite() {
                z[i] = z[i].min(upper - room(upper, |known| &known.on_upper));
            }
        }
    }
    z
}

impl Iterate {
    /// An iterate at interior nodes with multipliers of the barrier `mu`.
    pub(crate) fn new(
        problem: &Problem,
        z: Vec<Node>,
        values: &Evaluation,
        start: &Start,
        mu: f64,
    ) -> Self {
        let least = |i: usize| match &start.multipliers {
            Some(known) => (mu / known.y[i].max(f64::MIN_POSITIVE)).min(PUSH),
            None => mu.min(PUSH),
        };
        let s: Vec<f64> =
            values.inequalities.iter().enumerate().map(|(i, g)| g.max(least(i))).collect();
        let y = s.iter().map(|s| mu / s).collect();
        let n = z.len();
        let zero = vec![Node::zeros(); n];
        let lambda = match &start.multipliers {
            Some(known) => known.lambda.clone(),
            None => vec![Defect::zeros(); n],
        };
        let mut out = Self { z, s, lambda, y, on_lower: zero.clone(), on_upper: zero };
        out.reset_multipliers(problem, mu);
        out
    }

    /// Multipliers of bounds and inequalities as the barrier implies them.
    pub(crate) fn reset_multipliers(&mut self, problem: &Problem, mu: f64) {
        for (y, s) in self.y.iter_mut().zip(&self.s) {
            *y = mu / s;
        }
        for k in 0..self.z.len() {
            for i in 0..NZ {
                let (below, above) = self.room(problem, k, i);
                self.on_lower[k][i] = mu / below;
                self.on_upper[k][i] = mu / above;
            }
        }
    }

    /// Distances of a variable from its bounds.
    pub(crate) fn room(&self, problem: &Problem, k: usize, i: usize) -> (f64, f64) {
        (self.z[k][i] - problem.lower[k][i], problem.upper[k][i] - self.z[k][i])
    }

    /// Infeasibility and barrier value.
    pub(crate) fn point(&self, problem: &Problem, values: &Evaluation, mu: f64) -> Point {
        let mut logs = self.s.iter().map(|s| s.ln()).sum::<f64>();
        for k in 0..self.z.len() {
            for i in 0..NZ {
                let (below, above) = self.room(problem, k, i);
                if below.is_finite() {
                    logs += below.ln();
                }
                if above.is_finite() {
                    logs += above.ln();
                }
            }
        }
        Point { infeasibility: self.infeasibility(values), barrier: values.cost - mu * logs }
    }

    /// Sum of all violations.
    pub(crate) fn infeasibility(&self, values: &Evaluation) -> f64 {
        let defects: f64 = values.defects.iter().map(|d| d.abs().sum()).sum();
        let rest: f64 = values.inequalities.iter().zip(&self.s).map(|(g, s)| (g - s).abs()).sum();
        defects + rest
    }

    /// Largest length in (0, 1] along a step that keeps the share 1 - `tau` of every distance from
    /// a bound, for the primal and for the dual variables.
    pub(crate) fn lengths(&self, problem: &Problem, step: &Step, tau: f64) -> (f64, f64) {
        let limit = |room: f64, change: f64, length: &mut f64| {
            if change < 0.0 && room.is_finite() {
                *length = length.min(-tau * room / change);
            }
        };
        let (mut primal, mut dual) = (1.0, 1.0);
        for k in 0..self.z.len() {
            for i in 0..NZ {
                let (below, above) = self.room(problem, k, i);
                limit(below, step.z[k][i], &mut primal);
                limit(above, -step.z[k][i], &mut primal);
                limit(self.on_lower[k][i], step.on_lower[k][i], &mut dual);
                limit(self.on_upper[k][i], step.on_upper[k][i], &mut dual);
            }
        }
        for i in 0..self.s.len() {
            limit(self.s[i], step.s[i], &mut primal);
            limit(self.y[i], step.y[i], &mut dual);
        }
        (primal, dual)
    }

    /// The primal variables at `length` along a step; the dual ones unchanged.
    pub(crate) fn moved(&self, step: &Step, length: f64) -> Self {
        let mut out = self.clone();
        for (z, dz) in out.z.iter_mut().zip(&step.z) {
            *z += dz * length;
        }
        for (s, ds) in out.s.iter_mut().zip(&step.s) {
            *s += ds * length;
        }
        out
    }

    /// Moves the dual variables, and keeps those of bounds near what the barrier implies.
    pub(crate) fn move_duals(
        &mut self,
        problem: &Problem,
        step: &Step,
        primal: f64,
        dual: f64,
        mu: f64,
    ) {
        for (lambda, change) in self.lambda.iter_mut().zip(&step.lambda) {
            *lambda += change * primal;
        }
        let near = |value: f64, room: f64| {
            if room.is_finite() {
                value.clamp(mu / (MULTIPLIER_RANGE * room), MULTIPLIER_RANGE * mu / room)
            } else {
                0.0
            }
        };
        for i in 0..self.y.len() {
            self.y[i] = near(self.y[i] + dual * step.y[i], self.s[i]);
        }
        for k in 0..self.z.len() {
            for i in 0..NZ {
                let (below, above) = self.room(problem, k, i);
                self.on_lower[k][i] = near(self.on_lower[k][i] + dual * step.on_lower[k][i], below);
                self.on_upper[k][i] = near(self.on_upper[k][i] + dual * step.on_upper[k][i], above);
            }
        }
    }

    /// Gradient of the Lagrangian by the nodes, `y` and the bounds' multipliers included.
    pub(crate) fn stationarity(&self, problem: &Problem, at: &Expansion) -> Vec<Node> {
        let mut out = at.gradient.clone();
        let rules = problem.rules.len();
        for k in 0..out.len() {
            let ends = [k, problem.after(k)];
            out[k] += self.on_upper[k] - self.on_lower[k];
            for (end, slopes) in ends.into_iter().zip(&at.defects[k]) {
                out[end] += slopes.transpose() * self.lambda[k];
            }
            for index in k * rules..(k + 1) * rules {
                for (end, slope) in ends.into_iter().zip(&at.inequalities[index]) {
                    out[end] -= slope * self.y[index];
                }
            }
        }
        out
    }

    /// Largest violation of the optimality conditions of the barrier problem `mu`.
    pub(crate) fn error(&self, problem: &Problem, at: &Expansion, mu: f64) -> f64 {
        let largest = |nodes: &[Node]| nodes.iter().fold(0.0_f64, |most, n| most.max(n.amax()));
        let n = self.z.len();
        let (mut bounds, mut count) = (0.0, 0.0);
        let mut slackness = 0.0_f64;
        let mut take = |room: f64, multiplier: f64| {
            if room.is_finite() {
                slackness = slackness.max((room * multiplier - mu).abs());
                bounds += multiplier;
                count += 1.0;
            }
        };
        for k in 0..n {
            for i in 0..NZ {
                let (below, above) = self.room(problem, k, i);
                take(below, self.on_lower[k][i]);
                take(above, self.on_upper[k][i]);
            }
        }
        for (s, y) in self.s.iter().zip(&self.y) {
            take(*s, *y);
        }
        let duals: f64 = self.lambda.iter().map(|l| l.abs().sum()).sum();
        #[expect(clippy::cast_precision_loss, reason = "counts of nodes")]
        let equations = 5.0 * n as f64;
        let by_duals = ((duals + bounds) / (equations + count)).max(100.0) / 100.0;
        let by_bounds = (bounds / count).max(100.0) / 100.0;
        let defects = at.values.defects.iter().fold(0.0_f64, |most, d| most.max(d.amax()));
        let rest = at.values.inequalities.iter().zip(&self.s);
        let infeasible = rest.fold(defects, |most, (g, s)| most.max((g - s).abs()));
        (largest(&self.stationarity(problem, at)) / by_duals)
            .max(infeasible)
            .max(slackness / by_bounds)
    }
}
