//! The finite-horizon optimal control problem, the FHOCP (4) of the paper, in stage form, and its solution.
//!
//! ```text
//! minimise   sum_t  c_u |u_t|^2 + r' (u_t - u_{t-1})^2           t = 0..N-1
//!          + sum_t  l s_t + q s_t^2  (lane)  + w f_t  (front slip) + w g_t  (rear slip) + v p_t
//!          + sum_t  c_f (alpha_f - ref_f)^2 + c_r (alpha_r - ref_r)^2   (tyre dissipation)
//!          + J' lambda + e' E e
//! subject to x_{t+1} = A_t x_t + B_t ((1 - lag) u_t + lag u_{t-1}) + C_t
//!            u_min <= u_0 <= u_max,   u_min + r_min <= u_t <= u_max - r_max   t = 1..N-1
//!            |u_t - u_{t-1}| <= du_max                            t = 0..N-1
//!            e_y_min_t - s_t <= e_y(x_t) + h_t e_psi(x_t) <= e_y_max_t + s_t       t = 1..N
//!            |alpha_f(x_t, u_t)| <= front_max share_t + f_t       t = 0..N-1
//!            |alpha_r(x_t)| <= rear_max share_t + g_t                     t = 1..N
//!            v_x(x_t) <= speed_max_t + p_t                        t = 1..N
//!            x_N = X lambda + e,  lambda >= 0,  1' lambda = 1,  slacks >= 0
//! ```
//!
//! Every state constraint is soft, so the problem is feasible for any measured x_0.

#![forbid(unsafe_code)]
// The same bits on every machine: no function of the platform's mathematical library.
#![cfg_attr(not(test), deny(clippy::disallowed_methods))]

mod affine;
mod clarabel_solver;
mod layout;
mod report;
mod riccati;
mod slacks;
mod solver;

use nalgebra::{Vector2, Vector6};
use vector_sums::naught;

pub use affine::Affine;
pub use clarabel_solver::{ClarabelSolver, SolverSeed};
pub use report::{Backend, FhocpSolver, SolveReport, SolveStatus, Termination};
pub use riccati::RiccatiSolver;
pub use slacks::{Slacks, greatest};
pub use solver::Solver;

/// A slip angle, linearised: alpha = velocity' [v_x, v_y, omega_z] + steering delta + offset.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SlipRow {
    /// Gradient with respect to [v_x, v_y, omega_z].
    pub velocity: [f64; 3],
    /// Gradient with respect to the steering angle.
    pub steering: f64,
    /// Constant part \[rad\].
    pub offset: f64,
    /// Weight of the squared distance of the angle from `reference`, in steps [1/rad^2].
    pub weight: f64,
    /// Slip angle of the point of linearisation \[rad\].
    pub reference: f64,
}

impl SlipRow {
    /// The linearised slip angle \[rad\].
    #[must_use]
    pub fn angle(&self, x: &Vector6<f64>, delta: f64) -> f64 {
        let [g_x, g_y, g_w] = self.velocity;
        g_x * x[0] + g_y * x[1] + g_w * x[2] + self.steering * delta + self.offset
    }

    /// Slope of [`SlipRow::cost`] where the angle is `angle`.
    fn pull(&self, angle: f64) -> f64 {
        2.0 * self.weight * (angle - self.reference)
    }

    /// Cost of the angle's distance from its reference, in steps.
    fn cost(&self, x: &Vector6<f64>, delta: f64) -> f64 {
        self.weight * (self.angle(x, delta) - self.reference).powi(2)
    }
}

/// The problem in stage form; see the module's doc for the meaning of each part.
#[derive(Debug, Clone, PartialEq)]
pub struct Fhocp {
    /// Measured (or predicted) initial state x_0.
    pub x_0: Vector6<f64>,
    /// Input before the first, u_{-1}.
    pub u_prev: Vector2<f64>,
    /// Model of each stage in terms of its mean input, N.
    pub model: Vec<Affine>,
    /// Share of u_{t-1} in the mean input of stage t, the rest being u_t; 0 without actuator lag.
    pub lag: f64,
    /// Weight c_u of each squared input.
    pub input_cost: Vector2<f64>,
    /// Weight r of each squared difference of successive inputs.
    pub rate_cost: Vector2<f64>,
    /// Least inputs.
    pub u_min: Vector2<f64>,
    /// Greatest inputs.
    pub u_max: Vector2<f64>,
    /// What the stages after the first leave of the least and of the greatest inputs, for feedback.
    pub reserve: [Vector2<f64>; 2],
    /// Greatest difference of successive inputs; infinite for none.
    pub du_max: Vector2<f64>,
    /// Lever h of the heading error in the lane of stage t + 1, N [m/rad].
    pub lane_heading: Vec<f64>,
    /// Least e_y + h e_psi of stage t + 1, N \[m\].
    pub e_y_min: Vec<f64>,
    /// Greatest e_y + h e_psi of stage t + 1, N \[m\].
    pub e_y_max: Vec<f64>,
    /// Linear weight of the lane slack.
    pub lane_linear: f64,
    /// Quadratic weight of the lane slack.
    pub lane_quadratic: f64,
    /// Front slip angle of stage t, N.
    pub front: Vec<SlipRow>,
    /// Rear slip angle of stage t + 1, N.
    pub rear: Vec<SlipRow>,
    /// Bound on the front slip angle; infinite for none \[rad\].
    pub front_max: f64,
    /// Bound on the rear slip angle; infinite for none \[rad\].
    pub rear_max: f64,
    /// Share of `rear_max` that bounds stage t + 1, N.
    pub rear_share: Vec<f64>,
    /// Share of `front_max` that bounds stage t, N.
    pub front_share: Vec<f64>,
    /// Linear weight of the slip slacks.
    pub slip_linear: f64,
    /// Greatest v_x of stage t + 1, N; all infinite for none [m/s].
    pub speed_max: Vec<f64>,
    /// Linear weight of the speed slack.
    pub speed_linear: f64,
    /// Safe-set points, the columns of X.
    pub hull: Vec<Vector6<f64>>,
    /// Cost-to-go J of each point, in steps.
    pub hull_cost: Vec<f64>,
    /// Diagonal of E, the quadratic weights of the terminal slack.
    pub terminal_slack_weight: Vector6<f64>,
}

impl Fhocp {
    /// A problem of the given size, with no constraint active and all entries zero.
    #[must_use]
    pub fn new(horizon: usize, hull: usize) -> Self {
        Self {
            x_0: Vector6::zeros(),
            u_prev: Vector2::zeros(),
            model: vec![Affine::default(); horizon],
            lag: 0.0,
            input_cost: Vector2::zeros(),
            rate_cost: Vector2::zeros(),
            u_min: Vector2::repeat(-1.0),
            u_max: Vector2::repeat(1.0),
            reserve: [Vector2::zeros(); 2],
            du_max: Vector2::repeat(f64::INFINITY),
            lane_heading: vec![0.0; horizon],
            e_y_min: vec![-1.0; horizon],
            e_y_max: vec![1.0; horizon],
            lane_linear: 0.0,
            lane_quadratic: 1.0,
            front: vec![SlipRow::default(); horizon],
            rear: vec![SlipRow::default(); horizon],
            front_max: f64::INFINITY,
            rear_max: f64::INFINITY,
            rear_share: vec![1.0; horizon],
            front_share: vec![1.0; horizon],
            slip_linear: 0.0,
            speed_max: vec![f64::INFINITY; horizon],
            speed_linear: 0.0,
            hull: vec![Vector6::zeros(); hull],
            hull_cost: vec![0.0; hull],
            terminal_slack_weight: Vector6::repeat(1.0),
        }
    }

    /// Number of stages N.
    #[must_use]
    pub fn horizon(&self) -> usize {
        self.model.len()
    }

    /// Least and greatest inputs of stage t.
    #[must_use]
    pub fn box_of(&self, t: usize) -> [Vector2<f64>; 2] {
        if t == 0 {
            return [self.u_min, self.u_max];
        }
        [self.u_min + self.reserve[0], self.u_max - self.reserve[1]]
    }

    /// State after stage t from x_t, u_t and the input before it.
    #[must_use]
    pub fn next(
        &self,
        t: usize,
        x: &Vector6<f64>,
        u: &Vector2<f64>,
        before: &Vector2<f64>,
    ) -> Vector6<f64> {
        self.model[t].apply(x, &(u * (1.0 - self.lag) + before * self.lag))
    }

    /// Whether every number that reaches a solver is finite (infinite bounds apart).
    #[must_use]
    pub fn is_finite(&self) -> bool {
        let mut sum = naught(self.x_0.as_slice()) + naught(self.terminal_slack_weight.as_slice());
        sum += naught(self.u_prev.as_slice()) + naught(&self.hull_cost);
        sum += naught(&self.e_y_min) + naught(&self.e_y_max);
        sum += naught(&self.lane_heading);
        for point in &self.hull {
            sum += naught(point.as_slice());
        }
        for model in &self.model {
            sum += naught(model.a.as_slice()) + naught(model.b.as_slice());
            sum += naught(model.c.as_slice());
        }
        for row in self.front.iter().chain(&self.rear) {
            let rest = [row.steering, row.offset, row.weight, row.reference];
            sum += naught(&row.velocity) + naught(&rest);
        }
        sum == 0.0
    }

    /// The optimal value's formula, evaluated at a trajectory: slacks as small as it allows.
    #[must_use]
    pub fn cost(&self, solution: &Solution) -> f64 {
        self.cost_with(solution, &Slacks::of(self, solution))
    }

    /// [`Fhocp::cost`] of a trajectory whose slacks are known.
    #[must_use]
    pub fn cost_with(&self, solution: &Solution, slacks: &Slacks) -> f64 {
        let mut u_before = self.u_prev;
        let mut cost = 0.0;
        for u in &solution.u {
            let du = u - u_before;
            cost += self.input_cost.dot(&u.component_mul(u));
            cost += self.rate_cost.dot(&du.component_mul(&du));
            u_before = *u;
        }
        for (t, u) in solution.u.iter().enumerate() {
            cost += self.front[t].cost(&solution.x[t], u[1]);
            cost += self.rear[t].cost(&solution.x[t + 1], 0.0);
        }
        for s in &slacks.lane {
            cost += self.lane_linear * s + self.lane_quadratic * s * s;
        }
        cost +=
            self.slip_linear * (slacks.front.iter().sum::<f64>() + slacks.rear.iter().sum::<f64>());
        cost += self.speed_linear * slacks.speed.iter().sum::<f64>();
        cost += self.cost_to_go(solution);
        cost + self.terminal_slack_cost(solution)
    }

    /// Interpolated cost-to-go of the terminal state, J' lambda \[steps\].
    #[must_use]
    pub fn cost_to_go(&self, solution: &Solution) -> f64 {
        self.hull_cost.iter().zip(&solution.lambda).map(|(j, l)| j * l).sum::<f64>()
    }

    /// Cost of the terminal slack, e' E e \[steps\].
    #[must_use]
    pub fn terminal_slack_cost(&self, solution: &Solution) -> f64 {
        let mut e = solution.x[self.horizon()];
        for (point, lambda) in self.hull.iter().zip(&solution.lambda) {
            e -= point * *lambda;
        }
        self.terminal_slack_weight.dot(&e.component_mul(&e))
    }
}

/// Trajectory and terminal weights found by a solver.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Solution {
    /// States x_0..x_N.
    pub x: Vec<Vector6<f64>>,
    /// Inputs u_0..u_{N-1}.
    pub u: Vec<Vector2<f64>>,
    /// Weights of the safe-set points.
    pub lambda: Vec<f64>,
}

impl Solution {
    /// An all-zero solution of the given size.
    #[must_use]
    pub fn new(horizon: usize, hull: usize) -> Self {
        Self {
            x: vec![Vector6::zeros(); horizon + 1],
            u: vec![Vector2::zeros(); horizon],
            lambda: vec![0.0; hull],
        }
    }

    /// Whether every entry is finite.
    #[must_use]
    pub fn is_finite(&self) -> bool {
        self.x.iter().flat_map(|x| x.iter()).all(|v| v.is_finite())
            && self.u.iter().flat_map(|u| u.iter()).all(|v| v.is_finite())
            && self.lambda.iter().all(|v| v.is_finite())
    }
}
