//! The structured solver against Clarabel at 1e-10: same first input, same cost.
#![allow(clippy::unwrap_used)]

mod support;

use fhocp::{
    Backend, ClarabelSolver, Fhocp, FhocpSolver, RiccatiSolver, Solution, SolveReport, Termination,
};
use support::random::random;
use support::{Setting, closed_loop};

fn to(tolerance: f64) -> Termination {
    Termination { tolerance, max_iterations: 200 }
}

fn solve(solver: &mut impl FhocpSolver, problem: &Fhocp) -> (SolveReport, Solution) {
    let mut solution = Solution::new(problem.horizon(), problem.hull.len());
    (solver.solve(problem, &mut solution), solution)
}

/// Differences of u_0 over the problems, sorted; the cost must agree in each.
fn differences<'a>(name: &str, problems: impl IntoIterator<Item = &'a Fhocp>) -> Vec<f64> {
    let mut ours = RiccatiSolver::new(to(1e-8));
    let mut reference = ClarabelSolver::reference(to(1e-10));
    let mut differences = Vec::new();
    for (k, problem) in problems.into_iter().enumerate() {
        let (exact, optimum) = solve(&mut reference, problem);
        assert!(exact.status.usable(), "{name} {k}: reference {exact:?}");
        let (report, solution) = solve(&mut ours, problem);
        assert!(report.status.usable(), "{name} {k}: {report:?}");
        assert_eq!(report.backend, Backend::Structured);
        let (cost, least) = (problem.cost(&solution), problem.cost(&optimum));
        let error = (cost - least).abs() / least.abs().max(1.0);
        assert!(error < 1e-6, "{name} {k}: cost {cost}, not {least}");
        assert!((solution.lambda.iter().sum::<f64>() - 1.0).abs() < 1e-9, "{name} {k}");
        for t in 0..problem.horizon() {
            let before = if t == 0 { problem.u_prev } else { solution.u[t - 1] };
            let next = problem.next(t, &solution.x[t], &solution.u[t], &before);
            let defect = (next - solution.x[t + 1]).amax();
            assert!(defect < 1e-8, "{name} {k}: dynamics off by {defect} at stage {t}");
        }
        differences.push((solution.u[0] - optimum.u[0]).amax());
    }
    differences.sort_by(f64::total_cmp);
    differences
}

#[test]
fn random_problems_of_all_shapes() {
    let sizes = [(2, 1), (3, 2), (5, 7), (10, 24), (15, 30)];
    for parts in 0..128 {
        let (horizon, hull) = sizes[parts as usize % sizes.len()];
        let problems: Vec<Fhocp> = (0..6)
            .map(|seed| random(seed + 100 * u64::from(parts), horizon, hull, parts))
            .collect();
        let errors = differences(&format!("parts {parts:05b}"), &problems);
        assert!(errors[errors.len() - 1] < 1e-4, "parts {parts:05b}: {errors:?}");
    }
}

#[test]
fn closed_loop_problems() {
    let settings = [
        Setting::race(10, 40, 11),
        Setting::race(20, 64, 12),
        Setting::every_row(15, 30, 13),
        Setting::paper(12, 24, 14),
    ];
    for setting in settings {
        let problems = closed_loop(&setting, 60);
        let errors = differences(&format!("{setting:?}"), &problems);
        // The cost is flat about the optimum: u_0 is known less well than the cost.
        let (median, worst) = (errors[errors.len() / 2], errors[errors.len() - 1]);
        assert!(median < 1e-6, "{setting:?}: median {median}");
        assert!(worst < 1e-3, "{setting:?}: worst {worst}");
    }
}
