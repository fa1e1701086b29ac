//! The velocities after a step and their derivatives by the grip factors: what learning compares with
//! measurements. On a flat road they are integrated alone, as no velocity depends on the pose there.

use super::sensitivity::AlongStep;
use super::{Discretized, Dynamics, Rates, Stage};
use crate::model::{Held, Model, ModelKind};
use crate::number::{Dual, Number, Real};
use crate::road::Road;
use crate::state::{NU, NX};

/// Velocities one step later, [v_x, v_y, omega_z].
pub(super) struct Velocities<'a> {
    pub(super) step: &'a Discretized,
    pub(super) road: &'a dyn Road,
}

impl AlongStep for Velocities<'_> {
    type Found<T: Real> = [T; 3];
    type Out = [f64; 3];

    #[inline(always)]
    fn derive<T: Real>(&self, x: &[T; NX], u: [T; NU]) -> [T; 3] {
        let grip = self.step.model.grip.map(|grip| u[0].constant(grip));
        velocities(self.step, x, &u, &grip, self.road)
    }

    fn unpack<T: Real>(found: &[T; 3], value: impl Fn(T) -> f64) -> [f64; 3] {
        found.map(value)
    }
}

/// The same with their Jacobian by the grip of the front and the rear axle.
pub(super) struct ByGrip<'a> {
    pub(super) step: &'a Discretized,
    pub(super) road: &'a dyn Road,
}

impl AlongStep for ByGrip<'_> {
    type Found<T: Real> = [Dual<T, 2>; 3];
    type Out = ([f64; 3], [[f64; 2]; 3]);

    #[inline(always)]
    fn derive<T: Real>(&self, x: &[T; NX], u: [T; NU]) -> [Dual<T, 2>; 3] {
        let factors = self.step.model.grip;
        let grip = std::array::from_fn(|i| Dual::direction(u[0].constant(factors[i]), i));
        velocities(self.step, &x.map(Dual::fixed), &u.map(Dual::fixed), &grip, self.road)
    }

    fn unpack<T: Real>(found: &[Dual<T, 2>; 3], value: impl Fn(T) -> f64) -> Self::Out {
        let row = |i: usize| std::array::from_fn(|j| value(found[i].gradient[j]));
        (std::array::from_fn(|i| value(found[i].value)), std::array::from_fn(row))
    }
}

#[inline(always)]
fn velocities<T: Number>(
    step: &Discretized,
    x: &[T; NX],
    u: &[T; NU],
    grip: &[T; 2],
    road: &dyn Road,
) -> [T; 3] {
    if step.model.kind == ModelKind::Kinematic {
        return step.kinematic_velocities(x, &Held::new(u), road).1;
    }
    if !step.varies(road) {
        let (model, held) = (&step.model, &Held::new(u));
        let system = Dynamics::<T, true>::new(model, held, grip, road);
        let [v_x, v_y, omega_z, ..] = step.integrate(*x, system);
        return [v_x, v_y, omega_z];
    }
    let system = OnTheFlat { model: &step.model, held: &Held::new(u), grip };
    step.integrate([x[0], x[1], x[2]], system)
}

/// The velocities of the dynamic model on a flat road as a system of its own.
struct OnTheFlat<'a, T> {
    model: &'a Model,
    held: &'a Held<T>,
    grip: &'a [T; 2],
}

impl<T: Number> Rates<T, 3> for OnTheFlat<'_, T> {
    #[inline(always)]
    fn rates(&self, v: &[T; 3], _: f64, stage: &mut Stage<T, 3>) {
        let rates = self.model.velocity_rates(v, self.held, self.grip, None);
        stage.take_all(rates);
    }
}
