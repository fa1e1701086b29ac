//! What `tests/instructions.rs` runs under Valgrind for the optimal control problem alone:
//! `solve_under_valgrind FOLDER` solves the problems of a folder one after the other with the structured
//! solver, and prints how many it solved and with how many iterations.
#![allow(clippy::unwrap_used, clippy::print_stdout)] // a part of a test

use std::hint::black_box;
use std::path::Path;

use controller::fhocp::{Fhocp, FhocpSolver, RiccatiSolver, Solution, SolveReport};
use controller::{Config, SolveStatus};
use hosting::problem_file;

/// What is counted; its name is how Valgrind finds it.
#[inline(never)]
fn counted_solve(solver: &mut RiccatiSolver, problem: &Fhocp, out: &mut Solution) -> SolveReport {
    black_box(solver.solve(problem, out))
}

fn main() {
    let folder = std::env::args().nth(1).unwrap();
    let problems = problem_file::read_all(Path::new(&folder)).unwrap();
    let mut solver = RiccatiSolver::new(Config::default().solver.termination());
    let (mut solved, mut iterations) = (0, 0);
    for (_, problem) in &problems {
        let mut solution = Solution::new(problem.horizon(), problem.hull.len());
        let report = counted_solve(&mut solver, problem, &mut solution);
        solved += u32::from(report.status == SolveStatus::Solved);
        iterations += report.iterations;
    }
    println!("{} problems, {solved} solved, {iterations} iterations", problems.len());
}
