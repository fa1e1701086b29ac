//! The structured solver allocates at the first solve of a shape, never after.
#![allow(unsafe_code, clippy::unwrap_used)]

#[path = "support/counting.rs"]
mod counting;
mod support;

use counting::count;
use fhocp::{Backend, FhocpSolver, Solution, Solver, Termination};
use support::random::random;

#[test]
fn no_allocation_after_the_first_solve_of_a_shape() {
    let termination = Termination { tolerance: 1e-8, max_iterations: 100 };
    let mut solver = Solver::new(Backend::Structured, true, termination);
    for parts in [0b11111, 0b00000] {
        let mut solution = Solution::new(12, 24);
        let problems: Vec<_> = (0..10).map(|seed| random(seed, 12, 24, parts)).collect();
        let before = count();
        assert!(solver.solve(&problems[0], &mut solution).status.usable());
        let first = count();
        assert!(first > before, "memory is laid out at the first solve");
        for problem in &problems {
            assert!(solver.solve(problem, &mut solution).status.usable());
        }
        assert_eq!(count(), first);
    }
}
