//! The QP alone: every solver on the same problems, one after the other on each.

use std::time::Instant;

use controller::fhocp::{ClarabelSolver, Fhocp, FhocpSolver, RiccatiSolver, Solution, Termination};
use serde::Serialize;

use super::samples::{Times, preemptions};

/// The solvers, as they are reported.
const NAMES: [&str; 3] = ["structured", "Clarabel, tuned", "Clarabel, new each step"];

/// Which of them is tuned Clarabel.
pub(super) const TUNED: usize = 1;

/// Times of one solver.
#[derive(Debug, Clone, Serialize)]
pub struct QpTimes {
    /// The solver.
    pub solver: &'static str,
    /// Problems it did not solve to a usable solution.
    pub unsolved: usize,
    /// Solves left out because the system took the processor away.
    pub preempted: usize,
    /// Its times.
    #[serde(flatten)]
    pub times: Times,
    /// Median of the structured solver over this one's.
    pub structured_to_this: f64,
}

/// Times of the structured solver, tuned Clarabel at its tolerance of 1e-6, and Clarabel as it
/// comes, made anew for each problem.
pub(super) fn measure(termination: Termination, problems: &[Fhocp]) -> Vec<QpTimes> {
    let Some(first) = problems.first() else { return Vec::new() };
    let clarabel = |tolerance| Termination { tolerance, max_iterations: 100 };
    let mut structured = RiccatiSolver::new(termination);
    let mut tuned = ClarabelSolver::new(clarabel(1e-6));
    let mut solution = Solution::new(first.horizon(), first.hull.len());
    let mut times = [const { Vec::new() }; NAMES.len()];
    let (mut unsolved, mut preempted) = ([0; NAMES.len()], [0; NAMES.len()]);
    for (k, problem) in problems.iter().enumerate() {
        for i in 0..NAMES.len() {
            let interference = preemptions();
            let begun = Instant::now();
            let report = match i {
                0 => structured.solve(problem, &mut solution),
                1 => tuned.solve(problem, &mut solution),
                _ => ClarabelSolver::reference(clarabel(1e-8)).solve(problem, &mut solution),
            };
            let elapsed = begun.elapsed().as_secs_f64() * 1e6;
            unsolved[i] += usize::from(!report.status.usable());
            // The first solve lays out memory.
            if preemptions() != interference {
                preempted[i] += 1;
            } else if k > 0 {
                times[i].push(elapsed);
            }
        }
    }
    let times = times.map(|mut times| Times::of(&mut times));
    let row = |i: usize| QpTimes {
        solver: NAMES[i],
        unsolved: unsolved[i],
        preempted: preempted[i],
        times: times[i],
        structured_to_this: times[0].median_us / times[i].median_us,
    };
    (0..NAMES.len()).map(row).collect()
}
