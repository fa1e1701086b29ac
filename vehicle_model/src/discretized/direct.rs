//! The whole step in dual numbers: on a road that is not flat, where the velocities depend on the
//! pose through gravity and the load of the axles, and for the kinematic model, whose velocities are
//! algebraic.

use nalgebra::{Matrix6, Matrix6x2, Vector6};

use super::sensitivity::AlongStep;
use super::{DIRECTIONS, Discretized, Linearization};
use crate::number::{Dual, Real};
use crate::road::Road;
use crate::state::{NU, NX};

/// Directions are the state and the input.
pub(super) struct Direct<'a> {
    pub(super) step: &'a Discretized,
    pub(super) road: &'a dyn Road,
}

impl AlongStep for Direct<'_> {
    type Found<T: Real> = [Dual<T, DIRECTIONS>; NX];
    type Out = Linearization;

    #[inline(always)]
    fn derive<T: Real>(&self, x: &[T; NX], u: [T; NU]) -> [Dual<T, DIRECTIONS>; NX] {
        let grip = self.step.model.grip.map(|grip| Dual::fixed(u[0].constant(grip)));
        let u = [Dual::direction(u[0], NX), Dual::direction(u[1], NX + 1)];
        let state = std::array::from_fn(|i| Dual::direction(x[i], i));
        self.step.step::<_, true>(&state, &u, &grip, self.road)
    }

    fn unpack<T: Real>(
        found: &[Dual<T, DIRECTIONS>; NX],
        value: impl Fn(T) -> f64,
    ) -> Linearization {
        Linearization {
            next: Vector6::from_fn(|row, _| value(found[row].value)),
            a: Matrix6::from_fn(|row, column| value(found[row].gradient[column])),
            b: Matrix6x2::from_fn(|row, column| value(found[row].gradient[NX + column])),
        }
    }
}
