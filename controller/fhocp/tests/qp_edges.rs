//! Problems at the edge: what solvers answer where there is little or nothing to solve.
#![allow(clippy::unwrap_used)]

mod support;

use fhocp::{
    Backend, ClarabelSolver, Fhocp, FhocpSolver, RiccatiSolver, Solution, SolveReport, SolveStatus,
    Solver, Termination,
};
use nalgebra::{Matrix6, Vector2};
use support::random::random;

const TERMINATION: Termination = Termination { tolerance: 1e-8, max_iterations: 100 };

fn structured(problem: &Fhocp) -> (SolveReport, Solution) {
    let mut solution = Solution::new(problem.horizon(), problem.hull.len());
    let report = RiccatiSolver::new(TERMINATION).solve(problem, &mut solution);
    (report, solution)
}

/// Solved by both, to the same cost.
fn agrees(name: &str, problem: &Fhocp) -> Solution {
    let (report, solution) = structured(problem);
    assert!(report.status.usable(), "{name}: {report:?}");
    let mut optimum = Solution::new(problem.horizon(), problem.hull.len());
    let mut clarabel = ClarabelSolver::reference(TERMINATION);
    let reference = clarabel.solve(problem, &mut optimum);
    assert!(reference.status.usable(), "{name}: reference {reference:?}");
    let (cost, least) = (problem.cost(&solution), problem.cost(&optimum));
    let error = (cost - least).abs() / least.abs().max(1.0);
    assert!(error < 1e-5, "{name}: cost {cost}, not {least}");
    solution
}

#[test]
fn degenerate_hulls() {
    let base = random(1, 10, 20, 0b11111);
    let mut repeated = base.clone();
    for j in 1..20 {
        repeated.hull[j] = base.hull[j / 5];
        repeated.hull_cost[j] = base.hull_cost[j / 5];
    }
    agrees("each point five times", &repeated);
    let mut identical = base.clone();
    identical.hull.fill(base.hull[0]);
    identical.hull_cost.fill(base.hull_cost[0]);
    agrees("one point twenty times", &identical);
    let mut tiny = base.clone();
    for point in &mut tiny.hull {
        *point = base.hull[0] + (*point - base.hull[0]) * 1e-7;
    }
    agrees("a hull of 1e-7", &tiny);
    let mut line = base.clone();
    for (j, point) in line.hull.iter_mut().enumerate() {
        *point = base.hull[0] + (base.hull[1] - base.hull[0]) * (j as f64 / 19.0);
    }
    agrees("points on a line", &line);
    agrees("one point", &random(2, 10, 1, 0b11111));
}

#[test]
fn far_from_everything() {
    let mut problem = random(3, 12, 20, 0b11100);
    problem.x_0[5] = 50.0;
    // With guards that differ at random from stage to stage the structured solver goes round in circles here, and
    // hands over.
    problem.front_share.fill(1.0);
    agrees("50 m off the track", &problem);
    let mut problem = random(4, 12, 20, 0b11111);
    problem.x_0[4] += 5000.0;
    for point in &mut problem.hull {
        point[4] += 5000.0;
    }
    agrees("5 km down the track", &problem);
    let mut problem = random(5, 12, 20, 0b11111);
    problem.e_y_min.fill(0.3);
    problem.e_y_max.fill(-0.3);
    agrees("a lane turned inside out", &problem);
}

#[test]
fn previous_input_outside_the_box() {
    let mut problem = random(6, 10, 20, 0b11100);
    problem.u_prev = Vector2::new(9.0, -3.0);
    let solution = agrees("no rate limit", &problem);
    assert!(solution.u[0][0] <= problem.u_max[0] + 1e-6);
    problem.du_max = Vector2::new(0.5, 0.1);
    for first in [Backend::Structured, Backend::Clarabel] {
        let mut solution = Solution::new(10, 20);
        let report = Solver::new(first, true, TERMINATION).solve(&problem, &mut solution);
        assert!(!report.status.usable(), "box and rate limit exclude each other: {report:?}");
        assert!(solution.is_finite());
    }
}

#[test]
fn only_the_first_stage_uses_the_reserve() {
    let mut problem = random(7, 10, 20, 0b00000);
    // A lane far to either side, which nothing but full inputs come near to.
    for e_y in [-50.0, 50.0] {
        problem.e_y_min.fill(e_y - 0.1);
        problem.e_y_max.fill(e_y + 0.1);
        let solution = agrees("a lane out of reach", &problem);
        for i in 0..2 {
            let inside = |t: usize, reserve: [f64; 2]| {
                let u = solution.u[t][i];
                let gaps = [u - problem.u_min[i] - reserve[0], problem.u_max[i] - reserve[1] - u];
                gaps.iter().all(|gap| *gap > -1e-6).then(|| gaps.iter().any(|gap| *gap < 1e-5))
            };
            let reserve = problem.reserve.map(|reserve| reserve[i]);
            let later: Option<Vec<bool>> = (1..10).map(|t| inside(t, reserve)).collect();
            assert_eq!(inside(0, [0.0; 2]), Some(true), "input {i}: {:?}", solution.u);
            let at_its_bound = later.map(|later| later.contains(&true));
            assert_eq!(at_its_bound, Some(true), "input {i}: {:?}", solution.u);
        }
    }
}

#[test]
fn exploding_predictions_never_give_nan() {
    for seed in 0..20 {
        for rate in [2.0, 10.0, 1e3, 1e12, 1e60] {
            let mut problem = random(seed, 20, 24, seed as u32);
            for model in &mut problem.model {
                model.a += Matrix6::from_fn(|i, j| if i < 3 && j < 3 { rate } else { 0.0 });
            }
            let mut solution = Solution::new(20, 24);
            let report =
                Solver::new(Backend::Structured, true, TERMINATION).solve(&problem, &mut solution);
            assert!(solution.is_finite(), "seed {seed}, rate {rate}: {report:?}");
        }
    }
}

#[test]
fn values_that_are_not_finite_are_refused() {
    type Break = fn(&mut Fhocp, f64);
    let places: [Break; 8] = [
        |p, v| p.x_0[3] = v,
        |p, v| p.u_prev[0] = v,
        |p, v| p.model[2].a[(1, 1)] = v,
        |p, v| p.model[2].b[(1, 1)] = v,
        |p, v| p.model[2].c[4] = v,
        |p, v| p.hull[3][2] = v,
        |p, v| p.hull_cost[3] = v,
        |p, v| p.e_y_max[1] = v,
    ];
    for first in [Backend::Structured, Backend::Clarabel] {
        for (k, place) in places.iter().enumerate() {
            for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
                let mut problem = random(7, 5, 6, 0b11111);
                place(&mut problem, value);
                let mut solution = Solution::new(5, 6);
                let report = Solver::new(first, true, TERMINATION).solve(&problem, &mut solution);
                assert_eq!(report.status, SolveStatus::Numerical, "place {k}, {value}");
                assert!(solution.is_finite());
            }
        }
    }
}

#[test]
fn result_does_not_depend_on_what_was_solved_before() {
    let problems: Vec<Fhocp> = (0..6).map(|seed| random(seed, 10, 20, 0b11111)).collect();
    let mut solver = RiccatiSolver::new(TERMINATION);
    for round in 0..3 {
        for problem in problems.iter().cycle().skip(round).take(6) {
            let mut solution = Solution::new(10, 20);
            let report = solver.solve(problem, &mut solution);
            assert_eq!((report, solution), structured(problem));
        }
    }
}

#[test]
fn prepared_or_not_makes_no_difference() {
    let mut solver = RiccatiSolver::new(TERMINATION);
    let mut solution = Solution::new(10, 20);
    for seed in 0..6 {
        let measured = random(seed, 10, 20, 0b11111);
        let mut early = measured.clone();
        early.x_0.fill(0.3);
        early.u_prev.fill(-0.1);
        solver.prepare(&early);
        // What is prepared goes with the first solve, or is forgotten with what it was made for.
        for _ in 0..2 {
            let report = solver.solve(&measured, &mut solution);
            assert_eq!((report, &solution), (structured(&measured).0, &structured(&measured).1));
        }
        solver.prepare(&random(seed + 100, 7, 15, 0b00111));
        solver.forget();
    }
}

#[test]
fn too_few_iterations_give_the_best_iterate() {
    let problem = random(8, 10, 20, 0b11111);
    let mut solution = Solution::new(10, 20);
    let short = Termination { max_iterations: 5, ..TERMINATION };
    let report = Solver::new(Backend::Structured, true, short).solve(&problem, &mut solution);
    assert_eq!(report.status, SolveStatus::MaxIterations, "neither can do it in five");
    assert_eq!(report.backend, Backend::Structured);
    assert!(solution.is_finite());
}
