//! A Runge-Kutta step on a road that is not flat. The velocities depend on the pose there, through
//! gravity and the load of the axles: the whole step is taken in dual numbers, of one car or of as
//! many at once as the processor has lanes.

use nalgebra::{Matrix6, Matrix6x2, Vector6};
use pulp::{Arch, Simd, WithSimd};

use super::variation::By;
use super::{DIRECTIONS, Discretized, Linearization, runge_kutta_4};
use crate::model::{Held, ModelKind, PoseConvention, Terrain, ground, state_array};
use crate::number::{Dual, Lanes, Number, Real};
use crate::road::Road;
use crate::state::{Input, NU, NX, State};

/// State after one control step; the surface is looked up at every stage.
#[inline(always)]
pub(super) fn step<T: Number>(
    step: &Discretized,
    x: &[T; NX],
    u: &[T; NU],
    grip: &[T; 2],
    road: &impl Road,
) -> [T; NX] {
    let (substeps, h) = step.grid();
    let u = Held::new(u);
    match step.model.kind {
        ModelKind::Dynamic => (0..substeps).fold(*x, |x, _| {
            runge_kutta_4(&x, h, &|x: &[T; NX], _| {
                step.model.derivative_on(x, &u, &Terrain::new(road, x[4].real()), grip)
            })
        }),
        ModelKind::Kinematic => kinematic(step, x, &u, road),
    }
}

/// The velocity rows jump to their new values, with gravity along the car at the start of the step;
/// the pose is integrated along the velocities of the pose convention.
#[inline(always)]
fn kinematic<T: Number>(step: &Discretized, x: &[T; NX], u: &Held<T>, road: &impl Road) -> [T; NX] {
    let (substeps, h) = step.grid();
    let measured = [x[0], x[1], x[2]];
    let start = Terrain::new(road, x[4].real());
    let (_, below) = ground(&start, &measured, &[x[3], x[4], x[5]]);
    let a = step.model.kinematic_rate(x[0], u, Some(&below));
    let reached = step.model.rolling_velocities(x[0] + a * step.dt, u);
    let per_dt = 1.0 / step.dt;
    let velocities = |t: f64| match step.model.pose {
        PoseConvention::Held => measured,
        PoseConvention::Algebraic => step.model.rolling_velocities(measured[0] + a * t, u),
        PoseConvention::Interpolated => {
            let share = t * per_dt;
            std::array::from_fn(|i| measured[i] + (reached[i] - measured[i]) * share)
        }
    };
    let mut pose = [x[3], x[4], x[5]];
    for i in 0..substeps {
        #[expect(clippy::cast_precision_loss, reason = "a handful of sub-steps")]
        let begin = i as f64 * h;
        pose = runge_kutta_4(&pose, h, &|pose: &[T; 3], t| {
            ground(&Terrain::new(road, pose[1].real()), &velocities(begin + t), pose).0
        });
    }
    [reached[0], reached[1], reached[2], pose[0], pose[1], pose[2]]
}

/// Jacobians of a step by its state and input.
pub(super) fn linearize(
    step: &Discretized,
    x: &State,
    u: &Input,
    road: &impl Road,
) -> Linearization {
    let next = derive(step, &state_array(x), [u.a, u.delta], By::Input, road);
    unpack(|row| next[row].value, |row, column| next[row].gradient[column])
}

/// Jacobians by state and parameters at all points, as many at once as the processor has lanes.
pub(super) fn linearize_all(
    step: &Discretized,
    points: &[(State, Input)],
    by: By,
    road: &impl Road,
    found: &mut impl FnMut(usize, Linearization),
) {
    Arch::new().dispatch(Task { step, points, by, road, found });
}

struct Task<'a, R, F> {
    step: &'a Discretized,
    points: &'a [(State, Input)],
    by: By,
    road: &'a R,
    found: &'a mut F,
}

impl<R: Road, F: FnMut(usize, Linearization)> WithSimd for Task<'_, R, F> {
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
            let next = derive(self.step, &x, [a, delta], self.by, self.road);
            for lane in 0..points.len() {
                let linear = unpack(
                    |row| next[row].value.lane(lane),
                    |row, column| next[row].gradient[column].lane(lane),
                );
                (self.found)(first + lane, linear);
            }
            first += points.len();
        }
    }
}

/// The step in dual numbers: directions are the state and the two parameters.
#[inline(always)]
fn derive<T: Real>(
    step: &Discretized,
    x: &[T; NX],
    u: [T; NU],
    by: By,
    road: &impl Road,
) -> [Dual<T, DIRECTIONS>; NX] {
    let grip = step.model.grip.map(|grip| u[0].constant(grip));
    let parameters = |p: [T; 2]| [Dual::direction(p[0], NX), Dual::direction(p[1], NX + 1)];
    let (u, grip) = match by {
        By::Input => (parameters(u), grip.map(Dual::fixed)),
        By::Grip => (u.map(Dual::fixed), parameters(grip)),
    };
    let state = std::array::from_fn(|i| Dual::direction(x[i], i));
    self::step(step, &state, &u, &grip, road)
}

fn unpack(value: impl Fn(usize) -> f64, gradient: impl Fn(usize, usize) -> f64) -> Linearization {
    Linearization {
        next: Vector6::from_fn(|row, _| value(row)),
        a: Matrix6::from_fn(&gradient),
        b: Matrix6x2::from_fn(|row, column| gradient(row, NX + column)),
    }
}
