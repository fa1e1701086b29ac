//! Profile.
#![allow(clippy::all, clippy::unwrap_used, clippy::print_stdout)]
mod support;
use controller::config::{SolverConfig, SolverMethod};
use controller::fhocp::*;
use support::*;
#[test]
fn prof() {
    let problems = closed_loop(&Setting::race(20, 64, 2), 60);
    let mut ours = RiccatiSolver::new(SolverConfig {
        method: SolverMethod::Structured,
        tolerance: 1e-8,
        max_iterations: 60,
    });
    let mut s = Solution::new(20, 64);
    let mut best = f64::INFINITY;
    for _ in 0..600 {
        let start = std::time::Instant::now();
        let mut its = 0;
        for p in &problems {
            its += ours.solve(p, &mut s).iterations;
        }
        let us = start.elapsed().as_secs_f64() * 1e6;
        best = best.min(us / its as f64);
    }
    println!("us per iteration {best:.2}");
}
