//! The QP alone: the structured solver against Clarabel, all on the same closed-loop problems in
//! one run, so that the ratios hold whatever else the machine does.
//!
//! `cargo bench -p fhocp --bench qp [-- problems-per-shape]`
#![allow(missing_docs, clippy::print_stdout, clippy::unwrap_used)]

#[path = "../tests/support/mod.rs"]
mod support;

use std::time::Instant;

use fhocp::{ClarabelSolver, Fhocp, FhocpSolver, RiccatiSolver, Solution, Termination};
use support::{Setting, closed_loop};

/// Samples of one quantity: times of a solver [us], errors.
struct Samples(Vec<f64>);

impl Samples {
    fn quantile(&self, share: f64) -> f64 {
        let mut sorted = self.0.clone();
        sorted.sort_by(f64::total_cmp);
        sorted[((sorted.len() - 1) as f64 * share) as usize]
    }
}

fn to(tolerance: f64) -> Termination {
    Termination { tolerance, max_iterations: 100 }
}

fn main() {
    let count = std::env::args().filter_map(|arg| arg.parse().ok()).next().unwrap_or(300);
    println!("times in us: min / median / p99; ratios of medians to Clarabel");
    let shapes = [(10, 40), (15, 30), (20, 64), (40, 96), (60, 96)];
    for (horizon, hull) in shapes {
        compare("race", &closed_loop(&Setting::race(horizon, hull, 1), count));
    }
    for (horizon, hull) in [(10, 40), (20, 64)] {
        compare("every row", &closed_loop(&Setting::every_row(horizon, hull, 2), count));
    }
}

fn compare(name: &str, problems: &[Fhocp]) {
    let (horizon, hull) = (problems[0].horizon(), problems[0].hull.len());
    let mut structured = RiccatiSolver::new(to(1e-8));
    let mut tuned_8 = ClarabelSolver::new(to(1e-8));
    let mut tuned_6 = ClarabelSolver::new(to(1e-6));
    let mut solution = Solution::new(horizon, hull);
    let mut times = [const { Samples(Vec::new()) }; 4];
    let mut iterations = Vec::new();
    let mut failures = [0; 4];
    let mut reference = ClarabelSolver::reference(to(1e-10));
    let (mut optimum, mut errors) = (solution.clone(), Samples(Vec::new()));
    for (k, problem) in problems.iter().enumerate() {
        for i in 0..4 {
            let start = Instant::now();
            let report = match i {
                0 => structured.solve(problem, &mut solution),
                1 => ClarabelSolver::reference(to(1e-8)).solve(problem, &mut solution),
                2 => tuned_8.solve(problem, &mut solution),
                _ => tuned_6.solve(problem, &mut solution),
            };
            let elapsed = start.elapsed().as_secs_f64() * 1e6;
            // The first solve of each shape lays out memory.
            if k > 0 {
                times[i].0.push(elapsed);
            }
            failures[i] += usize::from(!report.status.usable());
            if i == 0 {
                if reference.solve(problem, &mut optimum).status.usable() && report.status.usable()
                {
                    errors.0.push((solution.u[0] - optimum.u[0]).amax());
                }
                iterations.push(report.iterations);
            }
        }
    }
    iterations.sort_unstable();
    let [e_50, e_99, e_max] = [0.5, 0.99, 1.0].map(|share| errors.quantile(share));
    println!("\nN {horizon}, {hull} points, {name}, {} problems", problems.len());
    let names = ["structured 1e-8", "Clarabel default, new", "Clarabel 1e-8", "Clarabel 1e-6"];
    for (name, (times, failures)) in names.iter().zip(times.iter().zip(failures)) {
        let [min, median, p99] = [0.0, 0.5, 0.99].map(|share| times.quantile(share));
        println!("  {name:22} {min:8.1} {median:8.1} {p99:8.1}   unsolved {failures}");
    }
    let ratio =
        |of: usize, to: usize, share: f64| times[of].quantile(share) / times[to].quantile(share);
    println!(
        "  structured / default new {:.3} (min {:.3}); / Clarabel 1e-8 {:.3} (min {:.3}); / Clarabel 1e-6 {:.3} (min {:.3})",
        ratio(0, 1, 0.5),
        ratio(0, 1, 0.0),
        ratio(0, 2, 0.5),
        ratio(0, 2, 0.0),
        ratio(0, 3, 0.5),
        ratio(0, 3, 0.0),
    );
    println!(
        "  Clarabel 1e-6 / default new {:.3}; structured p99 / median {:.2}; iterations median {} mean {:.2} max {}",
        ratio(3, 1, 0.5),
        times[0].quantile(0.99) / times[0].quantile(0.5),
        iterations[iterations.len() / 2],
        f64::from(iterations.iter().sum::<u32>()) / iterations.len() as f64,
        iterations[iterations.len() - 1],
    );
    println!("  |u_0 - u_0*| to Clarabel 1e-10: median {e_50:.1e} p99 {e_99:.1e} max {e_max:.1e}");
}
