//! The starting point.
//!
//! Each row is first replaced by a penalty on its distance from the bound, in units of the row's
//! width: one linear quadratic problem, solved by one pass of the machinery at hand. As its point
//! to start from may hold any states, the defects of the dynamics are part of that pass; an
//! unstable prediction is thereby rolled out under feedback. Its matrices do not depend on the
//! measurement and are factored before it arrives. The slacks are then set close to
//! their central path, gaps and hull weights moved inside their bounds.

use nalgebra::Vector6;

use super::super::Fhocp;
use super::mehrotra::Work;
use super::rows::{LANE, QUANTITIES, SPEED};
use super::stage::penalty;

/// Complementarity w z of the stages' rows at the start, in units of the cost: steps.
const MU: f64 = 2.0;
/// The same of the hull weights.
const MU_HULL: f64 = 0.5;
/// Weight of the penalty that replaces the rows, in units of the cost.
const PENALTY: f64 = 60.0;
/// Least gap in units of the row's width.
const LEAST_GAP: f64 = 0.02;
/// Regularisation of the stages' rows, see [`super::barrier`].
const REGULARISATION: f64 = 1e-8;

impl Work {
    /// Reads all of the problem but x_0 and u_{-1}, and factors the first system, which depends on
    /// neither; false if it cannot be factored.
    #[inline(always)]
    pub(super) fn prepare(&mut self, problem: &Fhocp) -> bool {
        let hull = self.rows.hull();
        self.barrier.delta[..hull].fill(REGULARISATION);
        self.barrier.delta[hull..].fill(0.0);
        self.rows.limits(problem, &mut self.barrier.b);
        self.rows.widths(problem, &mut self.barrier.width);
        self.hull.load(problem);
        self.costs.load(problem, &self.rows);
        for (ours, model) in self.models.iter_mut().zip(&problem.model) {
            ours.load(model, problem.lag);
        }
        self.barrier.penalise(PENALTY);
        self.condense(problem)
    }

    /// Sets the first iterate of a prepared problem.
    #[inline(always)]
    pub(super) fn start(&mut self, problem: &Fhocp) {
        let shape = self.rows.shape;
        let hull = self.rows.hull();
        let mean = 1.0 / shape.hull as f64;
        self.guess(problem);

        self.hull.costate(&self.point.x[shape.horizon], &self.point.lambda);
        self.image(problem);
        self.costs.set(&self.at, &self.point.s);
        self.barrier.pull_back();
        self.direction(problem, true);
        self.point.advance(1.0, &self.direction);

        self.rows.set(problem, &self.point, problem.u_prev, &mut self.at);
        self.slacks(problem);
        for lambda in &mut self.point.lambda {
            *lambda = lambda.max(0.1 * mean);
        }
        self.renormalise();
        self.image(problem);
        self.barrier.enter(0..hull, LEAST_GAP, MU);
        self.barrier.enter(hull..self.rows.count(), LEAST_GAP, MU_HULL);
        self.renormalise();
    }

    /// Inputs held, states on the line from x_0 to the middle of the hull, equal weights; the
    /// defects of that in `costate_next`.
    #[inline(always)]
    fn guess(&mut self, problem: &Fhocp) {
        let shape = self.rows.shape;
        let [least, greatest] = problem.box_of(1);
        let u = problem.u_prev.sup(&least).inf(&greatest);
        self.point.u.fill(u);
        self.point.s.fill(0.0);
        self.point.lambda.fill(1.0 / shape.hull as f64);
        self.point.x[0] = problem.x_0;
        let way = self.hull.centre() - problem.x_0;
        for t in 0..shape.horizon {
            let share = (t + 1) as f64 / shape.horizon as f64;
            self.point.x[t + 1] = problem.x_0 + way * share;
            let before = if t == 0 { problem.u_prev } else { u };
            self.costate_next[t] =
                problem.next(t, &self.point.x[t], &u, &before) - self.point.x[t + 1];
        }
        self.costate.fill(Vector6::zeros());
    }

    /// Slacks near the central path. With the violation v of the worse side and the penalty's
    /// slope l, `l = mu / s + mu / (s - v)` has the root
    /// `s = (2 mu + l v + sqrt(l^2 v^2 + 4 mu^2)) / (2 l)`.
    #[inline(always)]
    fn slacks(&mut self, problem: &Fhocp) {
        let [highs, lows, ..] = self.rows.split(&self.barrier.b);
        let first = self.rows.slacks().start;
        for quantity in LANE..QUANTITIES {
            if !self.rows.bounds(quantity) {
                continue;
            }
            let (linear, quadratic) = penalty(problem, quantity);
            for i in self.rows.range(quantity) {
                let low = if quantity == SPEED { f64::INFINITY } else { lows[i] };
                let v = (self.at[i] - highs[i]).max(-self.at[i] - low);
                let slope = (linear + 2.0 * quadratic * v.max(0.0)).max(1e-3);
                let lv = slope * v;
                let root = (lv * lv + 4.0 * MU * MU).sqrt();
                self.point.s[i - first] = (2.0 * MU + lv + root) / (2.0 * slope);
            }
        }
    }
}
