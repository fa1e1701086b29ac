//! The FHOCP solved by an interior-point method made for it.
//!
//! Mehrotra's predictor-corrector (Nocedal and Wright, Numerical Optimization, ch. 16.6) on
//!
//! ```text
//! minimise f(v)  subject to  A v + w = b,  w >= 0
//! ```
//!
//! where v holds the inputs, the slacks and the hull weights, and x follows from the inputs
//! ([`rows`] says which inequality stands where). Each iteration
//!
//! 1. forms sigma = z / w, the curvature every row adds ([`barrier`]);
//! 2. eliminates the slacks of each stage ([`stage`]) and the weights of the hull ([`hull`]);
//! 3. factors what is left, a linear quadratic regulator, by the Riccati recursion
//!    ([`recursion`]) in O(N);
//! 4. solves twice with that factor: for the predictor (target 0), then for the corrector, whose
//!    target and second-order term come from the predictor, unless the predictor can be taken whole;
//! 5. takes one step length for v, w and z ([`mehrotra`]).
//!
//! [`start`] says where it begins, and what of that is done before the measurement. The dynamics and
//! the sum of the weights hold from the start and stay held, since directions keep them; only the
//! inequalities carry residuals. All memory is laid out once per shape, and
//! the result depends on the problem alone.

mod barrier;
mod columns;
mod hull;
mod mehrotra;
mod product;
mod recursion;
mod rows;
mod stage;
mod start;

use pulp::{Arch, Simd, WithSimd};

use self::mehrotra::Work;
use super::layout::Shape;
use super::{Backend, Fhocp, FhocpSolver, Solution, SolveReport, SolveStatus, Termination};

/// Structure-exploiting interior-point solver of the FHOCP.
pub struct RiccatiSolver {
    termination: Termination,
    /// The widest vectors this processor has.
    arch: Arch,
    work: Option<Work>,
    /// Whether the work is that of the problem to come, and its first system could be factored.
    prepared: Option<bool>,
}

impl RiccatiSolver {
    /// A solver that ends so; memory is laid out at the first solve of each shape.
    #[must_use]
    pub fn new(termination: Termination) -> Self {
        Self { termination, arch: Arch::new(), work: None, prepared: None }
    }

    /// Writes the best iterate of the last solve again.
    pub(super) fn write(&self, solution: &mut Solution) {
        if let Some(work) = &self.work {
            work.write(solution);
        }
    }
}

impl FhocpSolver for RiccatiSolver {
    fn prepare(&mut self, problem: &Fhocp) {
        if problem.horizon() == 0 || problem.hull.is_empty() {
            return;
        }
        let shape = Shape::of(problem);
        let work = match &mut self.work {
            Some(work) if work.rows.shape == shape => work,
            work => work.insert(Work::new(shape)),
        };
        self.prepared = Some(self.arch.dispatch(Preparation { work, problem }));
    }

    fn forget(&mut self) {
        self.prepared = None;
    }

    fn solve(&mut self, problem: &Fhocp, solution: &mut Solution) -> SolveReport {
        if self.prepared.is_none() {
            self.prepare(problem);
        }
        // The iterations leave nothing of it.
        let prepared = self.prepared.take() == Some(true);
        match &mut self.work {
            Some(work) if prepared && problem.is_finite() => {
                let report =
                    self.arch.dispatch(Iteration { work, problem, termination: self.termination });
                if report.status != SolveStatus::Numerical {
                    work.write(solution);
                }
                report
            }
            _ => report(SolveStatus::Numerical, 0),
        }
    }
}

fn report(status: SolveStatus, iterations: u32) -> SolveReport {
    SolveReport { status, iterations, backend: Backend::Structured }
}

/// What can be done before the measurement, compiled once for each instruction set.
struct Preparation<'a> {
    work: &'a mut Work,
    problem: &'a Fhocp,
}

impl WithSimd for Preparation<'_> {
    type Output = bool;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> bool {
        self.work.prepare(self.problem)
    }
}

/// The rest of a solve, likewise.
struct Iteration<'a> {
    work: &'a mut Work,
    problem: &'a Fhocp,
    termination: Termination,
}

impl WithSimd for Iteration<'_> {
    type Output = SolveReport;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> SolveReport {
        self.work.solve(self.problem, self.termination)
    }
}
