//! One control step of a model: Runge-Kutta 4 with the input held, and its exact Jacobians.

mod variation;

use nalgebra::{Const, Matrix6, Matrix6x2, U1, Vector6};
use num_dual::DualSVec64;

use variation::By;

use crate::model::{Model, ModelKind, Number, PoseConvention, pose_rates, state_array};
use crate::state::{Input, NU, NX, State};

/// Directions of a linearisation: six states, two inputs.
const DIRECTIONS: usize = NX + NU;

/// A model sampled with a control step: `substeps` steps of Runge-Kutta 4 over `dt`.
///
/// The curvature is looked up at every stage from the value of s and frozen in the Jacobian
/// (d kappa/d s = 0): differences across a jump of curvature would be meaningless and huge.
#[derive(Debug, Clone, PartialEq)]
pub struct Discretized {
    /// The continuous model.
    pub model: Model,
    /// Control step [s].
    pub dt: f64,
    /// Runge-Kutta steps in one control step, at least 1.
    pub substeps: usize,
}

/// First-order model of one control step, x_next ~ next + A (x - x_bar) + B (u - u_bar).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Linearization {
    /// State after the step, equal to [`Discretized::next`]; s is not wrapped.
    pub next: Vector6<f64>,
    /// Jacobian by the state.
    pub a: Matrix6<f64>,
    /// Jacobian by the input.
    pub b: Matrix6x2<f64>,
}

impl Discretized {
    /// State after one control step; s is not wrapped.
    pub fn next(&self, x: &State, u: &Input, kappa: impl Fn(f64) -> f64) -> State {
        let next = self.step(&state_array(x), &[u.a, u.delta], &self.model.grip, &kappa);
        State::from_vector(&Vector6::from(next))
    }

    /// State after one control step with its Jacobians by state and input, exact by dual numbers.
    pub fn linearize(&self, x: &State, u: &Input, kappa: impl Fn(f64) -> f64) -> Linearization {
        match self.model.kind {
            ModelKind::Dynamic => variation::linearize(self, x, u, By::Input, &kappa),
            ModelKind::Kinematic => self.linearize_directly(x, u, &kappa),
        }
    }

    /// The whole step in dual numbers: short, and cheap enough where the velocities are algebraic.
    fn linearize_directly(
        &self,
        x: &State,
        u: &Input,
        kappa: &impl Fn(f64) -> f64,
    ) -> Linearization {
        type Dual = DualSVec64<DIRECTIONS>;
        let values = state_array(x);
        let state: [Dual; NX] = std::array::from_fn(|i| Dual::from_re(values[i]).derivative(i));
        let input = [Dual::from_re(u.a).derivative(NX), Dual::from_re(u.delta).derivative(NX + 1)];
        let grip = self.model.grip.map(Dual::from_re);
        let next = self.step(&state, &input, &grip, kappa);

        let mut a = Matrix6::zeros();
        let mut b = Matrix6x2::zeros();
        for (row, number) in next.iter().enumerate() {
            let gradient = number.eps.unwrap_generic(Const::<DIRECTIONS>, U1);
            for column in 0..NX {
                a[(row, column)] = gradient[column];
            }
            for column in 0..NU {
                b[(row, column)] = gradient[NX + column];
            }
        }
        Linearization { next: self.next(x, u, kappa).to_vector(), a, b }
    }

    /// State after one control step and its Jacobian by the grip factors of the front and rear
    /// axle: what a least-squares fit of the friction needs.
    pub fn grip_jacobian(
        &self,
        x: &State,
        u: &Input,
        kappa: impl Fn(f64) -> f64,
    ) -> (Vector6<f64>, Matrix6x2<f64>) {
        match self.model.kind {
            ModelKind::Dynamic => {
                let found = variation::linearize(self, x, u, By::Grip, &kappa);
                (found.next, found.b)
            }
            // A car that rolls has all the grip it needs.
            ModelKind::Kinematic => (self.next(x, u, kappa).to_vector(), Matrix6x2::zeros()),
        }
    }

    /// Number and length of the Runge-Kutta steps.
    fn grid(&self) -> (usize, f64) {
        let substeps = self.substeps.max(1);
        #[expect(clippy::cast_precision_loss, reason = "a handful of sub-steps")]
        let h = self.dt / substeps as f64;
        (substeps, h)
    }

    fn step<T: Number>(
        &self,
        x: &[T; NX],
        u: &[T; NU],
        grip: &[T; 2],
        kappa: &impl Fn(f64) -> f64,
    ) -> [T; NX] {
        let (substeps, h) = self.grid();
        match self.model.kind {
            ModelKind::Dynamic => (0..substeps).fold(*x, |x, _| {
                runge_kutta_4(&x, h, |x, _| {
                    self.model.derivative_generic(x, u, kappa(x[4].re()), grip)
                })
            }),
            ModelKind::Kinematic => self.kinematic_step(x, u, substeps, h, kappa),
        }
    }

    /// Velocity rows jump to their new values, pose rows are integrated along the velocities of
    /// the pose convention.
    fn kinematic_step<T: Number>(
        &self,
        x: &[T; NX],
        u: &[T; NU],
        substeps: usize,
        h: f64,
        kappa: &impl Fn(f64) -> f64,
    ) -> [T; NX] {
        let measured = [x[0], x[1], x[2]];
        let reached = self.model.kinematic_velocities(x, u, self.dt);
        let a = self.model.kinematic_rate(x, u);
        let velocities = |t: f64| match self.model.pose {
            PoseConvention::Held => measured,
            PoseConvention::Algebraic => self.model.rolling_velocities(measured[0] + a * t, u[1]),
            PoseConvention::Interpolated => {
                let share = t / self.dt;
                std::array::from_fn(|i| measured[i] + (reached[i] - measured[i]) * share)
            }
        };
        let mut pose = [x[3], x[4], x[5]];
        for i in 0..substeps {
            #[expect(clippy::cast_precision_loss, reason = "a handful of sub-steps")]
            let start = i as f64 * h;
            pose = runge_kutta_4(&pose, h, |pose, t| {
                pose_rates(&velocities(start + t), pose, kappa(pose[1].re()))
            });
        }
        [reached[0], reached[1], reached[2], pose[0], pose[1], pose[2]]
    }
}

/// One step of the classical Runge-Kutta method of order four; `f` sees the time since its start.
pub(crate) fn runge_kutta_4<T: Number, const N: usize>(
    x: &[T; N],
    h: f64,
    f: impl Fn(&[T; N], f64) -> [T; N],
) -> [T; N] {
    let ahead = |k: &[T; N], h: f64| std::array::from_fn(|i| x[i] + k[i] * h);
    let k1 = f(x, 0.0);
    let k2 = f(&ahead(&k1, h / 2.0), h / 2.0);
    let k3 = f(&ahead(&k2, h / 2.0), h / 2.0);
    let k4 = f(&ahead(&k3, h), h);
    std::array::from_fn(|i| x[i] + (k1[i] + (k2[i] + k3[i]) * 2.0 + k4[i]) * (h / 6.0))
}
