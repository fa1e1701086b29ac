//! Jacobians of a Runge-Kutta step from the variational equations.
//!
//! The sensitivities of the state obey d/dt S = F S + G with the Jacobians F and G of the
//! continuous model. Integrated beside the state by the same Runge-Kutta steps they are the exact
//! Jacobians of the discrete step. F and G come from dual numbers; the velocities depend on
//! neither pose nor s, so the system falls into small blocks:
//!
//! V = d v/d(v_0, p),  P = d pose/d(v_0, p),  Q = d pose/d pose_0,
//!
//! p being two parameters held over the step: the input, or the grip factors.

use nalgebra::{Matrix3, Matrix6, Matrix6x2, SMatrix, Vector6};
use num_dual::DualSVec64;

use super::{Discretized, Linearization, runge_kutta_4};
use crate::model::{pose_rates, state_array};
use crate::state::{Input, NU, NX, State};

/// Directions of the velocity block: v_x, v_y, omega_z and the parameters; of the pose block: v_x, v_y,
/// omega_z, e_psi, e_y.
const N: usize = 5;

type Dual = DualSVec64<N>;
type Block = SMatrix<f64, 3, N>;

/// State, V, P and Q in one vector, so that one Runge-Kutta step moves them together.
const V: usize = NX;
const P: usize = V + 3 * N;
const Q: usize = P + 3 * N;
const ALL: usize = Q + 9;

/// The two parameters that are held over a step and derived by.
#[derive(Clone, Copy)]
pub(super) enum By {
    /// a and delta.
    Input,
    /// Grip factors of the front and rear axle.
    Grip,
}

/// Jacobians of a step by its state and by the parameters.
pub(super) fn linearize(
    step: &Discretized,
    x: &State,
    u: &Input,
    by: By,
    kappa: &impl Fn(f64) -> f64,
) -> Linearization {
    let mut y = [0.0; ALL];
    y[..NX].copy_from_slice(&state_array(x));
    y[V..P].copy_from_slice(Block::identity().as_slice());
    y[Q..].copy_from_slice(Matrix3::<f64>::identity().as_slice());

    let (substeps, h) = step.grid();
    for _ in 0..substeps {
        y = runge_kutta_4(&y, h, |y, _| rates(step, y, u, by, kappa(y[4])));
    }

    let by_start = Block::from_column_slice(&y[V..P]);
    let pose_by_start = Block::from_column_slice(&y[P..Q]);
    let mut a = Matrix6::zeros();
    let mut b = Matrix6x2::zeros();
    a.fixed_view_mut::<3, 3>(0, 0).copy_from(&by_start.fixed_columns::<3>(0));
    a.fixed_view_mut::<3, 3>(3, 0).copy_from(&pose_by_start.fixed_columns::<3>(0));
    a.fixed_view_mut::<3, 3>(3, 3).copy_from(&Matrix3::from_column_slice(&y[Q..]));
    b.fixed_view_mut::<3, NU>(0, 0).copy_from(&by_start.fixed_columns::<NU>(3));
    b.fixed_view_mut::<3, NU>(3, 0).copy_from(&pose_by_start.fixed_columns::<NU>(3));
    Linearization { next: Vector6::from_column_slice(&y[..NX]), a, b }
}

/// Rates of state, V, P and Q.
fn rates(step: &Discretized, y: &[f64; ALL], u: &Input, by: By, kappa: f64) -> [f64; ALL] {
    let seed = |value: f64, direction: usize| Dual::from_re(value).derivative(direction);
    let v = [seed(y[0], 0), seed(y[1], 1), seed(y[2], 2)];
    let (mut input, mut grip) =
        ([u.a, u.delta].map(Dual::from_re), step.model.grip.map(Dual::from_re));
    let parameters = match by {
        By::Input => &mut input,
        By::Grip => &mut grip,
    };
    for (number, direction) in parameters.iter_mut().zip(3..) {
        *number = number.derivative(direction);
    }
    let (v_dot, by_v) = split(&step.model.velocity_rates(&v, &input, &grip));
    let pose = [seed(y[3], 3), Dual::from_re(y[4]), seed(y[5], 4)];
    let (pose_dot, by_pose) = split(&pose_rates(&v, &pose, kappa));

    let velocity = Block::from_column_slice(&y[V..P]);
    let pose_by_start = Block::from_column_slice(&y[P..Q]);
    let pose_by_pose = Matrix3::from_column_slice(&y[Q..]);

    let mut v_variation = by_v.fixed_columns::<3>(0) * velocity;
    for column in 3..N {
        for row in 0..3 {
            v_variation[(row, column)] += by_v[(row, column)];
        }
    }
    // The curvature is frozen: no rate depends on s.
    let mut f_pose = Matrix3::zeros();
    f_pose.set_column(0, &by_pose.column(3));
    f_pose.set_column(2, &by_pose.column(4));

    let mut rates = [0.0; ALL];
    rates[..3].copy_from_slice(&v_dot);
    rates[3..V].copy_from_slice(&pose_dot);
    rates[V..P].copy_from_slice(v_variation.as_slice());
    let p_variation = by_pose.fixed_columns::<3>(0) * velocity + f_pose * pose_by_start;
    rates[P..Q].copy_from_slice(p_variation.as_slice());
    rates[Q..].copy_from_slice((f_pose * pose_by_pose).as_slice());
    rates
}

/// Values and Jacobian of three dual numbers.
fn split(numbers: &[Dual; 3]) -> ([f64; 3], Block) {
    let mut jacobian = Block::zeros();
    for (row, number) in numbers.iter().enumerate() {
        if let Some(gradient) = &number.eps.0 {
            jacobian.set_row(row, &gradient.transpose());
        }
    }
    (numbers.map(|number| number.re), jacobian)
}
