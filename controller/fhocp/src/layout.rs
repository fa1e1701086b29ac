//! Where each variable and row of the FHOCP (4) stands in the sparse QP, and every entry of its matrices.
//!
//! ```text
//! minimise 1/2 z' P z + q' z    subject to  A z = b (equalities),  A z <= b (inequalities)
//! ```
//!
//! Variables: x_1..x_N, u_0..u_{N-1}, lambda, terminal slack e, lane slacks s, front slip slacks,
//! rear slip slacks, speed slacks. x_0 is eliminated. Rows: dynamics, terminal, simplex
//! (equalities), then the inequalities.

use nalgebra::Vector6;
use vehicle_model::{NU, NX};

use serde::{Deserialize, Serialize};

use super::{Fhocp, SlipRow};

/// Which parts a problem has; a solver's memory is laid out once per shape.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Shape {
    pub(super) horizon: usize,
    pub(super) hull: usize,
    pub(super) rate: [bool; NU],
    pub(super) front: bool,
    pub(super) rear: bool,
    pub(super) speed: bool,
    pub(super) lag: bool,
}

impl Shape {
    pub(super) fn of(problem: &Fhocp) -> Self {
        Self {
            horizon: problem.horizon(),
            hull: problem.hull.len(),
            rate: [problem.du_max[0].is_finite(), problem.du_max[1].is_finite()],
            front: problem.front_max.is_finite(),
            rear: problem.rear_max.is_finite(),
            speed: problem.speed_max.iter().any(|v| v.is_finite()),
            lag: problem.lag != 0.0,
        }
    }

    fn count(&self, present: bool) -> usize {
        if present { self.horizon } else { 0 }
    }

    pub(super) fn x(&self, t: usize) -> usize {
        (t - 1) * NX
    }

    pub(super) fn u(&self, t: usize) -> usize {
        self.horizon * NX + t * NU
    }

    pub(super) fn lambda(&self) -> usize {
        self.horizon * (NX + NU)
    }

    fn terminal(&self) -> usize {
        self.lambda() + self.hull
    }

    fn lane(&self) -> usize {
        self.terminal() + NX
    }

    fn front_slack(&self) -> usize {
        self.lane() + self.horizon
    }

    fn rear_slack(&self) -> usize {
        self.front_slack() + self.count(self.front)
    }

    fn speed_slack(&self) -> usize {
        self.rear_slack() + self.count(self.rear)
    }

    pub(super) fn variables(&self) -> usize {
        self.speed_slack() + self.count(self.speed)
    }

    /// Equality rows: dynamics, terminal, simplex.
    pub(super) fn equalities(&self) -> usize {
        self.horizon * NX + NX + 1
    }
}

/// Receives the entries of the QP, always in the same order for one shape.
pub(super) trait Entries {
    /// P at (row, column), upper triangle.
    fn p(&mut self, row: usize, column: usize, value: f64);
    /// q at a variable.
    fn q(&mut self, variable: usize, value: f64);
    /// A at (row, column).
    fn a(&mut self, row: usize, column: usize, value: f64);
    /// The next row's right-hand side; rows come in order.
    fn b(&mut self, value: f64);
}

/// Walks through every entry of the QP: 1/2 z'Pz + q'z, equalities A z = b, then A z <= b.
pub(super) fn walk(problem: &Fhocp, shape: &Shape, out: &mut impl Entries) {
    objective(problem, shape, out);
    let mut rows = Rows { next: 0, out };
    equalities(problem, shape, &mut rows);
    inequalities(problem, shape, &mut rows);
}

fn objective(problem: &Fhocp, shape: &Shape, out: &mut impl Entries) {
    let n = shape.horizon;
    for t in 0..n {
        // (u_t - u_{t-1})^2 and (u_{t+1} - u_t)^2 both hold u_t^2; the last input has one only.
        let neighbours = if t + 1 < n { 2.0 } else { 1.0 };
        let front = &problem.front[t];
        let known = if t == 0 { front.angle(&problem.x_0, 0.0) } else { front.offset };
        let slip = [0.0, front.weight * front.steering * front.steering];
        for (i, slip) in slip.into_iter().enumerate() {
            let u = shape.u(t) + i;
            let rates = neighbours * problem.rate_cost[i];
            out.p(u, u, 2.0 * (problem.input_cost[i] + rates + slip));
            let mut pull = if i == 1 { front.pull(known) * front.steering } else { 0.0 };
            if t == 0 {
                pull -= 2.0 * problem.rate_cost[i] * problem.u_prev[i];
            } else {
                out.p(u - NU, u, -2.0 * problem.rate_cost[i]);
            }
            out.q(u, pull);
        }
        slip_cost(problem, shape, t + 1, out);
        out.p(shape.lane() + t, shape.lane() + t, 2.0 * problem.lane_quadratic);
        out.q(shape.lane() + t, problem.lane_linear);
        if shape.front {
            out.q(shape.front_slack() + t, problem.slip_linear);
        }
        if shape.rear {
            out.q(shape.rear_slack() + t, problem.slip_linear);
        }
        if shape.speed {
            out.q(shape.speed_slack() + t, problem.speed_linear);
        }
    }
    for (j, cost) in problem.hull_cost.iter().enumerate() {
        out.q(shape.lambda() + j, *cost);
    }
    for i in 0..NX {
        let e = shape.terminal() + i;
        out.p(e, e, 2.0 * problem.terminal_slack_weight[i]);
    }
}

/// The slip costs on x_t, t = 1..N: the front axle's of stage t and the rear axle's of the stage
/// before; and what couples x_t with the steering angle.
fn slip_cost(problem: &Fhocp, shape: &Shape, t: usize, out: &mut impl Entries) {
    let none = SlipRow::default();
    let front = problem.front.get(t).unwrap_or(&none);
    let rows = [front, &problem.rear[t - 1]];
    let x = shape.x(t);
    for i in 0..3 {
        out.q(x + i, rows.iter().map(|row| row.pull(row.offset) * row.velocity[i]).sum());
        for j in i..3 {
            let square = |row: &&SlipRow| 2.0 * row.weight * row.velocity[i] * row.velocity[j];
            out.p(x + i, x + j, rows.iter().map(square).sum());
        }
        if t < shape.horizon {
            let coupled = 2.0 * front.weight * front.velocity[i] * front.steering;
            out.p(x + i, shape.u(t) + 1, coupled);
        }
    }
}

fn equalities<E: Entries>(problem: &Fhocp, shape: &Shape, rows: &mut Rows<E>) {
    let n = shape.horizon;
    for (t, model) in problem.model.iter().enumerate() {
        // x_{t+1} - A x_t - B ((1 - lag) u_t + lag u_{t-1}) = C, with x_0 and u_{-1} known.
        let known = if t == 0 {
            model.a * problem.x_0 + model.c + model.b * problem.u_prev * problem.lag
        } else {
            model.c
        };
        for i in 0..NX {
            rows.a(shape.x(t + 1) + i, 1.0);
            if t > 0 {
                for j in 0..NX {
                    rows.a(shape.x(t) + j, -model.a[(i, j)]);
                }
            }
            for j in 0..NU {
                rows.a(shape.u(t) + j, -model.b[(i, j)] * (1.0 - problem.lag));
                if shape.lag && t > 0 {
                    rows.a(shape.u(t - 1) + j, -model.b[(i, j)] * problem.lag);
                }
            }
            rows.end(known[i]);
        }
    }
    for i in 0..NX {
        // x_N - X lambda - e = 0
        rows.a(shape.x(n) + i, 1.0);
        for (j, point) in problem.hull.iter().enumerate() {
            rows.a(shape.lambda() + j, -point[i]);
        }
        rows.a(shape.terminal() + i, -1.0);
        rows.end(0.0);
    }
    for j in 0..shape.hull {
        rows.a(shape.lambda() + j, 1.0);
    }
    rows.end(1.0);
}

fn inequalities<E: Entries>(problem: &Fhocp, shape: &Shape, rows: &mut Rows<E>) {
    for t in 0..shape.horizon {
        let [least, greatest] = problem.box_of(t);
        for i in 0..NU {
            let u = shape.u(t) + i;
            rows.bound(u, 1.0, greatest[i]);
            rows.bound(u, -1.0, -least[i]);
            if shape.rate[i] {
                for sign in [1.0, -1.0] {
                    rows.a(u, sign);
                    if t > 0 {
                        rows.a(u - NU, -sign);
                    }
                    let before = if t == 0 { sign * problem.u_prev[i] } else { 0.0 };
                    rows.end(problem.du_max[i] + before);
                }
            }
        }
        let (next, slack) = (shape.x(t + 1), shape.lane() + t);
        for (sign, bound) in [(1.0, problem.e_y_max[t]), (-1.0, -problem.e_y_min[t])] {
            let heading = sign * problem.lane_heading[t];
            rows.soft(&[(next + 3, heading), (next + 5, sign)], slack, bound);
        }
        rows.bound(slack, -1.0, 0.0);
        if shape.front {
            let slack = shape.front_slack() + t;
            front_rows(problem, shape, t, slack, rows);
            rows.bound(slack, -1.0, 0.0);
        }
        if shape.rear {
            let slack = shape.rear_slack() + t;
            let row = &problem.rear[t];
            for sign in [1.0, -1.0] {
                let bound = problem.rear_max * problem.rear_share[t] - sign * row.offset;
                rows.soft(&velocities(row, shape.x(t + 1), sign), slack, bound);
            }
            rows.bound(slack, -1.0, 0.0);
        }
        if shape.speed {
            let slack = shape.speed_slack() + t;
            rows.soft(&[(shape.x(t + 1), 1.0)], slack, problem.speed_max[t]);
            rows.bound(slack, -1.0, 0.0);
        }
    }
    for j in 0..shape.hull {
        rows.bound(shape.lambda() + j, -1.0, 0.0);
    }
}

fn front_rows<E: Entries>(
    problem: &Fhocp,
    shape: &Shape,
    t: usize,
    slack: usize,
    rows: &mut Rows<E>,
) {
    let row = &problem.front[t];
    let delta = shape.u(t) + 1;
    for sign in [1.0, -1.0] {
        if t == 0 {
            let known = row.angle(&problem.x_0, 0.0);
            rows.soft(
                &[(delta, sign * row.steering)],
                slack,
                problem.front_max * problem.front_share[t] - sign * known,
            );
        } else {
            for (variable, value) in velocities(row, shape.x(t), sign) {
                rows.a(variable, value);
            }
            rows.a(delta, sign * row.steering);
            rows.a(slack, -1.0);
            rows.end(problem.front_max * problem.front_share[t] - sign * row.offset);
        }
    }
}

fn velocities(row: &SlipRow, x: usize, sign: f64) -> [(usize, f64); 3] {
    [0, 1, 2].map(|i| (x + i, sign * row.velocity[i]))
}

/// Writes A row by row.
struct Rows<'a, E: Entries> {
    next: usize,
    out: &'a mut E,
}

impl<E: Entries> Rows<'_, E> {
    fn a(&mut self, column: usize, value: f64) {
        self.out.a(self.next, column, value);
    }

    fn end(&mut self, bound: f64) {
        self.out.b(bound);
        self.next += 1;
    }

    /// sign * variable <= bound
    fn bound(&mut self, variable: usize, sign: f64, bound: f64) {
        self.a(variable, sign);
        self.end(bound);
    }

    /// sum of terms - slack <= bound
    fn soft(&mut self, terms: &[(usize, f64)], slack: usize, bound: f64) {
        for &(variable, value) in terms {
            self.a(variable, value);
        }
        self.a(slack, -1.0);
        self.end(bound);
    }
}

/// Reads the state x_t of a solution vector.
pub(super) fn state(shape: &Shape, z: &[f64], t: usize) -> Vector6<f64> {
    Vector6::from_column_slice(&z[shape.x(t)..shape.x(t) + NX])
}
