//! The model the controller predicts with: nominal Jacobians plus what the regression learned.
//!
//! ```text
//! x_{t+1} = A x_t + B u_t + C       A = A^f + A^e,   B = B^f + B^e,   C = C^f + C^e
//! A^f = df/dx,   B^f = df/du,   C^f = f(z_bar) - A^f x_bar - B^f u_bar          at z_bar = (x_bar, u_bar)
//! ```
//!
//! A^e, B^e and C^e are (6), from `learning/ridge.rs`.

use fhocp::Affine;
use nalgebra::{Matrix6, Vector6};
use vehicle_model::{Discretized, Input, State, Track};

use crate::config::{RegressionConfig, RegressionMode};
use crate::controller::Setup;
use crate::learning::regression::{RegressionData, Scratch, regressor};

/// A model of one period around a point, in its two parts.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct LearnedModel {
    /// A^f, B^f, C^f. With full regression its velocity rows are zero.
    pub nominal: Affine,
    /// A^e, B^e, C^e.
    pub error: Affine,
    /// Sum of the kernel weights behind the error part.
    pub support: f64,
}

impl LearnedModel {
    /// Nominal and error model at one point.
    pub(crate) fn at(
        setup: &Setup,
        data: &RegressionData,
        x: &State,
        u: &Input,
        scratch: &mut Scratch,
    ) -> Self {
        let nominal = nominal(&setup.model, setup.config.regression.mode, &setup.track, x, u);
        let (error, support) = error(data, &setup.regression, 0, (x, u), scratch);
        Self { nominal, error, support }
    }

    /// Nominal plus error.
    #[must_use]
    pub fn sum(&self) -> Affine {
        self.nominal + self.error
    }
}

/// A^f, B^f, C^f of the discretised nominal model at (x, u).
///
/// With full regression nothing of the nominal model is left: the velocity rows are zero and the
/// pose rows are one explicit Euler step, as in Rosolia's controller.
pub(crate) fn nominal(
    model: &Discretized,
    mode: RegressionMode,
    track: &Track,
    x: &State,
    u: &Input,
) -> Affine {
    let mut affine = Affine::default();
    nominal_all(model, mode, track, &[(*x, *u)], |_| 0.0, |_, found| affine = found);
    affine
}

/// [`nominal`] at every point, with how far along s the car may be from it \[m\]; `found` gets each point's index
/// and model.
pub(crate) fn nominal_all(
    model: &Discretized,
    mode: RegressionMode,
    track: &Track,
    points: &[(State, Input)],
    far: impl Fn(usize) -> f64,
    mut found: impl FnMut(usize, Affine),
) {
    if mode == RegressionMode::Full {
        for (i, (x, _)) in points.iter().enumerate() {
            found(i, euler_pose_rows(x, track.kappa(x.s), model.dt));
        }
        return;
    }
    let road = track.road();
    model.linearize_all(points, track.road(), |i, mut linear| {
        let (x, u) = &points[i];
        model.follow_bend(x, &road, far(i), &mut linear);
        let c = linear.next - linear.a * x.to_vector() - linear.b * u.to_vector();
        found(i, Affine { a: linear.a, b: linear.b, c });
    });
}

/// A^e, B^e, C^e at (x, u), the point of stage `t`, and their support; zero without data.
pub(crate) fn error(
    data: &RegressionData,
    config: &RegressionConfig,
    t: usize,
    (x, u): (&State, &Input),
    scratch: &mut Scratch,
) -> (Affine, f64) {
    if config.mode == RegressionMode::Nominal {
        return (Affine::default(), 0.0);
    }
    let (gamma, support) = data.fit(t, &regressor(x, u), config, scratch);
    (gamma.affine(), support)
}

/// The pose rows x_plus = x + dt f_pose(x), linearised; kappa is frozen:
///
/// s'     = (v_x cos e_psi - v_y sin e_psi) / (1 - kappa e_y)
/// e_psi' = omega_z - kappa s'
/// e_y'   = v_x sin e_psi + v_y cos e_psi
fn euler_pose_rows(x: &State, kappa: f64, dt: f64) -> Affine {
    let (sin, cos) = libm::sincos(x.e_psi);
    let space = 1.0 / (1.0 - kappa * x.e_y);
    let along = x.v_x * cos - x.v_y * sin;
    let across = x.v_x * sin + x.v_y * cos;
    let s_dot = along * space;
    // Gradient of s' with respect to [v_x, v_y, omega_z, e_psi, s, e_y].
    let ds = [cos * space, -sin * space, 0.0, -across * space, 0.0, s_dot * kappa * space];
    let mut a = Matrix6::zeros();
    for (column, gradient) in ds.into_iter().enumerate() {
        a[(3, column)] = -dt * kappa * gradient;
        a[(4, column)] = dt * gradient;
    }
    a[(3, 2)] += dt;
    a[(3, 3)] += 1.0;
    a[(4, 4)] += 1.0;
    a[(5, 0)] = dt * sin;
    a[(5, 1)] = dt * cos;
    a[(5, 3)] = dt * along;
    a[(5, 5)] = 1.0;
    let next = Vector6::new(
        0.0,
        0.0,
        0.0,
        x.e_psi + dt * (x.omega_z - kappa * s_dot),
        x.s + dt * s_dot,
        x.e_y + dt * across,
    );
    Affine { a, c: next - a * x.to_vector(), ..Affine::default() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn euler_pose_rows_agree_with_differences() {
        let step = |x: &Vector6<f64>, kappa: f64, dt: f64| {
            let x = State::from_vector(x);
            let s_dot = (x.v_x * x.e_psi.cos() - x.v_y * x.e_psi.sin()) / (1.0 - kappa * x.e_y);
            [
                x.e_psi + dt * (x.omega_z - kappa * s_dot),
                x.s + dt * s_dot,
                x.e_y + dt * (x.v_x * x.e_psi.sin() + x.v_y * x.e_psi.cos()),
            ]
        };
        let x = Vector6::new(2.0, 0.1, 0.7, 0.2, 3.0, -0.2);
        let (kappa, dt, h) = (0.8, 0.1, 1e-6);
        let model = euler_pose_rows(&State::from_vector(&x), kappa, dt);
        let at = model.a * x + model.c;
        for (row, value) in step(&x, kappa, dt).into_iter().enumerate() {
            assert!((at[3 + row] - value).abs() < 1e-12);
            for column in 0..6 {
                let mut d = Vector6::zeros();
                d[column] = h;
                let slope =
                    (step(&(x + d), kappa, dt)[row] - step(&(x - d), kappa, dt)[row]) / (2.0 * h);
                assert!((model.a[(3 + row, column)] - slope).abs() < 1e-8);
            }
        }
        assert!(model.a.fixed_rows::<3>(0).iter().all(|v| *v == 0.0));
    }
}
