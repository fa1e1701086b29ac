//! FHOCPs of a closed loop, for the solvers' tests and benchmarks.
//!
//! A small LMPC on its own: dynamic bicycle, track of straights and arcs, safe set of four laps,
//! linearised about the shifted plan, solved by Clarabel. It is kept apart from the controller,
//! so that the solvers are tried on problems that do not depend on it.
#![allow(dead_code, missing_docs, unreachable_pub, clippy::unwrap_used, clippy::panic)]

mod car;
pub mod random;

use fhocp::{Affine, ClarabelSolver, Fhocp, FhocpSolver, SlipRow, Solution, Termination};
use nalgebra::{Vector2, Vector6};
use rand::SeedableRng;
use rand_distr::{Distribution, Normal};
use rand_pcg::Pcg64Mcg;

use car::Car;

/// What a closed loop asks of its problems.
#[derive(Debug, Clone, Copy)]
pub struct Setting {
    pub horizon: usize,
    pub hull: usize,
    pub rate_cost: [f64; 2],
    pub rate_limits: bool,
    pub front: bool,
    pub rear: bool,
    pub speed_max: f64,
    pub noise: f64,
    pub seed: u64,
}

impl Setting {
    /// The race preset's constraints and weights.
    pub fn race(horizon: usize, hull: usize, seed: u64) -> Self {
        Self {
            horizon,
            hull,
            rate_cost: [0.02, 5.0],
            rate_limits: false,
            front: true,
            rear: true,
            speed_max: f64::INFINITY,
            noise: 0.01,
            seed,
        }
    }

    /// Every row there is, and a low cost of control rates.
    pub fn every_row(horizon: usize, hull: usize, seed: u64) -> Self {
        Self {
            rate_cost: [0.1, 0.1],
            rate_limits: true,
            speed_max: 2.4,
            ..Self::race(horizon, hull, seed)
        }
    }

    /// The paper's constraints and weights.
    pub fn paper(horizon: usize, hull: usize, seed: u64) -> Self {
        Self { rate_cost: [10.0, 10.0], rear: false, ..Self::race(horizon, hull, seed) }
    }

    pub fn blank(&self) -> Fhocp {
        let mut problem = Fhocp::new(self.horizon, self.hull);
        problem.input_cost = Vector2::repeat(1e-3);
        problem.rate_cost = Vector2::from(self.rate_cost);
        problem.u_max = Vector2::new(2.0, 0.436);
        problem.u_min = -problem.u_max;
        if self.rate_limits {
            problem.du_max = Vector2::new(0.6, 0.2);
        }
        problem.e_y_max.fill(0.45);
        problem.e_y_min.fill(-0.45);
        problem.lane_linear = 25.0;
        problem.lane_quadratic = 100.0;
        problem.front_max = if self.front { 0.14 } else { f64::INFINITY };
        problem.rear_max = if self.rear { 0.14 } else { f64::INFINITY };
        problem.slip_linear = 200.0;
        problem.speed_max.fill(self.speed_max);
        problem.speed_linear = 25.0;
        problem.terminal_slack_weight = Vector6::new(40.0, 4.0, 4.0, 40.0, 40.0, 40.0);
        problem
    }
}

type Sample = (Vector6<f64>, f64);

/// Problems of `count` successive steps of a closed loop.
pub fn closed_loop(setting: &Setting, count: usize) -> Vec<Fhocp> {
    let car = Car::default();
    let mut random = Pcg64Mcg::seed_from_u64(setting.seed);
    let normal = Normal::new(0.0, 1.0).unwrap();
    let mut laps: Vec<Vec<Sample>> =
        [1.4, 1.6, 1.8, 2.0].iter().map(|speed| warm_up(&car, *speed)).collect();
    let mut solver = ClarabelSolver::new(Termination { tolerance: 1e-8, max_iterations: 60 });
    let mut problem = setting.blank();
    let mut solution = Solution::new(setting.horizon, setting.hull);
    let mut problems = Vec::with_capacity(count);
    let mut lap = Vec::new();
    let (mut x, mut guess, mut plan) = restart(&car, setting);
    while problems.len() < count {
        problem.x_0 = x + Vector6::from_fn(|_, _| 0.2 * setting.noise * normal.sample(&mut random));
        guess[0] = problem.x_0;
        pose(&car, &laps, &guess, &plan, &mut problem);
        for model in &mut problem.model {
            for j in 0..3 {
                model.a[(j, j)] *= 1.0 + setting.noise * normal.sample(&mut random);
            }
            model.b *= 1.0 + setting.noise * normal.sample(&mut random);
        }
        problems.push(problem.clone());
        let usable = solver.solve(&problem, &mut solution).status.usable();
        lap.push((x, 0.0));
        if usable {
            plan.clone_from(&solution.u);
            guess.clone_from(&solution.x);
        }
        x = car.step(&x, &plan[0]);
        problem.u_prev = plan[0];
        plan.rotate_left(1);
        let last = plan.len() - 1;
        plan[last] = plan[last - 1];
        guess.rotate_left(1);
        guess[last + 1] = car.step(&guess[last], &plan[last]);
        if x[4] > car.length() {
            store(&mut laps, &mut lap, car.length());
            x[4] -= car.length();
            for guess in &mut guess {
                guess[4] -= car.length();
            }
        }
        if !usable || x[5].abs() > 0.9 || x[0] < 0.6 || x[3].abs() > 1.2 {
            (x, guess, plan) = restart(&car, setting);
            problem.u_prev = Vector2::zeros();
            lap.clear();
        }
    }
    problems
}

fn restart(car: &Car, setting: &Setting) -> (Vector6<f64>, Vec<Vector6<f64>>, Vec<Vector2<f64>>) {
    let x = Vector6::new(1.6, 0.0, 0.0, 0.0, 0.0, 0.0);
    let mut plan = Vec::new();
    let mut guess = vec![x];
    let mut state = x;
    for _ in 0..setting.horizon {
        let u = car.follow(&state, 1.6);
        state = car.step(&state, &u);
        plan.push(u);
        guess.push(state);
    }
    (x, guess, plan)
}

fn warm_up(car: &Car, speed: f64) -> Vec<Sample> {
    let mut x = Vector6::new(speed, 0.0, 0.0, 0.0, 0.0, 0.0);
    let mut lap = Vec::new();
    while x[4] <= car.length() {
        lap.push((x, 0.0));
        x = car.step(&x, &car.follow(&x, speed));
    }
    let mut laps = Vec::new();
    store(&mut laps, &mut lap, car.length());
    laps.swap_remove(0)
}

/// Gives a lap its cost-to-go and its continuation past the line, and keeps the four fastest.
fn store(laps: &mut Vec<Vec<Sample>>, lap: &mut Vec<Sample>, length: f64) {
    let steps = lap.len();
    let mut done: Vec<Sample> =
        lap.iter().enumerate().map(|(k, (x, _))| (*x, (steps - k) as f64)).collect();
    for (k, (x, _)) in lap.iter().enumerate() {
        let mut x = *x;
        x[4] += length;
        done.push((x, -(k as f64)));
    }
    lap.clear();
    laps.push(done);
    laps.sort_by_key(Vec::len);
    laps.truncate(4);
}

/// Linearises about the plan and takes the safe set around its end.
fn pose(
    car: &Car,
    laps: &[Vec<Sample>],
    guess: &[Vector6<f64>],
    plan: &[Vector2<f64>],
    problem: &mut Fhocp,
) {
    for (t, u) in plan.iter().enumerate() {
        let x = guess[t];
        let (a, b, next) = car.linearise(&x, u);
        problem.model[t] = Affine { a, b, c: next - a * x - b * u };
        problem.front[t] = slip(car, &x, Some(u[1]));
        problem.rear[t] = slip(car, &guess[t + 1], None);
    }
    let x = guess[plan.len()];
    let share = problem.hull.len().div_ceil(laps.len());
    let mut points: Vec<Sample> = Vec::new();
    for lap in laps {
        let distance = |p: &Vector6<f64>| {
            (p - x).component_mul(&Vector6::new(0.3, 0.1, 0.02, 0.3, 1.0, 0.5)).norm_squared()
        };
        let mut order: Vec<&Sample> = lap.iter().collect();
        order.sort_by(|p, q| distance(&p.0).total_cmp(&distance(&q.0)));
        points.extend(order.into_iter().take(share).copied());
    }
    for (j, (x, cost)) in points.iter().take(problem.hull.len()).enumerate() {
        problem.hull[j] = *x;
        problem.hull_cost[j] = *cost;
    }
}

/// Slip angle linearised at x: front with the steering angle, rear without.
fn slip(car: &Car, x: &Vector6<f64>, delta: Option<f64>) -> SlipRow {
    let angle = |x: &Vector6<f64>| match delta {
        Some(delta) => car.slip(x, delta).0,
        None => car.slip(x, 0.0).1,
    };
    let h = 1e-6;
    let velocity = [0, 1, 2].map(|i| {
        let mut above = *x;
        above[i] += h;
        (angle(&above) - angle(x)) / h
    });
    let steering = if delta.is_some() { 1.0 } else { 0.0 };
    let mut row = SlipRow { velocity, steering, ..SlipRow::default() };
    row.offset = angle(x) - row.angle(x, delta.unwrap_or(0.0));
    row
}
