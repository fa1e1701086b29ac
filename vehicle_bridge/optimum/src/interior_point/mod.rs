//! A primal-dual interior-point method with a filter line search (Waechter and Biegler, On the
//! implementation of an interior-point filter line-search algorithm for large-scale nonlinear
//! programming, Mathematical Programming 106, 2006), with exact second derivatives. Each step is
//! one sparse factorisation.

mod filter;
mod iterate;
mod kkt;
mod newton;

use crate::interval::Node;
use crate::problem::{Expansion, Problem};

use filter::{Filter, Verdict};
use iterate::{Iterate, Step, inside};
pub(crate) use iterate::{Multipliers, Start};
use newton::Newton;

/// How a run is made.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Settings {
    /// Largest violation of the scaled optimality conditions.
    pub(crate) tolerance: f64,
    /// Barrier parameter of the first step.
    pub(crate) mu: f64,
    /// Most steps.
    pub(crate) steps: usize,
}

/// Where a run ended.
#[derive(Debug, Clone)]
pub(crate) struct Solved {
    pub(crate) z: Vec<Node>,
    pub(crate) multipliers: Multipliers,
    /// Violation of the scaled optimality conditions.
    pub(crate) error: f64,
    pub(crate) cost: f64,
    pub(crate) steps: usize,
    pub(crate) converged: bool,
}

impl Solved {
    /// A start from here.
    pub(crate) fn start(&self) -> Start {
        Start { z: self.z.clone(), multipliers: Some(self.multipliers.clone()) }
    }
}

/// Violation that will do where steps no longer improve it.
const ACCEPTABLE: f64 = 1e-5;
/// Steps below it in a row after which the run ends.
const ACCEPTABLE_STEPS: usize = 12;
/// Barrier parameter that is always reached.
const LEAST_BARRIER: f64 = 1e-5;
/// Barrier problems are solved to this multiple of their parameter.
const BARRIER_SHARE: f64 = 10.0;
/// Share of distances from bounds that a step may use up.
const LEAST_TAU: f64 = 0.99;

/// Solves a problem from its nodes, scaled.
pub(crate) fn solve(problem: &Problem, start: &Start, settings: &Settings) -> Option<Solved> {
    Run::new(problem, start, settings)?.run()
}

struct Run<'a> {
    problem: &'a Problem,
    settings: &'a Settings,
    newton: Newton,
    filter: Filter,
    mu: f64,
    x: Iterate,
    at: Expansion,
}

impl<'a> Run<'a> {
    fn new(problem: &'a Problem, start: &Start, settings: &'a Settings) -> Option<Self> {
        let mu = settings.mu;
        let z = inside(problem, start, mu);
        let values = problem.values(&z)?;
        let x = Iterate::new(problem, z, &values, start, mu);
        let filter = Filter::new(x.infeasibility(&values));
        let at = problem.expand(&x.z);
        let mut newton = Newton::new(problem.len());
        let known = start.multipliers.is_some();
        let lambda = (!known).then(|| newton.multipliers(problem, &x, &at));
        let mut run = Self { problem, settings, newton, filter, mu, x, at };
        if let Some(lambda) = lambda {
            run.x.lambda = lambda;
        }
        Some(run)
    }

    fn run(mut self) -> Option<Solved> {
        let mut acceptable = 0;
        for steps in 0..self.settings.steps {
            let error = self.x.error(self.problem, &self.at, 0.0);
            if !error.is_finite() {
                return None;
            }
            acceptable = if error < ACCEPTABLE { acceptable + 1 } else { 0 };
            if error <= self.settings.tolerance || acceptable > ACCEPTABLE_STEPS {
                return Some(self.done(error, steps, true));
            }
            self.lower_barrier();
            if !self.advance() {
                let error = self.x.error(self.problem, &self.at, 0.0);
                let converged = error < self.most();
                return Some(self.done(error, steps, converged));
            }
        }
        let error = self.x.error(self.problem, &self.at, 0.0);
        let steps = self.settings.steps;
        let converged = error < self.most();
        Some(self.done(error, steps, converged))
    }

    /// Violation below which the end of a run is a solution.
    fn most(&self) -> f64 {
        ACCEPTABLE.max(self.settings.tolerance)
    }

    fn done(self, error: f64, steps: usize, converged: bool) -> Solved {
        let cost = self.at.values.cost;
        let Iterate { z, lambda, y, on_lower, on_upper, .. } = self.x;
        let multipliers = Multipliers { lambda, y, on_lower, on_upper };
        Solved { z, multipliers, error, cost, steps, converged }
    }

    /// Goes on to the next barrier problem where this one is solved.
    fn lower_barrier(&mut self) {
        let least = (0.1 * self.settings.tolerance).min(LEAST_BARRIER);
        while self.mu > least
            && self.x.error(self.problem, &self.at, self.mu) <= BARRIER_SHARE * self.mu
        {
            self.mu = (0.2 * self.mu).min(self.mu.powf(1.5)).max(least);
            self.filter.clear();
        }
    }

    /// Makes one step; false if there is none.
    fn advance(&mut self) -> bool {
        let Some((step, slope)) = self.newton.step(self.problem, &self.x, &self.at, self.mu) else {
            return self.restore();
        };
        let tau = LEAST_TAU.max(1.0 - self.mu);
        let (longest, dual) = self.x.lengths(self.problem, &step, tau);
        let from = self.x.point(self.problem, &self.at.values, self.mu);
        let shortest = self.filter.shortest(&from, slope);
        let mut length = longest;
        let mut first = true;
        while length >= shortest {
            let trial = self.x.moved(&step, length);
            if let Some(values) = self.problem.values(&trial.z) {
                let point = trial.point(self.problem, &values, self.mu);
                let verdict = self.filter.judge(&from, &point, slope, length);
                if verdict != Verdict::Refused {
                    if verdict == Verdict::ByFilter {
                        self.filter.add(&from);
                    }
                    self.take(trial, &step, length, dual);
                    return true;
                }
                if first
                    && point.infeasibility >= from.infeasibility
                    && self.correct(&step, slope, length, dual, &from, &values)
                {
                    return true;
                }
            }
            first = false;
            length *= 0.5;
        }
        // Steps too small to be judged near the solution are taken as they are.
        let size = step.z.iter().fold(0.0_f64, |most, dz| most.max(dz.amax()));
        if size * longest < 1e-10 {
            let trial = self.x.moved(&step, longest);
            self.take(trial, &step, longest, dual);
            return true;
        }
        self.restore()
    }

    /// Tries the step with its second-order correction.
    fn correct(
        &mut self,
        step: &Step,
        slope: f64,
        length: f64,
        dual: f64,
        from: &filter::Point,
        values: &crate::problem::Evaluation,
    ) -> bool {
        let Some(better) = self.newton.corrected(&self.x, &self.at, values, step, length, self.mu)
        else {
            return false;
        };
        let tau = LEAST_TAU.max(1.0 - self.mu);
        let (reach, _) = self.x.lengths(self.problem, &better, tau);
        let trial = self.x.moved(&better, reach);
        let Some(values) = self.problem.values(&trial.z) else { return false };
        let point = trial.point(self.problem, &values, self.mu);
        let verdict = self.filter.judge(from, &point, slope, length);
        if verdict == Verdict::Refused {
            return false;
        }
        if verdict == Verdict::ByFilter {
            self.filter.add(from);
        }
        self.take(trial, step, length, dual);
        true
    }

    fn take(&mut self, mut trial: Iterate, step: &Step, primal: f64, dual: f64) {
        trial.move_duals(self.problem, step, primal, dual, self.mu);
        self.x = trial;
        self.at = self.problem.expand(&self.x.z);
    }

    /// Steps towards feasibility alone until the filter admits the iterate.
    fn restore(&mut self) -> bool {
        let from = self.x.point(self.problem, &self.at.values, self.mu);
        if from.infeasibility < 1e-9 {
            return false;
        }
        self.filter.add(&from);
        for _ in 0..60 {
            let Some(step) = self.newton.towards_feasibility(self.problem, &self.x, &self.at)
            else {
                return false;
            };
            let (mut length, _) = self.x.lengths(self.problem, &step, LEAST_TAU);
            let now = self.x.infeasibility(&self.at.values);
            let trial = loop {
                if length < 1e-8 {
                    return false;
                }
                let trial = self.x.moved(&step, length);
                let left = self.problem.values(&trial.z).map(|v| trial.infeasibility(&v));
                if left.is_some_and(|left| left < (1.0 - 1e-4 * length) * now) {
                    break trial;
                }
                length *= 0.5;
            };
            self.x = trial;
            self.at = self.problem.expand(&self.x.z);
            let point = self.x.point(self.problem, &self.at.values, self.mu);
            if point.infeasibility < 0.5 * from.infeasibility && self.filter.admits(&point) {
                self.x.reset_multipliers(self.problem, self.mu);
                self.x.lambda = self.newton.multipliers(self.problem, &self.x, &self.at);
                return true;
            }
        }
        false
    }
}
