//! The solver the configuration asks for, with Clarabel behind the structured one.

use super::{
    Backend, ClarabelSolver, Fhocp, FhocpSolver, RiccatiSolver, Solution, SolveReport, SolverSeed,
};
use crate::config::{SolverConfig, SolverMethod};
use crate::status::SolveStatus;

/// Greatest growth of the linear prediction for which the fallback is tried: beyond it Clarabel
/// tends to report a feasible problem as infeasible, at the price of many iterations.
const GROWTH_LIMIT: f64 = 1e3;

/// Solver of the FHOCP by `solver.method`. The structured solver hands what it cannot solve to
/// tolerance over to Clarabel within the same call; the report names the one whose solution it is.
pub struct Solver {
    structured: Option<RiccatiSolver>,
    clarabel: ClarabelSolver,
}

impl Solver {
    /// The solver `config` asks for.
    #[must_use]
    pub fn new(config: SolverConfig) -> Self {
        let structured = match config.method {
            SolverMethod::Structured => Some(RiccatiSolver::new(config.clone())),
            SolverMethod::Clarabel => None,
        };
        Self { structured, clarabel: ClarabelSolver::new(config) }
    }
}

impl Solver {
    /// What Clarabel was laid out for, if it was; the structured solver remembers nothing.
    pub(crate) fn seed(&self) -> Option<SolverSeed> {
        self.clarabel.seed()
    }

    /// Lays Clarabel out as another one was.
    pub(crate) fn restore(&mut self, seed: Option<&SolverSeed>) {
        self.clarabel.restore(seed);
    }
}

impl FhocpSolver for Solver {
    fn solve(&mut self, problem: &Fhocp, solution: &mut Solution) -> SolveReport {
        let Some(structured) = &mut self.structured else {
            return self.clarabel.solve(problem, solution);
        };
        // Memory for the fallback is laid out now: not in the step that needs it.
        self.clarabel.lay_out(problem);
        let first = structured.solve(problem, solution);
        let hopeless = || !problem.is_finite() || problem.growth() > GROWTH_LIMIT;
        if first.status == SolveStatus::Solved || hopeless() {
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
        let config =
            SolverConfig { method: SolverMethod::Structured, tolerance: 1e-8, max_iterations: 60 };
        let mut problem = Fhocp::new(3, 2);
        problem.hull[1][0] = 1.0;
        problem.hull_cost = vec![1.0, 0.0];
        for model in &mut problem.model {
            model.a.fill_diagonal(1.0);
            model.b[(0, 0)] = 0.2;
        }
        problem.input_cost.fill(0.1);
        let (mut first, mut second) = (Solution::new(3, 2), Solution::new(3, 2));
        let mut solver = Solver::new(config.clone());
        assert_eq!(solver.solve(&problem, &mut first).backend, Backend::Structured);
        let hasty = SolverConfig { max_iterations: 1, ..config };
        solver.structured = Some(RiccatiSolver::new(hasty));
        let report = solver.solve(&problem, &mut second);
        assert_eq!((report.status, report.backend), (SolveStatus::Solved, Backend::Clarabel));
        assert!((first.u[0] - second.u[0]).amax() < 1e-6, "{first:?} {second:?}");
        // A prediction that explodes is not handed over.
        problem.model[0].a[(5, 5)] = 1e4;
        assert_eq!(solver.solve(&problem, &mut second).backend, Backend::Structured);
    }
}
