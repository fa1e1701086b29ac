//! Newton steps of the barrier problem, convex by regularisation where they are not.

use crate::interval::{Block, Defect, NZ, Node};
use crate::problem::{Evaluation, Expansion, Hessian, Problem};

use super::iterate::{Iterate, Step};
use super::kkt::{Blocks, Kkt};

/// First, least and largest regularisation of the Hessian, and its growth.
const FIRST: f64 = 1e-3;
const LEAST: f64 = 1e-9;
const MOST: f64 = 1e12;
const GROWTH: f64 = 5.0;
const FALL: f64 = 0.25;
/// Regularisation below which none is tried first.
const NEGLIGIBLE: f64 = 1e-5;
/// Regularisation of the multipliers.
const DUAL: f64 = 1e-10;
/// Multipliers estimated above this are dropped.
const MOST_MULTIPLIER: f64 = 1e4;

/// Makes steps and remembers how much regularisation the last one needed.
pub(crate) struct Newton {
    kkt: Kkt,
    pub(crate) last: f64,
}

impl Newton {
    pub(crate) fn new(nodes: usize) -> Self {
        Self { kkt: Kkt::new(nodes), last: 0.0 }
    }

    /// The step of the barrier problem `mu` and the slope of its barrier value along it.
    pub(crate) fn step(
        &mut self,
        problem: &Problem,
        x: &Iterate,
        at: &Expansion,
        mu: f64,
    ) -> Option<(Step, f64)> {
        let mut hessian = problem.hessian(at, &x.lambda, &x.y);
        add_barrier(problem, x, at, &mut hessian);
        let rest = residuals(x, &at.values);
        let (r_z, r_c) = (right_side(problem, x, at, mu, &rest), minus(&at.values.defects));
        // Where the last step was regularised, so is this one most likely: no factors are wasted.
        let mut delta = if self.last > NEGLIGIBLE { FALL * self.last } else { 0.0 };
        while delta < MOST {
            let blocks = Blocks {
                nodes: &hessian.nodes,
                mixed: &hessian.mixed,
                defects: &at.defects,
                primal: delta,
                dual: DUAL,
            };
            if self.kkt.factorise(&blocks)
                && let Some((dz, dlambda)) = self.kkt.solve(&r_z, &r_c)
            {
                self.last = delta;
                let step = complete(problem, x, at, mu, &rest, dz, dlambda);
                let slope = slope(problem, x, at, mu, &step);
                return Some((step, slope));
            }
            delta = if delta > 0.0 {
                delta * GROWTH
            } else if self.last > 0.0 {
                (FALL * self.last).max(LEAST)
            } else {
                FIRST
            };
        }
        None
    }

    /// `step` corrected for the curvature of the constraints, seen in the `values` at `length`
    /// along it; with the factors of the last step.
    pub(crate) fn corrected(
        &mut self,
        x: &Iterate,
        at: &Expansion,
        values: &Evaluation,
        step: &Step,
        length: f64,
        mu: f64,
    ) -> Option<Step> {
        let _ = (x, at, mu);
        // Constraints at the trial point: only what is left of the equations is corrected.
        let r_c = minus(&values.defects);
        let r_z = vec![Node::zeros(); r_c.len()];
        let (dz, _) = self.kkt.solve(&r_z, &r_c)?;
        let mut better = step.clone();
        for (z, more) in better.z.iter_mut().zip(&dz) {
            *z = *z * length + more;
        }
        for s in &mut better.s {
            *s *= length;
        }
        Some(better)
    }

    /// A step that reduces the violation of all constraints, whatever the cost.
    pub(crate) fn towards_feasibility(
        &mut self,
        problem: &Problem,
        x: &Iterate,
        at: &Expansion,
    ) -> Option<Step> {
        let mut near = x.clone();
        near.reset_multipliers(problem, 1e-3);
        let unit = Block::identity() * 1e-2;
        let n = problem.len();
        let mut hessian = Hessian { nodes: vec![unit; n], mixed: vec![Block::zeros(); n] };
        add_barrier(problem, &near, at, &mut hessian);
        let rest = residuals(x, &at.values);
        let mut r_z = vec![Node::zeros(); n];
        add_inequalities(problem, at, &mut r_z, |i| -near.y[i] / near.s[i] * rest[i]);
        let blocks = Blocks {
            nodes: &hessian.nodes,
            mixed: &hessian.mixed,
            defects: &at.defects,
            primal: 0.0,
            dual: DUAL,
        };
        if !self.kkt.factorise(&blocks) {
            return None;
        }
        let (dz, dlambda) = self.kkt.solve(&r_z, &minus(&at.values.defects))?;
        Some(complete(problem, &near, at, 1e-3, &rest, dz, dlambda))
    }

    /// Multipliers of the defects that fit the other multipliers best (least squares).
    pub(crate) fn multipliers(
        &mut self,
        problem: &Problem,
        x: &Iterate,
        at: &Expansion,
    ) -> Vec<Defect> {
        let n = problem.len();
        let free = Iterate { lambda: vec![Defect::zeros(); n], ..x.clone() };
        let r_z: Vec<Node> = free.stationarity(problem, at).iter().map(|r| -r).collect();
        let blocks = Blocks {
            nodes: &vec![Block::identity(); n],
            mixed: &vec![Block::zeros(); n],
            defects: &at.defects,
            primal: 0.0,
            dual: DUAL,
        };
        let zeros = vec![Defect::zeros(); n];
        if !self.kkt.factorise(&blocks) {
            return zeros;
        }
        match self.kkt.solve(&r_z, &zeros) {
            Some((_, lambda)) if lambda.iter().all(|l| l.amax() < MOST_MULTIPLIER) => lambda,
            _ => zeros,
        }
    }
}

fn minus(defects: &[Defect]) -> Vec<Defect> {
    defects.iter().map(|d| -d).collect()
}

/// What is left of g - s = 0.
fn residuals(x: &Iterate, values: &Evaluation) -> Vec<f64> {
    values.inequalities.iter().zip(&x.s).map(|(g, s)| g - s).collect()
}

/// Adds `weight(i)` times the slope of inequality i.
fn add_inequalities(
    problem: &Problem,
    at: &Expansion,
    sum: &mut [Node],
    weight: impl Fn(usize) -> f64,
) {
    let rules = problem.rules.len();
    for k in 0..problem.len() {
        for index in k * rules..(k + 1) * rules {
            let [begin, end] = &at.inequalities[index];
            let weight = weight(index);
            sum[k] += begin * weight;
            sum[problem.after(k)] += end * weight;
        }
    }
}

/// Adds what bounds and inequalities contribute to the reduced Hessian.
fn add_barrier(problem: &Problem, x: &Iterate, at: &Expansion, hessian: &mut Hessian) {
    let rules = problem.rules.len();
    for k in 0..problem.len() {
        for i in 0..NZ {
            let (below, above) = x.room(problem, k, i);
            hessian.nodes[k][(i, i)] += x.on_lower[k][i] / below + x.on_upper[k][i] / above;
        }
        let next = problem.after(k);
        for index in k * rules..(k + 1) * rules {
            let weight = x.y[index] / x.s[index];
            let [begin, end] = &at.inequalities[index];
            let weighted = begin * weight;
            hessian.nodes[k] += weighted * begin.transpose();
            hessian.mixed[k] += weighted * end.transpose();
            hessian.nodes[next] += end * weight * end.transpose();
        }
    }
}

/// Right-hand side of the node rows.
fn right_side(problem: &Problem, x: &Iterate, at: &Expansion, mu: f64, rest: &[f64]) -> Vec<Node> {
    let mut out: Vec<Node> = at.gradient.iter().map(|g| -g).collect();
    for k in 0..out.len() {
        for (end, slopes) in [k, problem.after(k)].into_iter().zip(&at.defects[k]) {
            out[end] -= slopes.transpose() * x.lambda[k];
        }
        out[k] += Node::from_fn(|i, _| {
            let (below, above) = x.room(problem, k, i);
            mu / below - mu / above
        });
    }
    add_inequalities(problem, at, &mut out, |i| (mu - x.y[i] * rest[i]) / x.s[i]);
    out
}

/// The steps of the eliminated variables.
fn complete(
    problem: &Problem,
    x: &Iterate,
    at: &Expansion,
    mu: f64,
    rest: &[f64],
    z: Vec<Node>,
    lambda: Vec<Defect>,
) -> Step {
    let rules = problem.rules.len();
    let mut s = Vec::with_capacity(rest.len());
    let (mut on_lower, mut on_upper) = (x.on_lower.clone(), x.on_upper.clone());
    for k in 0..problem.len() {
        let own = k * rules..(k + 1) * rules;
        for ([begin, end], rest) in at.inequalities[own.clone()].iter().zip(&rest[own]) {
            s.push(begin.dot(&z[k]) + end.dot(&z[problem.after(k)]) + rest);
        }
        for i in 0..NZ {
            let (below, above) = x.room(problem, k, i);
            on_lower[k][i] = (mu - on_lower[k][i] * z[k][i]) / below - on_lower[k][i];
            on_upper[k][i] = (mu + on_upper[k][i] * z[k][i]) / above - on_upper[k][i];
        }
    }
    let y = (0..s.len()).map(|i| (mu - x.y[i] * s[i]) / x.s[i] - x.y[i]).collect();
    Step { z, s, lambda, y, on_lower, on_upper }
}

/// Slope of the barrier value along a step.
fn slope(problem: &Problem, x: &Iterate, at: &Expansion, mu: f64, step: &Step) -> f64 {
    let mut slope = 0.0;
    for (k, (gradient, dz)) in at.gradient.iter().zip(&step.z).enumerate() {
        slope += gradient.dot(dz);
        for i in 0..NZ {
            let (below, above) = x.room(problem, k, i);
            slope += mu * dz[i] * (1.0 / above - 1.0 / below);
        }
    }
    slope - x.s.iter().zip(&step.s).map(|(s, ds)| mu * ds / s).sum::<f64>()
}
