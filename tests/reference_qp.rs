//! The FHOCP against QPs of an independent implementation: same objective, same first input.

#![allow(clippy::unwrap_used)] // a missing number must fail the test

use controller::fhocp::{
    Affine, Backend, Fhocp, FhocpSolver, SlipRow, Solution, Solver, Termination,
};
use lmpc_tests::read_reference;
use nalgebra::{Matrix6, Matrix6x2, Vector2, Vector6};
use serde::Deserialize;

#[derive(Deserialize)]
struct File {
    qps: Vec<Qp>,
}

/// min 1/2 x'Px + q'x, l <= Ax <= u, as triplets.
#[derive(Deserialize)]
#[allow(non_snake_case)]
struct Qp {
    n: usize,
    n_eq: usize,
    P: Triplets,
    q: Vec<f64>,
    A: Triplets,
    l: Vec<Option<f64>>,
    u: Vec<Option<f64>>,
    x_clarabel: Vec<f64>,
    obj_clarabel: f64,
    u_prev: [f64; 2],
}

#[derive(Deserialize)]
struct Triplets {
    i: Vec<usize>,
    j: Vec<usize>,
    v: Vec<f64>,
}

impl Triplets {
    fn at(&self, row: usize, column: usize) -> f64 {
        let entries = self.i.iter().zip(&self.j).zip(&self.v);
        entries.filter(|((i, j), _)| (**i, **j) == (row, column)).map(|(_, v)| v).sum()
    }
}

impl Qp {
    /// Recovers the stage form from the matrices.
    fn stages(&self, slip: bool) -> Fhocp {
        let n = (self.n_eq - 13) / 6;
        let slacks = if slip { 2 * n } else { n };
        let hull = self.n - 6 * (n + 1) - 2 * n - slacks - 6;
        let (u, lane) = (6 * (n + 1), 6 * (n + 1) + 2 * n);
        let (lambda, terminal) = (lane + n, lane + n + hull);
        let front = terminal + 6;
        let mut problem = Fhocp::new(n, hull);
        problem.x_0 = Vector6::from_fn(|i, _| self.u[i].unwrap());
        problem.u_prev = Vector2::from(self.u_prev);
        for (t, model) in problem.model.iter_mut().enumerate() {
            let row = 6 + 6 * t;
            *model = Affine {
                a: Matrix6::from_fn(|i, j| -self.A.at(row + i, 6 * t + j)),
                b: Matrix6x2::from_fn(|i, j| -self.A.at(row + i, u + 2 * t + j)),
                c: Vector6::from_fn(|i, _| self.u[row + i].unwrap()),
            };
        }
        problem.rate_cost = Vector2::from_fn(|i, _| -0.5 * self.P.at(u + i, u + 2 + i));
        problem.input_cost =
            Vector2::from_fn(|i, _| 0.5 * self.P.at(u + i, u + i) - 2.0 * problem.rate_cost[i]);
        let bound = |row: usize| self.u[row].unwrap();
        problem.u_max = Vector2::new(bound(self.n_eq), bound(self.n_eq + 2));
        problem.u_min = -Vector2::new(bound(self.n_eq + 1), bound(self.n_eq + 3));
        let lanes = self.n_eq + 4 * n;
        for t in 0..n {
            problem.e_y_max[t] = bound(lanes + 2 * t);
            problem.e_y_min[t] = -bound(lanes + 2 * t + 1);
        }
        problem.lane_linear = self.q[lane];
        problem.lane_quadratic = 0.5 * self.P.at(lane, lane);
        for j in 0..hull {
            let row = 6 + 6 * n;
            problem.hull[j] = Vector6::from_fn(|i, _| -self.A.at(row + i, lambda + j));
            problem.hull_cost[j] = self.q[lambda + j];
        }
        problem.terminal_slack_weight =
            Vector6::from_fn(|i, _| 0.5 * self.P.at(terminal + i, terminal + i));
        if slip {
            // alpha <= max + slack and -alpha <= max + slack: the offset is half the difference.
            let rows = lanes + 2 * n + n + hull;
            problem.slip_linear = self.q[front];
            problem.front_max = 0.5 * (bound(rows) + bound(rows + 1));
            for t in 0..n {
                let (up, down) = (rows + 2 * t, rows + 2 * t + 1);
                problem.front[t] = SlipRow {
                    velocity: [0, 1, 2].map(|i| self.A.at(up, 6 * t + i)),
                    steering: self.A.at(up, u + 2 * t + 1),
                    offset: 0.5 * (bound(down) - bound(up)),
                    ..SlipRow::default()
                };
            }
        }
        problem
    }
}

fn compare(name: &str, slip: bool, backend: Backend) {
    let file: File = read_reference(name);
    assert!(!file.qps.is_empty());
    let termination = Termination { tolerance: 1e-9, max_iterations: 100 };
    let mut solver = Solver::new(backend, true, termination);
    for (k, qp) in file.qps.iter().enumerate() {
        assert!(qp.l.iter().take(qp.n_eq).eq(qp.u.iter().take(qp.n_eq)), "equalities first");
        let problem = qp.stages(slip);
        let n = problem.horizon();
        let mut solution = Solution::new(n, problem.hull.len());
        let report = solver.solve(&problem, &mut solution);
        assert!(report.status.usable(), "{name} {k}: {report:?}");
        assert_eq!(report.backend, backend, "{name} {k}: no handing over");
        // The reference objective leaves out the constant r u_prev^2.
        let constant = problem.rate_cost.dot(&problem.u_prev.component_mul(&problem.u_prev));
        let objective = problem.cost(&solution) - constant;
        let error = (objective - qp.obj_clarabel).abs() / qp.obj_clarabel.abs().max(1.0);
        assert!(error < 1e-6, "{name} {k}: objective {objective} != {}", qp.obj_clarabel);
        let u_0 = 6 * (n + 1);
        for i in 0..2 {
            let (ours, theirs) = (solution.u[0][i], qp.x_clarabel[u_0 + i]);
            assert!((ours - theirs).abs() < 1e-5, "{name} {k}: u_0[{i}] {ours} != {theirs}");
        }
        for t in 0..=n {
            for i in 0..6 {
                let (ours, theirs) = (solution.x[t][i], qp.x_clarabel[6 * t + i]);
                assert!((ours - theirs).abs() < 1e-4, "{name} {k}: x_{t}[{i}] {ours} != {theirs}");
            }
        }
    }
}

fn both(name: &str, slip: bool) {
    compare(name, slip, Backend::Clarabel);
    compare(name, slip, Backend::Structured);
}

#[test]
fn reference_qps_plain() {
    both("qps_plain_N10K6.json", false);
}

#[test]
fn reference_qps_with_slip_guard() {
    both("qps_slip_N15K10.json", true);
}
