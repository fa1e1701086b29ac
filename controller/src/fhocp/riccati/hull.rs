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

use super::super::Fhocp;
use super::product::product;

/// Added to each sigma_j: bounds omega_j, and with it the condition of the scatter.
const REGULARISATION: f64 = 1e-7;

/// Memory and factor of the terminal system.
#[derive(Debug, Clone, Default)]
pub(super) struct Hull {
    /// Arithmetic mean of the points.
    centre: Vector6<f64>,
    /// Points about the centre.
    points: Vec<Vector6<f64>>,
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
    nu_step: f64,
}

impl Hull {
    pub(super) fn resize(&mut self, points: usize) {
        self.points.resize(points, Vector6::zeros());
        self.omega.resize(points, 0.0);
        self.g.resize(points, 0.0);
    }

    /// Reads the points of a problem.
    #[inline(always)]
    pub(super) fn load(&mut self, problem: &Fhocp) {
        let count = problem.hull.len() as f64;
        self.centre = problem.hull.iter().fold(Vector6::zeros(), |sum, point| sum + point) / count;
        for (centred, point) in self.points.iter_mut().zip(&problem.hull) {
            *centred = point - self.centre;
        }
        self.compliance = problem.terminal_slack.map(|weight| 0.5 / weight);
        self.nu = 0.0;
    }

    /// Arithmetic mean of the points.
    pub(super) fn centre(&self) -> Vector6<f64> {
        self.centre
    }

    /// Updates the costate y = 2E (x_N - X lambda).
    #[inline(always)]
    pub(super) fn costate(&mut self, x: &Vector6<f64>, lambda: &[f64]) {
        let mut e = x - self.centre;
        for (point, lambda) in self.points.iter().zip(lambda) {
            e -= point * *lambda;
        }
        self.y = e.component_div(&self.compliance);
    }

    /// J'lambda + e'E e, with e from the costate in place.
    #[inline(always)]
    pub(super) fn cost(&self, cost: &[f64], lambda: &[f64]) -> f64 {
        let weighted: f64 = cost.iter().zip(lambda).map(|(j, l)| j * l).sum();
        weighted + 0.5 * self.compliance.dot(&self.y.component_mul(&self.y))
    }

    /// Forms and factors the 6 x 6 system; false if it is not positive definite.
    #[inline(always)]
    pub(super) fn factor(&mut self, sigma: &[f64]) -> bool {
        self.total = 0.0;
        let mut sum = Vector6::zeros();
        for ((omega, sigma), point) in self.omega.iter_mut().zip(sigma).zip(&self.points) {
            *omega = 1.0 / (sigma + REGULARISATION);
            self.total += *omega;
            sum += point * *omega;
        }
        self.mean = sum / self.total;
        let mut scatter = Matrix6::from_diagonal(&self.compliance);
        for (point, omega) in self.points.iter().zip(&self.omega) {
            let d = point - self.mean;
            for (column, d_c) in scatter.data.0.iter_mut().zip(d.data.0[0]) {
                for (entry, d_r) in column.iter_mut().zip(&d.data.0[0]) {
                    *entry += omega * d_c * d_r;
                }
            }
        }
        self.system = scatter;
        let Some(factor) = Cholesky::new(scatter) else { return false };
        self.p = factor.inverse();
        true
    }

    /// Terminal gradient y - P c for the given pulls.
    #[inline(always)]
    pub(super) fn gradient(&mut self, cost: &[f64], pull: &[f64]) -> Vector6<f64> {
        let mut sum = 0.0;
        for (((g, point), (cost, pull)), omega) in
            self.g.iter_mut().zip(&self.points).zip(cost.iter().zip(pull)).zip(&self.omega)
        {
            *g = point.dot(&self.y) - cost + pull;
            sum += omega * *g;
        }
        self.g_mean = sum / self.total;
        self.c = Vector6::zeros();
        for ((g, point), omega) in self.g.iter().zip(&self.points).zip(&self.omega) {
            self.c += (point - self.mean) * (omega * (g - self.g_mean));
        }
        self.y - product(&self.p, &self.c)
    }

    /// Steps of the weights, given that of x_N.
    #[inline(always)]
    pub(super) fn direction(&mut self, dx: &Vector6<f64>, d_lambda: &mut [f64]) {
        let right = dx - self.c;
        let mut dy = product(&self.p, &right);
        // One refinement: the system's condition grows as weights leave the hull.
        dy += product(&self.p, &(right - product(&self.system, &dy)));
        let mut sum = 0.0;
        for (((d_lambda, g), point), omega) in
            d_lambda.iter_mut().zip(&self.g).zip(&self.points).zip(&self.omega)
        {
            *d_lambda = omega * (g - self.g_mean + (point - self.mean).dot(&dy));
            sum += *d_lambda;
        }
        // Rounding leaves a small sum: spread it by the same weights.
        let share = sum / self.total;
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
    pub(super) fn residual(&self, cost: &[f64], z: &[f64]) -> f64 {
        let rows = self.points.iter().zip(cost).zip(z);
        rows.map(|((point, cost), z)| (cost - point.dot(&self.y) - z + self.nu).abs())
            .fold(0.0, f64::max)
    }
}
