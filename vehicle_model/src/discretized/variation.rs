//! Jacobians of a Runge-Kutta step from the variational equations.
//!
//! The sensitivities of the state obey d/dt S = F S + G with the Jacobians F and G of the
//! continuous model. Integrated beside the state by the same Runge-Kutta steps they are the exact
//! Jacobians of the discrete step. F and G come from dual numbers; the velocities depend on
//! neither pose nor s, so the system falls into small blocks:
//!
//! V = d v/d(v_0, p),  P = d pose/d(v_0, p),  Q = d pose/d pose_0,
//!
//! p being the input, which is held over the step.

use nalgebra::{Matrix6, Matrix6x2, Vector6};

use super::sensitivity::AlongStep;
use super::{Bend, Discretized, Linearization, Rates, Stage, reals};
use crate::model::{Held, pose_rates};
use crate::number::{Dual, Real};
use crate::road::Road;
use crate::state::{NU, NX};

/// Directions of the velocity block: v_x, v_y, omega_z and the input; of the pose block:
/// v_x, v_y, omega_z, e_psi, e_y.
const N: usize = 5;
/// Columns of Q: e_psi and e_y. Nothing but s itself depends on s.
const POSE: [usize; 2] = [3, 5];

/// State, V, P and Q row by row in one array, so that one Runge-Kutta step moves them together.
const V: usize = NX;
const P: usize = V + 3 * N;
const Q: usize = P + 3 * N;
const ALL: usize = Q + 3 * POSE.len();

/// The Jacobians of a step on a flat road by the variational equations.
pub(super) struct Variation<'a> {
    pub(super) step: &'a Discretized,
    pub(super) road: &'a dyn Road,
}

impl AlongStep for Variation<'_> {
    type Found<T: Real> = [T; ALL];
    type Out = Linearization;

    #[inline(always)]
    fn derive<T: Real>(&self, x: &[T; NX], u: [T; NU]) -> [T; ALL] {
        integrate(self.step, x, u, self.road)
    }

    fn unpack<T: Real>(found: &[T; ALL], value: impl Fn(T) -> f64) -> Linearization {
        unpack(|i| value(found[i]))
    }
}

/// State, V, P and Q after the step.
#[inline(always)]
fn integrate<T: Real>(step: &Discretized, x: &[T; NX], u: [T; NU], road: &dyn Road) -> [T; ALL] {
    let mut y = [x[0].constant(0.0); ALL];
    y[..NX].copy_from_slice(x);
    let one = x[0].constant(1.0);
    for i in 0..3 {
        y[V + i * N + i] = one;
    }
    (y[Q], y[Q + 5]) = (one, one);
    step.integrate(y, System::new(step, u, road))
}

/// The matrices of the array `y`.
fn unpack(y: impl Fn(usize) -> f64) -> Linearization {
    let mut a = Matrix6::zeros();
    let mut b = Matrix6x2::zeros();
    for row in 0..NX {
        for column in 0..3 {
            a[(row, column)] = y(V + row * N + column);
        }
        for column in 0..NU {
            b[(row, column)] = y(V + row * N + 3 + column);
        }
    }
    for row in 0..3 {
        for (i, column) in POSE.into_iter().enumerate() {
            a[(3 + row, column)] = y(Q + row * POSE.len() + i);
        }
    }
    a[(4, 4)] = 1.0;
    Linearization { next: Vector6::from_fn(|row, _| y(row)), a, b }
}

/// State, V, P and Q as a system of differential equations. A closure would be compiled apart from
/// the vector instructions around it.
struct System<'a, T: Real> {
    step: &'a Discretized,
    held: Held<Dual<T, N>>,
    grip: [Dual<T, N>; 2],
    bend: Bend<'a, T>,
}

impl<'a, T: Real> System<'a, T> {
    #[inline(always)]
    fn new(step: &'a Discretized, u: [T; NU], road: &'a dyn Road) -> Self {
        let grip = step.model.grip.map(|grip| Dual::fixed(u[0].constant(grip)));
        let u = [Dual::direction(u[0], 3), Dual::direction(u[1], 4)];
        Self { step, held: Held::new(&u), grip, bend: Bend::new(road) }
    }
}

impl<T: Real> Rates<T, ALL> for System<'_, T> {
    #[inline(always)]
    fn begin(&mut self, y: &[T; ALL], h: f64) {
        self.bend.begin(&reals(y, 0), &reals(y, 3), h);
    }

    #[inline(always)]
    fn rates(&self, y: &[T; ALL], _: f64, stage: &mut Stage<T, ALL>) {
        let seed = Dual::<T, N>::direction;
        let v = [seed(y[0], 0), seed(y[1], 1), seed(y[2], 2)];
        let v_dot = self.step.model.velocity_rates(&v, &self.held, &self.grip, None);
        let pose = [seed(y[3], 3), Dual::fixed(y[4]), seed(y[5], 4)];
        let kappa = self.bend.kappa(y[4]);
        let pose_dot = pose_rates(&v, &pose, kappa);

        // The curvature is frozen: no rate depends on s. Of the rates of the pose, s' does not depend on
        // omega_z, e_y' on neither omega_z nor e_y, and e_psi' = omega_z - kappa s'.
        for row in 0..3 {
            stage.take(row, v_dot[row].value);
            stage.take(3 + row, pose_dot[row].value);
        }
        let (by_s, by_e_y) = (pose_dot[1].gradient, pose_dot[2].gradient);
        for column in 0..N {
            let v = [y[V + column], y[V + N + column], y[V + 2 * N + column]];
            let (e_psi, e_y) = (y[P + column], y[P + 2 * N + column]);
            for (row, rate) in v_dot.iter().enumerate() {
                let by_v = rate.gradient;
                let product = by_v[0] * v[0] + by_v[1] * v[1] + by_v[2] * v[2];
                let own = if column < 3 { product } else { product + by_v[column] };
                stage.take(V + row * N + column, own);
            }
            let along = by_s[0] * v[0] + by_s[1] * v[1] + by_s[3] * e_psi + by_s[4] * e_y;
            stage.take(P + column, v[2] - along * kappa);
            stage.take(P + N + column, along);
            let across = by_e_y[0] * v[0] + by_e_y[1] * v[1] + by_e_y[3] * e_psi;
            stage.take(P + 2 * N + column, across);
        }
        for column in 0..POSE.len() {
            let (e_psi, e_y) = (y[Q + column], y[Q + 2 * POSE.len() + column]);
            let along = by_s[3] * e_psi + by_s[4] * e_y;
            stage.take(Q + column, -(along * kappa));
            stage.take(Q + POSE.len() + column, along);
            stage.take(Q + 2 * POSE.len() + column, by_e_y[3] * e_psi);
        }
    }
}
