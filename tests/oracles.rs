//! Truths that hold whatever the numbers: what regression, QP, line and delay must do.

#![allow(clippy::unwrap_used)]

use controller::config::{Features, RegressionMode};
use controller::fhocp::{Backend, Fhocp, FhocpSolver, Solution, Solver, Termination};
use controller::learning::regression::{Weighted, epanechnikov, ridge};
use controller::{Action, Affine, Config, LapKind, Preset};
use lmpc_tests::{Drive, barc, l_track};
use nalgebra::{Matrix6, Matrix6x2, Vector2, Vector6};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use vehicle_model::{Discretized, Input, Model, ModelKind, PlantParams, State};

#[test]
fn an_affine_error_is_recovered_as_the_ridge_vanishes() {
    let mut rng = Pcg64Mcg::seed_from_u64(1);
    let mut number = |scale: f64| scale * rng.random_range(-1.0..1.0);
    for (features, free) in [
        (Features::Own, [[0, 1, 2, 3, 5], [0, 1, 2, 4, 5], [0, 1, 2, 4, 5]].map(Vec::from)),
        (Features::Both, [vec![0, 1, 2, 3, 4, 5], vec![0, 1, 2, 3, 4, 5], vec![0, 1, 2, 3, 4, 5]]),
    ] {
        let mut truth = [[0.0; 6]; 3];
        for (row, columns) in truth.iter_mut().zip(&free) {
            for &column in columns {
                row[column] = number(2.0);
            }
        }
        let samples: Vec<Weighted> = (0..60)
            .map(|_| {
                let z = [2.0 + number(0.5), number(0.3), number(1.0), number(1.0), number(0.3)];
                let apply = |g: [f64; 6]| g[5] + (0..5).map(|i| g[i] * z[i]).sum::<f64>();
                let weight = epanechnikov(0.5 + number(0.4), 1.0);
                Weighted { z, y: truth.map(apply), weight }
            })
            .collect();
        let mut before = f64::INFINITY;
        for eps in [1e-2, 1e-4, 1e-6, 1e-12] {
            let found = ridge(&samples, eps, features).0;
            let pairs = found.iter().flatten().zip(truth.iter().flatten());
            let error = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(error < before, "{features:?}: eps {eps} leaves {error}");
            before = error;
        }
        assert!(before < 1e-8, "{features:?}: {before}");
    }
}

fn driven(config: Config, nominal_mu: f64, kind: LapKind, laps: usize) -> Drive {
    let mut drive = Drive::of(config, barc(nominal_mu), PlantParams::new(barc(0.9)));
    drive.until(kind, laps);
    drive
}

/// All states and inputs of the stored laps.
fn samples(drive: &Drive) -> Vec<(State, Input)> {
    let laps = drive.controller.laps().iter();
    laps.flat_map(|lap| lap.samples.iter().map(|sample| (sample.x, sample.u))).collect()
}

#[test]
fn nothing_is_learned_where_the_nominal_model_is_the_plant() {
    let paper = || Config::preset(Preset::Paper);
    let largest = |drive: &Drive| {
        let of = samples(drive).into_iter().map(|(x, u)| {
            let model = drive.controller.learned_model(&x, &u);
            assert!(model.support > 0.0, "its own data support it");
            model.error.a.amax().max(model.error.b.amax()).max(model.error.c.amax())
        });
        of.fold(0.0, f64::max)
    };
    let exact = largest(&driven(paper(), 0.9, LapKind::Learning, 2));
    assert!(exact < 1e-9, "{exact}");
    // The same measure where there is something to learn.
    let wrong = largest(&driven(paper(), 1.2, LapKind::Learning, 2));
    assert!(wrong > 1e-2, "{wrong}");
}

fn same_bits(ours: &Affine, theirs: &Affine) -> bool {
    let bits = |m: &Affine| -> Vec<u64> {
        m.a.iter().chain(m.b.iter()).chain(m.c.iter()).map(|v| v.to_bits()).collect()
    };
    bits(ours) == bits(theirs)
}

#[test]
fn without_data_in_reach_the_nominal_model_stands_alone() {
    for mode in [RegressionMode::Error, RegressionMode::Full] {
        let mut config = Config::preset(Preset::Paper);
        config.regression.bandwidth = 1e-9;
        config.regression.mode = mode;
        let drive = driven(config, 1.2, LapKind::Warmup, 2);
        let (dt, substeps) = (0.1, drive.controller.config().horizon.substeps);
        let f = Discretized { model: Model::new(ModelKind::Dynamic, barc(1.2)), dt, substeps };
        let track = l_track();
        for (x, u) in samples(&drive) {
            // Beside the data, at the speed of another lap.
            let x = State { v_x: x.v_x + 1.0, ..x };
            let model = drive.controller.learned_model(&x, &u);
            assert_eq!(model.support, 0.0);
            if mode == RegressionMode::Full {
                let sum = model.sum();
                let zero = |row: usize| {
                    sum.a.row(row).iter().chain(sum.b.row(row).iter()).all(|v| *v == 0.0)
                        && sum.c[row] == 0.0
                };
                assert!((0..3).all(zero), "{sum:?}");
                continue;
            }
            let mut linear = f.linearize(&x, &u, track.road());
            f.follow_bend(&x, &track.road(), 0.0, &mut linear);
            let c = linear.next - linear.a * x.to_vector() - linear.b * u.to_vector();
            assert!(same_bits(&model.sum(), &Affine { a: linear.a, b: linear.b, c }), "{x:?}");
        }
    }
}

/// A small problem as it occurs while driving: a lagging chain, a hull ahead of its end.
fn problem(rng: &mut Pcg64Mcg) -> Fhocp {
    let mut number = |scale: f64| scale * rng.random_range(-1.0..1.0);
    let mut problem = Fhocp::new(8, 12);
    problem.x_0 = Vector6::new(2.0, 0.0, 0.3, 0.05, 0.0, number(0.2));
    problem.u_min = Vector2::new(-2.0, -0.436);
    problem.u_max = Vector2::new(2.0, 0.436);
    problem.input_cost = Vector2::repeat(1e-3);
    problem.rate_cost = Vector2::new(0.1, 5.0);
    problem.lane_linear = 25.0;
    problem.lane_quadratic = 100.0;
    problem.e_y_min.fill(-0.45);
    problem.e_y_max.fill(0.45);
    problem.terminal_slack_weight = Vector6::new(40.0, 4.0, 4.0, 40.0, 40.0, 40.0);
    for model in &mut problem.model {
        let mut a = Matrix6::identity();
        (a[(1, 1)], a[(2, 2)]) = (0.2, 0.2);
        (a[(3, 2)], a[(4, 0)], a[(5, 3)]) = (0.1, 0.1, 0.2 + number(0.02));
        let mut b = Matrix6x2::zeros();
        (b[(0, 0)], b[(1, 1)], b[(2, 1)]) = (0.1, 0.5, 4.0 + number(0.5));
        *model = Affine { a, b, c: Vector6::zeros() };
    }
    for j in 0..12 {
        let s = 1.2 + 0.1 * f64::from(j);
        let cost = 20.0 - f64::from(j) + number(0.2);
        problem.hull[j as usize] =
            Vector6::new(2.0 + number(0.4), number(0.05), number(0.3), number(0.1), s, number(0.3));
        problem.hull_cost[j as usize] = cost;
    }
    problem
}

#[test]
fn the_qp_keeps_its_simplex_and_ignores_a_constant_cost() {
    let mut rng = Pcg64Mcg::seed_from_u64(2);
    let termination = Termination { tolerance: 1e-10, max_iterations: 200 };
    for first in [Backend::Clarabel, Backend::Structured] {
        let mut solver = Solver::new(first, true, termination);
        for k in 0..20 {
            let problem = problem(&mut rng);
            let mut solve = |problem: &Fhocp| {
                let mut solution = Solution::new(8, 12);
                let report = solver.solve(problem, &mut solution);
                assert!(report.status.usable(), "{k}: {report:?}");
                solution
            };
            let solution = solve(&problem);
            let total: f64 = solution.lambda.iter().sum();
            assert!((total - 1.0).abs() < 1e-7, "{k}: sum of lambda {total}");
            assert!(solution.lambda.iter().all(|l| *l > -1e-7), "{k}: {:?}", solution.lambda);
            // The dynamics hold, so that x_N - X lambda is the slack that the cost charges.
            for t in 0..8 {
                let next = problem.model[t].apply(&solution.x[t], &solution.u[t]);
                assert!((next - solution.x[t + 1]).amax() < 1e-7, "{k}: stage {t}");
            }
            let point = |solution: &Solution| -> Vector6<f64> {
                problem.hull.iter().zip(&solution.lambda).map(|(x, l)| x * *l).sum()
            };
            let slack = solution.x[8] - point(&solution);
            let charged = problem.terminal_slack_weight.dot(&slack.component_mul(&slack));
            assert!(
                (problem.terminal_slack_cost(&solution) - charged).abs() < 1e-9 * (1.0 + charged)
            );

            let mut shifted = problem.clone();
            shifted.hull_cost.iter_mut().for_each(|cost| *cost += 30.0);
            let other = solve(&shifted);
            assert!((solution.u[0] - other.u[0]).amax() < 1e-5, "{k}: u_0");
            assert!((point(&solution) - point(&other)).amax() < 1e-4, "{k}: X lambda");
            let grown = shifted.cost(&other) - problem.cost(&solution);
            assert!((grown - 30.0).abs() < 1e-4, "{k}: the cost grew by {grown}");
        }
    }
}

#[test]
fn the_line_is_nothing_special() {
    let mut drive = Drive::new(Config::default());
    drive.until(LapKind::Learning, 3);
    let length = l_track().length();
    // Where the plan ends and what it ends on, in the frame of the whole way driven.
    let mut before: Option<(f64, f64)> = None;
    let mut largest_elsewhere: f64 = 0.0;
    let mut largest_at_line: f64 = 0.0;
    let first = drive.laps.len();
    while drive.laps.len() < first + 3 {
        let lap_at = drive.laps.len();
        let status = drive.step().status;
        assert_eq!(status.action, Action::Learned);
        #[expect(clippy::cast_precision_loss, reason = "laps are few")]
        let offset = drive.laps.len() as f64 * length;
        let plan = drive.controller.plan();
        let end = plan.x[plan.x.len() - 1].s;
        // Both the car's crossing and the plan's end's crossing count as the line.
        let near = |s: f64| s.rem_euclid(length) < 1.0 || s.rem_euclid(length) > length - 1.0;
        let at_line = near(status.state.s) || near(end) || drive.laps.len() > lap_at;
        if let Some((end_before, cost_before)) = before {
            let advance = end + offset - end_before;
            assert!(
                (0.0..1.0).contains(&advance),
                "the plan's end moved {advance} m at {status:?}"
            );
            let change = (status.cost - cost_before).abs();
            let largest = if at_line { &mut largest_at_line } else { &mut largest_elsewhere };
            *largest = largest.max(change);
        }
        before = Some((end + offset, status.cost));
    }
    println!("{largest_at_line} {largest_elsewhere}");
    assert!(largest_at_line < 3.5, "cost jumps by {largest_at_line} steps at the line");
    assert!(largest_at_line < 2.0 * largest_elsewhere + 1.0, "elsewhere {largest_elsewhere}");
}

#[test]
fn a_known_delay_costs_little() {
    let time = |delayed: bool| {
        let mut config = Config::default();
        let mut plant = PlantParams::new(barc(0.9));
        if delayed {
            config.delay.steps = 1;
            plant.car.actuator_delay = 0.1;
        }
        let mut drive = Drive::of(config, barc(1.2), plant);
        drive.until(LapKind::Learning, 10);
        assert!(drive.laps.iter().all(|lap| lap.valid), "{:?}", drive.laps);
        drive.lap_times()[9]
    };
    let (without, with) = (time(false), time(true));
    assert!(with < 1.05 * without, "{with} s with delay, {without} s without");
}
