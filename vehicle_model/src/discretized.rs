//! One control step of a model, (1) of the paper: Runge-Kutta 4 with the input held, and its exact Jacobians.
//!
//! ```text
//! x_{k+1} = f(x_k, u_k)                                            (1)
//! A^f = df/dx,   B^f = df/du                                       of the whole step, through every sub-step
//! ```

mod bend;
mod direct;
#[cfg(test)]
mod oracle;
mod sensitivity;
mod variation;
mod velocities;

use nalgebra::{Matrix6, Matrix6x2, Vector6};

pub(crate) use bend::Bend;
use bend::reals;
use direct::Direct;
use variation::Variation;
use velocities::{ByGrip, Velocities};

use crate::model::{
    Held, Model, ModelKind, PoseConvention, Terrain, ground, pose_rates, state_array,
};
use crate::number::Number;
use crate::road::Road;
use crate::state::{Input, NU, NX, State};

/// Directions of a linearisation: six states, two inputs.
const DIRECTIONS: usize = NX + NU;

/// A model sampled with a control step: `substeps` steps of Runge-Kutta 4 over `dt`.
///
/// Curvature and surface are looked up at every stage from the value of s and frozen in the Jacobian
/// (d kappa/d s = 0); [`Discretized::follow_bend`] adds what its change means. Where the
/// curvature jumps, the stages of a Runge-Kutta step share its mean.
#[derive(Debug, Clone, PartialEq)]
pub struct Discretized {
    /// The continuous model.
    pub model: Model,
    /// Control step \[s\].
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
    pub fn next(&self, x: &State, u: &Input, road: impl Road) -> State {
        self.next_on(x, u, &road)
    }

    // With a road of any kind these are compiled once, and not by every crate that calls them.
    fn next_on(&self, x: &State, u: &Input, road: &dyn Road) -> State {
        let next = self.step::<_, false>(&state_array(x), &[u.a, u.delta], &self.model.grip, road);
        State::from_vector(&Vector6::from(next))
    }

    /// State after one control step with its Jacobians by state and input, exact by dual numbers.
    pub fn linearize(&self, x: &State, u: &Input, road: impl Road) -> Linearization {
        self.linearize_on(x, u, &road)
    }

    fn linearize_on(&self, x: &State, u: &Input, road: &dyn Road) -> Linearization {
        let step = self;
        if self.varies(road) {
            sensitivity::from_one(&Variation { step, road }, x, u)
        } else {
            sensitivity::from_one(&Direct { step, road }, x, u)
        }
    }

    /// Whether the variational equations fall into the small blocks that they are written for.
    fn varies(&self, road: &dyn Road) -> bool {
        road.is_flat() && self.model.kind == ModelKind::Dynamic
    }

    /// [`Discretized::linearize`] at every point, to the last bit, but several points at once in
    /// the lanes of the processor's vectors; `found` gets each point's index and result in order.
    pub fn linearize_all(
        &self,
        points: &[(State, Input)],
        road: impl Road,
        mut found: impl FnMut(usize, Linearization),
    ) {
        self.linearize_all_on(points, &road, &mut found);
    }

    fn linearize_all_on(
        &self,
        points: &[(State, Input)],
        road: &dyn Road,
        found: &mut dyn FnMut(usize, Linearization),
    ) {
        let step = self;
        if self.varies(road) {
            sensitivity::from_all(&Variation { step, road }, points, found);
        } else {
            sensitivity::from_all(&Direct { step, road }, points, found);
        }
    }

    /// Velocities [v_x, v_y, omega_z] one control step after every point, to the last bit those of
    /// [`Discretized::next`]; `found` gets each point's index and result in order.
    pub fn velocities_all(
        &self,
        points: &[(State, Input)],
        road: &dyn Road,
        found: &mut dyn FnMut(usize, [f64; 3]),
    ) {
        let of = Velocities { step: self, road };
        sensitivity::from_all(&of, points, found);
    }

    /// [`Discretized::velocities_all`] with the Jacobian of each row by the grip factors of the front
    /// and the rear axle: what a least-squares fit of the friction needs.
    pub fn grip_jacobians(
        &self,
        points: &[(State, Input)],
        road: &dyn Road,
        found: &mut dyn FnMut(usize, [f64; 3], [[f64; 2]; 3]),
    ) {
        let of = ByGrip { step: self, road };
        sensitivity::from_all(&of, points, &mut |i, (next, jacobian)| found(i, next, jacobian));
    }

    /// Number and length of the Runge-Kutta steps.
    fn grid(&self) -> (usize, f64) {
        let substeps = self.substeps.max(1);
        #[expect(clippy::cast_precision_loss, reason = "a handful of sub-steps")]
        let h = self.dt / substeps as f64;
        (substeps, h)
    }

    /// The Runge-Kutta steps of one control step, of a system that does not depend on time.
    #[inline(always)]
    fn integrate<T: Number, const N: usize>(
        &self,
        mut x: [T; N],
        mut system: impl Rates<T, N>,
    ) -> [T; N] {
        let (substeps, h) = self.grid();
        let (mut next, mut spare) = (x, [x; 2]);
        for _ in 0..substeps {
            system.begin(&x, h);
            runge_kutta_4_from(&x, &mut next, &mut spare, h, &system);
            x = next;
        }
        x
    }

    /// `HILLS`: the road is known not to be flat, unless the model is kinematic.
    #[inline(always)]
    fn step<T: Number, const HILLS: bool>(
        &self,
        x: &[T; NX],
        u: &[T; NU],
        grip: &[T; 2],
        road: &dyn Road,
    ) -> [T; NX] {
        let u = Held::new(u);
        match self.model.kind {
            ModelKind::Dynamic => {
                self.integrate(*x, Dynamics::<T, HILLS>::new(&self.model, &u, grip, road))
            }
            ModelKind::Kinematic => self.kinematic_step(x, &u, road),
        }
    }

    /// Acceleration of the kinematic model over a control step, with gravity along the car at its
    /// start, and the velocities after it.
    #[inline(always)]
    fn kinematic_velocities<T: Number>(
        &self,
        x: &[T; NX],
        u: &Held<T>,
        road: &dyn Road,
    ) -> (T, [T; 3]) {
        let (v, pose) = ([x[0], x[1], x[2]], [x[3], x[4], x[5]]);
        let below =
            (!road.is_flat()).then(|| ground(&Terrain::new(road, x[4].real()), &v, &pose).1);
        let a = self.model.kinematic_rate(x[0], u, below.as_ref());
        (a, self.model.rolling_velocities(x[0] + a * self.dt, u))
    }

    /// Velocity rows jump to their new values; pose rows are integrated along the velocities of the
    /// pose convention.
    #[inline(always)]
    fn kinematic_step<T: Number>(&self, x: &[T; NX], u: &Held<T>, road: &dyn Road) -> [T; NX] {
        let (substeps, h) = self.grid();
        let (measured, start) = ([x[0], x[1], x[2]], [x[3], x[4], x[5]]);
        let (a, reached) = self.kinematic_velocities(x, u, road);
        let per_dt = 1.0 / self.dt;
        let velocities = |t: f64| match self.model.pose {
            PoseConvention::Held => measured,
            PoseConvention::Algebraic => self.model.rolling_velocities(measured[0] + a * t, u),
            PoseConvention::Interpolated => {
                let share = t * per_dt;
                std::array::from_fn(|i| measured[i] + (reached[i] - measured[i]) * share)
            }
        };
        let (mut pose, mut bend) = (start, Bend::new(road));
        for i in 0..substeps {
            #[expect(clippy::cast_precision_loss, reason = "a handful of sub-steps")]
            let begin = i as f64 * h;
            bend.begin(&reals(&velocities(begin), 0), &reals(&pose, 0), h);
            pose = runge_kutta_4(&pose, h, &|pose: &[T; 3], t| {
                let (v, s) = (velocities(begin + t), pose[1].real());
                if road.is_flat() {
                    return pose_rates(&v, pose, bend.kappa(s));
                }
                ground(&Terrain::bent(road, s, bend.kappa(s)), &v, pose).0
            });
        }
        [reached[0], reached[1], reached[2], pose[0], pose[1], pose[2]]
    }
}

/// The dynamic model on any road. A closure would be compiled apart from the vector instructions
/// around it: slow, and larger than all the rest of the program.
struct Dynamics<'a, T: Number, const HILLS: bool> {
    model: &'a Model,
    held: &'a Held<T>,
    grip: &'a [T; 2],
    road: &'a dyn Road,
    bend: Bend<'a, T::Real>,
}

impl<'a, T: Number, const HILLS: bool> Dynamics<'a, T, HILLS> {
    #[inline(always)]
    fn new(model: &'a Model, held: &'a Held<T>, grip: &'a [T; 2], road: &'a dyn Road) -> Self {
        Self { model, held, grip, road, bend: Bend::new(road) }
    }
}

impl<T: Number, const HILLS: bool> Rates<T, NX> for Dynamics<'_, T, HILLS> {
    #[inline(always)]
    fn begin(&mut self, x: &[T; NX], h: f64) {
        self.bend.begin(&reals(x, 0), &reals(x, 3), h);
    }

    #[inline(always)]
    fn rates(&self, x: &[T; NX], _: f64, stage: &mut Stage<T, NX>) {
        let Self { model, held, grip, road, bend } = self;
        let s = x[4].real();
        let rates = if HILLS {
            model.derivative_on(x, held, &Terrain::bent(*road, s, bend.kappa(s)), grip)
        } else {
            model.rates_along(x, held, *road, bend.kappa(s), grip)
        };
        stage.take_all(rates);
    }
}

/// Rates of change of a system.
pub(crate) trait Rates<T, const N: usize> {
    /// A Runge-Kutta step of length `h` \[s\] begins at `x`.
    #[inline(always)]
    fn begin(&mut self, _x: &[T; N], _h: f64) {}

    /// Gives the rates at `x`, at time `t` since the start of a step, one by one to `stage`.
    fn rates(&self, x: &[T; N], t: f64, stage: &mut Stage<T, N>);
}

impl<T: Number, const N: usize, F: Fn(&[T; N], f64) -> [T; N]> Rates<T, N> for F {
    #[inline(always)]
    fn rates(&self, x: &[T; N], t: f64, stage: &mut Stage<T, N>) {
        stage.take_all(self(x, t));
    }
}

/// One evaluation of a Runge-Kutta step: what becomes of a rate as soon as it is known.
pub(crate) struct Stage<'a, T, const N: usize> {
    /// Where the step begins.
    x: &'a [T; N],
    /// Where it ends, so far.
    next: &'a mut [T; N],
    /// Where the next evaluation is made.
    ahead: &'a mut [T; N],
    /// The evaluation's part of the step, and how far the next one is ahead.
    part: f64,
    reach: f64,
}

impl<T: Number, const N: usize> Stage<'_, T, N> {
    /// Takes the rate of quantity `i`.
    #[inline(always)]
    pub(crate) fn take(&mut self, i: usize, rate: T) {
        self.next[i] = self.next[i] + rate * self.part;
        self.ahead[i] = self.x[i] + rate * self.reach;
    }

    /// Takes the rates of all quantities.
    #[inline(always)]
    pub(crate) fn take_all(&mut self, rates: [T; N]) {
        for (i, rate) in rates.into_iter().enumerate() {
            self.take(i, rate);
        }
    }
}

/// One step of the classical Runge-Kutta method of order four.
#[inline(always)]
pub(crate) fn runge_kutta_4<T: Number, const N: usize>(
    x: &[T; N],
    h: f64,
    f: &impl Rates<T, N>,
) -> [T; N] {
    let mut next = *x;
    runge_kutta_4_from(x, &mut next, &mut [*x; 2], h, f);
    next
}

/// The same in memory that is there: `next` begins as `x`, and `spare` may hold anything. Dozens of quantities
/// with derivatives are worth not being copied for each step.
#[inline(always)]
fn runge_kutta_4_from<T: Number, const N: usize>(
    x: &[T; N],
    next: &mut [T; N],
    spare: &mut [[T; N]; 2],
    h: f64,
    f: &impl Rates<T, N>,
) {
    let [one, other] = spare;
    // As a loop the rates stand once in the program: short enough to be compiled in place.
    // Time of each evaluation, its weight in the sum, and where the next one is made.
    let stages = [(0.0, 1.0, 0.5), (0.5, 2.0, 0.5), (0.5, 2.0, 1.0), (1.0, 1.0, 0.0)];
    for (i, (t, weight, reach)) in stages.into_iter().enumerate() {
        let (at, ahead) = match i {
            0 => (x, &mut *one),
            2 => (&*other, &mut *one),
            _ => (&*one, &mut *other),
        };
        let (part, reach) = (weight * h / 6.0, reach * h);
        let mut stage = Stage { x, next: &mut *next, ahead, part, reach };
        f.rates(at, t * h, &mut stage);
    }
}
