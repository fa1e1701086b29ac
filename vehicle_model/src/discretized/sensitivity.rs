//! What follows from a step, such as its Jacobians: for one car, or for as many at once as the processor
//! has lanes.

use pulp::{Arch, Simd, WithSimd};

use crate::model::state_array;
use crate::number::{Lanes, Real};
use crate::state::{Input, NU, NX, State};

/// Something computed along a step.
pub(super) trait AlongStep {
    /// It, in numbers of one kind.
    type Found<T: Real>;
    /// It, of one car.
    type Out;

    /// From a state and an input; compiled into the vector instructions of its caller.
    fn derive<T: Real>(&self, x: &[T; NX], u: [T; NU]) -> Self::Found<T>;

    /// That of one car, `value` being its lane of a number.
    fn unpack<T: Real>(found: &Self::Found<T>, value: impl Fn(T) -> f64) -> Self::Out;
}

/// From one state and input; in one copy, because each takes up to 0.2 MB of the program.
#[inline(never)]
pub(super) fn from_one<S: AlongStep>(of: &S, x: &State, u: &Input) -> S::Out {
    S::unpack(&of.derive(&state_array(x), [u.a, u.delta]), |value: f64| value)
}

/// From all points, as many at once as the processor has lanes; to the last bit as from each alone.
pub(super) fn from_all<S: AlongStep>(
    of: &S,
    points: &[(State, Input)],
    found: &mut dyn FnMut(usize, S::Out),
) {
    Arch::new().dispatch(Task { of, points, found });
}

struct Task<'a, D: AlongStep> {
    of: &'a D,
    points: &'a [(State, Input)],
    found: &'a mut dyn FnMut(usize, D::Out),
}

impl<D: AlongStep> WithSimd for Task<'_, D> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        if S::F64_LANES == 1 {
            for (i, (x, u)) in self.points.iter().enumerate() {
                (self.found)(i, from_one(self.of, x, u));
            }
            return;
        }
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
