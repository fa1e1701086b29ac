//! Mehrotra's predictor-corrector: the iteration and when it ends.

use nalgebra::{Vector2, Vector6};

use super::super::layout::Shape;
use super::super::{Fhocp, Solution, SolveReport, SolveStatus, Termination};
use super::barrier::Barrier;
use super::columns::greatest;
use super::hull::Hull;
use super::recursion::{Gain, Model, backward, carry, costates, factor, forward};
use super::report;
use super::rows::{Point, RATE, Rows};
use super::stage::{Costs, Curvature, Gradient};

/// Part of the way to the boundary that a step leaves, at most.
const SHORT_OF_BOUNDARY: f64 = 0.01;
/// The same in units of the gap, where that is less: the last steps converge quadratically.
const SHORT_BY_GAP: f64 = 0.03;
/// If the predictor step is at least this long the corrector is skipped: its second-order term would be of
/// the size of the remaining gap.
const FULL: f64 = 0.999;
/// A step of the whole corrector shorter than this is tried with parts of it.
const WHOLE: f64 = 0.99;
/// Steps below this are tried again with more centring.
const SHORT: f64 = 0.2;
/// Centring of that second try.
const RECENTRING: f64 = 0.5;
/// Least gap aimed at, in units of the tolerance.
const LEAST_TARGET: f64 = 0.1;
/// Iterations without progress before giving up: the error is not the least so far, and the violation of
/// the rows no less than this part of the least. From a start that is far outside of the rows, gaps grow
/// until these are met.
const PATIENCE: u32 = 12;
const LESS_VIOLATED: f64 = 0.98;
/// Error below which a solution that missed the tolerance is still called almost solved.
const REDUCED_TOLERANCE: f64 = 1e-5;
/// A last step of the first input by more than this is followed by another: where the cost is flat
/// its gap says little of the input, and the input is what is applied. [m/s^2, rad]
const SETTLED: f64 = 3e-4;
/// Error below which an iterate is solved if the next one is worse and the first input has settled:
/// the rounding errors of a long horizon's costates then exceed what is left to gain.
const STALLED: f64 = 1e-5;
/// Weight of the dual residual among the errors.
const DUAL_SHARE: f64 = 0.01;

/// Gap or violation from which on the dual residual is not looked at: the iterate is no solution anyway.
const FAR: f64 = 1e-3;

/// How far an iterate is from the optimum.
#[derive(Debug, Clone, Copy)]
struct Residuals {
    /// Duality gap relative to the cost.
    gap: f64,
    /// Greatest violation of a row.
    primal: f64,
    /// Greatest entry of the Lagrangian's gradient.
    dual: f64,
}

impl Residuals {
    fn worst(&self) -> f64 {
        self.gap.max(self.primal).max(self.dual)
    }
}

/// Memory of one shape.
pub(super) struct Work {
    pub(super) rows: Rows,
    pub(super) point: Point,
    pub(super) direction: Point,
    best: Point,
    /// Direction of the predictor, and the gradients p of its backward pass.
    predicted: Point,
    predicted_gradient: Vec<Vector6<f64>>,
    pub(super) barrier: Barrier,
    /// Sum of w z of the iterate.
    gap: f64,
    pub(super) hull: Hull,
    pub(super) costs: Costs,
    curvature: Curvature,
    gradient: Gradient,
    /// Quantities that the rows bound: of the iterate and of the direction.
    pub(super) at: Vec<f64>,
    along: Vec<f64>,
    gains: Vec<Gain>,
    pub(super) models: Vec<Model>,
    /// Costates of x_1..x_N, and those a full step leads to.
    pub(super) costate: Vec<Vector6<f64>>,
    pub(super) costate_next: Vec<Vector6<f64>>,
}

impl Work {
    pub(super) fn new(shape: Shape) -> Self {
        let rows = Rows::of(shape);
        let mut work = Self {
            rows,
            point: Point::default(),
            direction: Point::default(),
            best: Point::default(),
            predicted: Point::default(),
            predicted_gradient: vec![Vector6::zeros(); shape.horizon],
            barrier: Barrier::default(),
            gap: 0.0,
            hull: Hull::default(),
            costs: Costs::default(),
            curvature: Curvature::default(),
            gradient: Gradient::default(),
            at: vec![0.0; rows.quantities()],
            along: vec![0.0; rows.quantities()],
            models: vec![Model::default(); shape.horizon],
            gains: vec![Gain::default(); shape.horizon],
            costate: vec![Vector6::zeros(); shape.horizon],
            costate_next: vec![Vector6::zeros(); shape.horizon],
        };
        let Work { point, direction, best, predicted, .. } = &mut work;
        for point in [point, direction, best, predicted] {
            point.resize(&rows);
        }
        work.costs.resize(&rows);
        work.curvature.resize(&rows);
        work.gradient.resize(&rows);
        work.barrier.resize(rows.count());
        work.hull.resize(shape.hull);
        work
    }

    /// Iterates from the start, which has to be prepared; the best iterate ends up in `best`.
    #[inline(always)]
    pub(super) fn solve(&mut self, problem: &Fhocp, termination: Termination) -> SolveReport {
        self.start(problem);
        let mut running = true;
        let mut least = f64::INFINITY;
        let (mut since, mut idle) = (0, 0);
        let mut least_violation = f64::INFINITY;
        let mut input_settled = false;
        let mut iterations = 0;
        while running {
            let residuals = self.residuals(problem);
            let error = if self.point.is_finite() { residuals.worst() } else { f64::NAN };
            if error < least {
                (least, since, idle) = (error, 0, 0);
                input_settled = iterations > 0 && self.direction.u[0].amax() <= SETTLED;
                self.best.copy(&self.point);
            } else {
                (since, idle) = (since + 1, idle + 1);
            }
            if residuals.primal < LESS_VIOLATED * least_violation {
                (least_violation, idle) = (residuals.primal, 0);
            }
            let settled = since > 0 || input_settled;
            if since > 0 && least <= STALLED && input_settled {
                break;
            }
            // An error that is not finite fails every comparison.
            if least <= termination.tolerance && settled || !error.is_finite() || idle > PATIENCE {
                break;
            }
            if iterations == termination.max_iterations {
                break;
            }
            iterations += 1;
            running = self.iterate(problem, termination);
        }
        let stalled = least <= STALLED && input_settled;
        let status = if least <= termination.tolerance || stalled {
            SolveStatus::Solved
        } else if least <= REDUCED_TOLERANCE {
            SolveStatus::AlmostSolved
        } else if least.is_finite() {
            SolveStatus::MaxIterations
        } else {
            SolveStatus::Numerical
        };
        report(status, iterations)
    }

    /// One predictor-corrector step; false if it broke down.
    #[inline(always)]
    fn iterate(&mut self, problem: &Fhocp, termination: Termination) -> bool {
        self.barrier.predict();
        if !self.condense(problem) {
            return false;
        }
        self.direction(problem, false);
        let rows = self.rows.count() as f64;
        let gap = self.gap;
        let mut step = self.barrier.step();
        if step < FULL {
            let centring = (self.barrier.gap_after(gap, step) / gap).powi(4);
            // Below the tolerance there is nothing to gain: smaller gaps only cost digits.
            let target = (centring * gap).max(LEAST_TARGET * termination.tolerance) / rows;
            step = self.correct(problem, target, step);
            if step < SHORT {
                // The second-order term misleads far from the central path: go back towards it.
                self.barrier.correct(target.max(RECENTRING * gap / rows), 0.0);
                self.direction(problem, false);
                step = self.barrier.step();
            }
        }
        step *= 1.0 - SHORT_OF_BOUNDARY.min(SHORT_BY_GAP * gap);
        let Point { x, u, .. } = &self.direction;
        costates(&self.gains, x, u, &mut self.costate_next);
        self.point.advance(step, &self.direction);
        self.barrier.advance(step);
        self.hull.advance(step);
        for (costate, next) in self.costate.iter_mut().zip(&self.costate_next) {
            *costate += (next - *costate) * step;
        }
        self.renormalise();
        true
    }

    /// Replaces the predictor in place by the corrector, or by as much of it as allows the longest step;
    /// returns that step. `predicted` is the step of the predictor.
    ///
    /// The second-order term is that of a whole predictor step; where only a part of it can be taken, a
    /// part of the term helps more (Colombo and Gondzio, 2008). Directions are affine in the pulls, so
    /// those between the two need no solve.
    #[inline(always)]
    fn correct(&mut self, problem: &Fhocp, target: f64, predicted: f64) -> f64 {
        std::mem::swap(&mut self.predicted, &mut self.direction);
        self.barrier.keep();
        for (kept, gain) in self.predicted_gradient.iter_mut().zip(&self.gains) {
            *kept = gain.gradient;
        }
        let nu_step = self.hull.nu_step;
        self.barrier.correct(target, 1.0);
        self.direction(problem, false);
        let whole = self.barrier.step();
        if whole >= WHOLE {
            return whole;
        }
        let (part, step) = self.barrier.longest(predicted * predicted);
        if step <= whole {
            return whole;
        }
        self.barrier.blend(part);
        self.direction.blend(part, &self.predicted);
        for (gain, kept) in self.gains.iter_mut().zip(&self.predicted_gradient) {
            gain.gradient = kept + (gain.gradient - kept) * part;
        }
        self.hull.nu_step = nu_step + (self.hull.nu_step - nu_step) * part;
        step
    }

    /// Eliminates the slacks and the hull, and factors the rest; false if it broke down.
    #[inline(always)]
    pub(super) fn condense(&mut self, problem: &Fhocp) -> bool {
        let hull = self.rows.hull();
        self.curvature.set(&self.costs, &self.rows, &self.barrier.sigma);
        if !self.hull.factor(&self.barrier.sigma[hull..]) {
            return false;
        }
        let curvature = (&self.rows, &self.curvature.on[..]);
        factor(problem, &self.models, curvature, &self.hull.p, &mut self.gains);
        true
    }

    /// Direction for the pulls in place; `defects` of the dynamics stand in `costate_next`.
    #[inline(always)]
    pub(super) fn direction(&mut self, problem: &Fhocp, defects: bool) {
        let hull = self.rows.hull();
        self.gradient.set(&self.costs, &self.rows, &self.barrier.pull);
        self.curvature.eliminate(&self.rows, &mut self.gradient);
        let terminal = self.hull.gradient(&problem.hull_cost, &self.barrier.pull[hull..]);
        let defect = defects.then_some(&self.costate_next[..]);
        backward(
            problem,
            &self.models,
            RATE.map(|rate| self.rows.column(rate, &self.curvature.on)),
            &self.gradient.stages(problem, &self.rows),
            defect,
            &terminal,
            &mut self.gains,
        );
        let Point { x, u, .. } = &mut self.direction;
        forward(problem, &self.models, &self.gains, defect, x, u);
        self.rows.set(problem, &self.direction, Vector2::zeros(), &mut self.along);
        let Point { x, s, lambda, .. } = &mut self.direction;
        self.curvature.slacks(&self.rows, &self.gradient, &self.along, s);
        self.hull.direction(&x[problem.horizon()], lambda);
        self.rows.image(&self.along, &self.direction, &mut self.barrier.image);
        self.barrier.direction();
    }

    /// The weights sum to 1 and are the gaps of their rows.
    #[inline(always)]
    pub(super) fn renormalise(&mut self) {
        let sum: f64 = self.point.lambda.iter().sum();
        let gaps = &mut self.barrier.w[self.rows.hull()..];
        for (lambda, gap) in self.point.lambda.iter_mut().zip(gaps) {
            *lambda /= sum;
            *gap = *lambda;
        }
    }

    /// The rows' image of the iterate, from its quantities.
    #[inline(always)]
    pub(super) fn image(&mut self, problem: &Fhocp) {
        self.rows.set(problem, &self.point, problem.u_prev, &mut self.at);
        self.rows.image(&self.at, &self.point, &mut self.barrier.image);
    }

    /// Residuals of the iterate, those of the rows left in place for the next step.
    #[inline(always)]
    fn residuals(&mut self, problem: &Fhocp) -> Residuals {
        let hull = self.rows.hull();
        self.image(problem);
        let primal = self.barrier.residuals();
        self.costs.set(&self.at, &self.point.s);
        self.hull.costate(&self.point.x[problem.horizon()], &self.point.lambda);
        let cost = self.hull.cost(&problem.hull_cost, &self.point.lambda)
            + self.costs.cost(&self.at, &self.point.s);
        self.gap = self.barrier.gap();
        let gap = self.gap / (1.0 + cost.abs());
        if gap > FAR || primal > FAR {
            return Residuals { gap, primal, dual: 0.0 };
        }
        self.gradient.set(&self.costs, &self.rows, &self.barrier.z);
        let mut dual = self.hull.residual(&problem.hull_cost, &self.barrier.z[hull..]);
        dual = greatest(&self.gradient.slack, dual);
        let mut scale: f64 = 1.0;
        // Stationarity of x_{t+1} without its own rows, and what a stage has on the input before.
        let (mut after, mut input_after) = (self.hull.y, Vector2::zeros());
        let carry = carry(problem);
        let gradient = self.gradient.stages(problem, &self.rows);
        for t in (0..problem.horizon()).rev() {
            let rate = gradient.rate(t);
            let pi = &self.costate[t];
            let (a_pi, b_pi) = self.models[t].adjoint(pi);
            gradient.add_next_state(t, &mut after);
            let state = after - pi;
            let input = gradient.input(t) + rate + input_after + b_pi;
            dual = dual.max(state.amax()).max(input.amax());
            scale = scale.max(pi.amax());
            after = a_pi;
            gradient.add_state(t, &mut after);
            input_after = b_pi * carry - rate;
        }
        // Costates carry the rounding of a curvature up to 1 / delta.
        Residuals { gap, primal, dual: dual / scale * DUAL_SHARE }
    }

    pub(super) fn write(&self, solution: &mut Solution) {
        solution.x.copy_from_slice(&self.best.x);
        solution.u.copy_from_slice(&self.best.u);
        solution.lambda.copy_from_slice(&self.best.lambda);
    }
}
