//! The terminal constraint x_N = X lambda + e with the hull eliminated.
//!
//! With e = x_N - X lambda substituted, y = 2 E e is the costate of x_N. Newton's step for the
//! weights lambda (their rows have curvature sigma_j and pull_j) under 1' dlambda = 0, with
//! multiplier nu of that sum, is
//!
//! ```text
//! sigma_j dlambda_j = x_j'(y + dy) - J_j + pull_j - nu
//! ```
//!
//! Let omega_j = 1 / sigma_j, x_bar the omega-weighted mean of the points, S their weighted
//! scatter about it, and g_j = x_j'y - J_j + pull_j with mean g_bar. Eliminating nu, then
//! lambda:
//!
//! ```text
//! dlambda_j = omega_j (g_j - g_bar + (x_j - x_bar)'dy)
//! dy        = P (dx_N - c),    P = ((2E)^-1 + S)^-1,    c = sum omega_j (x_j - x_bar)(g_j - g_bar)
//! ```
//!
//! so the hull costs one 6 x 6 system: P is the terminal curvature and y - P c the terminal
//! gradient of the Riccati recursion. Working with the increment dy about y, with points centred
//! on their mean, keeps the digits that absolute multipliers and long tracks would lose.

use nalgebra::{Cholesky, Matrix6, Vector6};
use vehicle_model::NX;

use super::super::Fhocp;
use super::product::product;
use vector_sums::{dot, dots, sum};

/// Added to each sigma_j: bounds omega_j, and with it the condition of the scatter.
const REGULARISATION: f64 = 1e-7;

/// One number of each point, for each state: loops over the points become vector instructions.
type Columns = [Vec<f64>; NX];

/// Memory and factor of the terminal system.
#[derive(Debug, Clone, Default)]
pub(super) struct Hull {
    /// Arithmetic mean of the points.
    centre: Vector6<f64>,
    /// Points about the centre.
    points: Columns,
    /// Points about their omega-weighted mean, x_j - x_bar.
    centred: Columns,
    /// (2E)^-1, diagonal.
    compliance: Vector6<f64>,
    omega: Vec<f64>,
    /// omega-weighted mean of the points, x_bar, and sum of omega.
    mean: Vector6<f64>,
    total: f64,
    system: Matrix6<f64>,
    /// Terminal curvature P.
    pub(super) p: Matrix6<f64>,
    /// g_j.
    g: Vec<f64>,
    g_mean: f64,
    c: Vector6<f64>,
    /// Costate y of x_N.
    pub(super) y: Vector6<f64>,
    /// Multiplier of the sum of weights, and its step.
    nu: f64,
    pub(super) nu_step: f64,
    /// One number of each point, for sums.
    weighted: Vec<f64>,
}

impl Hull {
    pub(super) fn resize(&mut self, points: usize) {
        let columns = self.points.iter_mut().chain(&mut self.centred);
        for values in columns.chain([&mut self.omega, &mut self.g, &mut self.weighted]) {
            values.resize(points, 0.0);
        }
    }

    /// Reads the points of a problem.
    #[inline(always)]
    pub(super) fn load(&mut self, problem: &Fhocp) {
        let count = problem.hull.len() as f64;
        self.centre = problem.hull.iter().fold(Vector6::zeros(), |sum, point| sum + point) / count;
        for (i, column) in self.points.iter_mut().enumerate() {
            for (centred, point) in column.iter_mut().zip(&problem.hull) {
                *centred = point[i] - self.centre[i];
            }
        }
        self.compliance = problem.terminal_slack_weight.map(|weight| 0.5 / weight);
        self.nu = 0.0;
    }

    /// Arithmetic mean of the points.
    pub(super) fn centre(&self) -> Vector6<f64> {
        self.centre
    }

    /// Updates the costate y = 2E (x_N - X lambda).
    #[inline(always)]
    pub(super) fn costate(&mut self, x: &Vector6<f64>, lambda: &[f64]) {
        let e = x - self.centre - combination(&self.points, lambda);
        self.y = e.component_div(&self.compliance);
    }

    /// J'lambda + e'E e, with e from the costate in place.
    #[inline(always)]
    pub(super) fn cost(&self, cost: &[f64], lambda: &[f64]) -> f64 {
        dot(cost, lambda) + 0.5 * self.compliance.dot(&self.y.component_mul(&self.y))
    }

    /// Forms and factors the 6 x 6 system; false if it is not positive definite.
    #[inline(always)]
    pub(super) fn factor(&mut self, sigma: &[f64]) -> bool {
        for (omega, sigma) in self.omega.iter_mut().zip(sigma) {
            *omega = 1.0 / (sigma + REGULARISATION);
        }
        self.total = sum(&self.omega);
        self.mean = combination(&self.points, &self.omega) / self.total;
        for (i, (centred, points)) in self.centred.iter_mut().zip(&self.points).enumerate() {
            for (centred, point) in centred.iter_mut().zip(points) {
                *centred = point - self.mean[i];
            }
        }
        let mut scatter = Matrix6::from_diagonal(&self.compliance);
        self.scatter::<1>(&mut scatter);
        self.scatter::<2>(&mut scatter);
        self.scatter::<3>(&mut scatter);
        self.scatter::<4>(&mut scatter);
        self.scatter::<5>(&mut scatter);
        self.scatter::<6>(&mut scatter);
        self.system = scatter;
        let Some(factor) = Cholesky::new(scatter) else { return false };
        self.p = factor.inverse();
        true
    }

    /// Adds the first entries of a column of the scatter, to the one on the diagonal, and its mirror image.
    #[inline(always)]
    fn scatter<const ENTRIES: usize>(&mut self, scatter: &mut Matrix6<f64>) {
        let column = ENTRIES - 1;
        let rows = self.omega.iter().zip(&self.centred[column]);
        for (weighted, (omega, d)) in self.weighted.iter_mut().zip(rows) {
            *weighted = omega * d;
        }
        let mut rows = [&[][..]; ENTRIES];
        for (row, centred) in rows.iter_mut().zip(&self.centred) {
            *row = centred;
        }
        for (row, entry) in dots(&self.weighted, rows).into_iter().enumerate() {
            scatter[(row, column)] += entry;
            scatter[(column, row)] = scatter[(row, column)];
        }
    }

    /// Terminal gradient y - P c for the given pulls.
    #[inline(always)]
    pub(super) fn gradient(&mut self, cost: &[f64], pull: &[f64]) -> Vector6<f64> {
        project(&self.points, &self.y, &mut self.g);
        for (g, (cost, pull)) in self.g.iter_mut().zip(cost.iter().zip(pull)) {
            *g += pull - cost;
        }
        self.g_mean = dot(&self.omega, &self.g) / self.total;
        let rows = self.omega.iter().zip(&self.g);
        for (weighted, (omega, g)) in self.weighted.iter_mut().zip(rows) {
            *weighted = omega * (g - self.g_mean);
        }
        self.c = combination(&self.centred, &self.weighted);
        self.y - product(&self.p, &self.c)
    }

    /// Steps of the weights, given that of x_N.
    #[inline(always)]
    pub(super) fn direction(&mut self, dx: &Vector6<f64>, d_lambda: &mut [f64]) {
        let right = dx - self.c;
        let mut dy = product(&self.p, &right);
        // One refinement: the system's condition grows as weights leave the hull.
        dy += product(&self.p, &(right - product(&self.system, &dy)));
        project(&self.centred, &dy, d_lambda);
        for (d_lambda, (omega, g)) in d_lambda.iter_mut().zip(self.omega.iter().zip(&self.g)) {
            *d_lambda = omega * (g - self.g_mean + *d_lambda);
        }
        // Rounding leaves a small sum: spread it by the same weights.
        let share = sum(d_lambda) / self.total;
        for (d_lambda, omega) in d_lambda.iter_mut().zip(&self.omega) {
            *d_lambda -= share * omega;
        }
        self.nu_step = self.g_mean + self.mean.dot(&dy) - self.nu;
    }

    #[inline(always)]
    pub(super) fn advance(&mut self, step: f64) {
        self.nu += step * self.nu_step;
    }

    /// Greatest residual of the weights' stationarity.
    #[inline(always)]
    pub(super) fn residual(&mut self, cost: &[f64], z: &[f64]) -> f64 {
        project(&self.points, &self.y, &mut self.weighted);
        let rows = self.weighted.iter().zip(cost).zip(z);
        rows.map(|((x_y, cost), z)| (cost - x_y - z + self.nu).abs()).fold(0.0, f64::max)
    }
}

/// Sum of the points, each times its weight.
#[inline(always)]
fn combination(points: &Columns, weights: &[f64]) -> Vector6<f64> {
    let [v_x, v_y, omega_z, e_psi, s, e_y] = points;
    Vector6::from(dots(weights, [v_x, v_y, omega_z, e_psi, s, e_y]))
}

/// Inner product of each point with y.
#[inline(always)]
fn project(points: &Columns, y: &Vector6<f64>, out: &mut [f64]) {
    let [v_x, v_y, omega_z, e_psi, s, e_y] = points;
    let (first, second) = (v_x.iter().zip(v_y).zip(omega_z), e_psi.iter().zip(s).zip(e_y));
    for ((out, ((v_x, v_y), omega_z)), ((e_psi, s), e_y)) in out.iter_mut().zip(first).zip(second) {
        *out = (v_x * y[0] + v_y * y[1] + omega_z * y[2]) + (e_psi * y[3] + s * y[4] + e_y * y[5]);
    }
}
