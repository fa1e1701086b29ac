//! Jacobians of a step, of one car or of as many at once as the processor has lanes.

use pulp::{Arch, Simd, WithSimd};

use super::Linearization;
use crate::model::state_array;
use crate::number::{Lanes, Real};
use crate::state::{Input, NU, NX, State};

/// The two parameters that are held over a step and derived by.
#[derive(Clone, Copy)]
pub(super) enum By {
    /// a and delta.
    Input,
    /// Grip factors of the front and rear axle.
    Grip,
}

/// A way to the Jacobians of a step.
pub(super) trait Sensitivities {
    /// What it finds, in numbers of one kind.
    type Found<T: Real>;

    /// From a state and an input; compiled into the vector instructions of its caller.
    fn derive<T: Real>(&self, x: &[T; NX], u: [T; NU]) -> Self::Found<T>;

    /// The matrices of what was found, `value` being the wanted lane of a number.
    fn unpack<T: Real>(found: &Self::Found<T>, value: impl Fn(T) -> f64) -> Linearization;
}

/// Jacobians of a step by its state and the parameters.
pub(super) fn linearize<S: Sensitivities>(of: &S, x: &State, u: &Input) -> Linearization {
    S::unpack(&of.derive(&state_array(x), [u.a, u.delta]), |value: f64| value)
}

/// The same at all points, as many at once as the processor has lanes.
pub(super) fn linearize_all(
    of: &impl Sensitivities,
    points: &[(State, Input)],
    found: &mut dyn FnMut(usize, Linearization),
) {
    Arch::new().dispatch(Task { of, points, found });
}

struct Task<'a, D> {
    of: &'a D,
    points: &'a [(State, Input)],
    found: &'a mut dyn FnMut(usize, Linearization),
}

impl<D: Sensitivities> WithSimd for Task<'_, D> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let mut first = 0;
        for points in self.points.chunks(S::F64_LANES) {
            // The last point fills what lanes are left over.
            let point = |lane: usize| points[lane.min(points.len() - 1)];
            let mut x = [Lanes::from_fn(simd, |_| 0.0); NX];
            for (i, x) in x.iter_mut().enumerate() {
                *x = Lanes::from_fn(simd, |lane| state_array(&point(lane).0)[i]);
            }
            let a = Lanes::from_fn(simd, |lane| point(lane).1.a);
            let delta = Lanes::from_fn(simd, |lane| point(lane).1.delta);
            let all = self.of.derive(&x, [a, delta]);
            for lane in 0..points.len() {
                (self.found)(first + lane, D::unpack(&all, |value: Lanes<S>| value.lane(lane)));
            }
            first += points.len();
        }
    }
}
