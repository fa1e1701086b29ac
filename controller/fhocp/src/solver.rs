//! Either solver, with Clarabel behind the structured one.

use super::{
    Backend, ClarabelSolver, Fhocp, FhocpSolver, RiccatiSolver, Solution, SolveReport, SolveStatus,
    SolverSeed, Termination,
};

/// Solver of the FHOCP. With a fallback the structured solver hands what it cannot solve to
/// tolerance over to Clarabel within the same call; the report names the one whose solution it is.
///
/// Everything finite is handed over, however fast its prediction grows. What bounds the time is
/// [`Termination::max_iterations`], not a clock: the same problem ends the same way on every machine.
pub struct Solver {
    structured: Option<RiccatiSolver>,
    clarabel: ClarabelSolver,
    fallback: bool,
}

impl Solver {
    /// A solver that begins with `first`; `fallback` lets Clarabel take what the structured one misses.
    #[must_use]
    pub fn new(first: Backend, fallback: bool, termination: Termination) -> Self {
        let structured = match first {
            Backend::Structured => Some(RiccatiSolver::new(termination)),
            Backend::Clarabel => None,
        };
        Self { structured, clarabel: ClarabelSolver::new(termination), fallback }
    }
}

impl Solver {
    /// What Clarabel was laid out for, if it was; the structured solver remembers nothing.
    #[must_use]
    pub fn seed(&self) -> Option<SolverSeed> {
        self.clarabel.seed()
    }

    /// Lays Clarabel out as another one was.
    pub fn restore(&mut self, seed: Option<&SolverSeed>) {
        self.clarabel.restore(seed);
    }
}

impl FhocpSolver for Solver {
    fn prepare(&mut self, problem: &Fhocp) {
        if let Some(structured) = &mut self.structured {
            structured.prepare(problem);
        }
    }

    fn forget(&mut self) {
        if let Some(structured) = &mut self.structured {
            structured.forget();
        }
    }

    fn solve(&mut self, problem: &Fhocp, solution: &mut Solution) -> SolveReport {
        let Some(structured) = &mut self.structured else {
            return self.clarabel.solve(problem, solution);
        };
        if !self.fallback {
            return structured.solve(problem, solution);
        }
        // Memory for the fallback is laid out now: not in the step that needs it.
        self.clarabel.lay_out(problem);
        let first = structured.solve(problem, solution);
        if first.status == SolveStatus::Solved || !problem.is_finite() {
            return first;
        }
        let second = self.clarabel.solve(problem, solution);
        if second.status.usable() && solution.is_finite() {
            return second;
        }
        structured.write(solution);
        SolveReport { backend: Backend::Structured, ..first }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clarabel_takes_what_the_structured_solver_misses() {
        let termination = Termination { tolerance: 1e-8, max_iterations: 60 };
        let mut problem = Fhocp::new(3, 2);
        problem.hull[1][0] = 1.0;
        problem.hull_cost = vec![1.0, 0.0];
        for model in &mut problem.model {
            model.a.fill_diagonal(1.0);
            model.b[(0, 0)] = 0.2;
        }
        problem.input_cost.fill(0.1);
        let (mut first, mut second) = (Solution::new(3, 2), Solution::new(3, 2));
        let mut solver = Solver::new(Backend::Structured, true, termination);
        assert_eq!(solver.solve(&problem, &mut first).backend, Backend::Structured);
        let hasty = Termination { max_iterations: 1, ..termination };
        solver.structured = Some(RiccatiSolver::new(hasty));
        let report = solver.solve(&problem, &mut second);
        assert_eq!((report.status, report.backend), (SolveStatus::Solved, Backend::Clarabel));
        assert!((first.u[0] - second.u[0]).amax() < 1e-6, "{first:?} {second:?}");
        // However fast the prediction grows.
        problem.model[0].a[(5, 5)] = 1e4;
        assert_eq!(solver.solve(&problem, &mut second).backend, Backend::Clarabel);
        // Only if it is asked for.
        solver.fallback = false;
        let report = solver.solve(&problem, &mut second);
        assert_eq!(
            (report.status, report.backend),
            (SolveStatus::MaxIterations, Backend::Structured)
        );
    }
}
