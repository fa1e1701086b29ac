//! The curvature that a Runge-Kutta step meets, and what its change along a control step means for the Jacobians.
//!
//! Where straights and arcs join, the curvature jumps. A Runge-Kutta step across such a place weighs the
//! curvatures of its four stages without a view of where in the step the jump lies: its heading error is off
//! by up to a third of jump times step length, by another amount at each crossing. The mean curvature of the
//! step, which its stages then share, turns the centre line by exactly as much as it turns beside the way of the
//! car: on the inner side of a bend more of the centre line passes in the same time.

use nalgebra::Vector6;

use super::{Discretized, Linearization};
use crate::model::pose_rates;
use crate::number::{Number, Real};
use crate::road::Road;
use crate::state::State;

/// Change of heading beyond which little of it is followed \[rad\].
const STRAY: f64 = 0.5;
/// Least share `1 - kappa e_y` of a centre of curvature's distance at which the change of a bend is followed.
const LEAST_SPACE: f64 = 0.1;

/// Curvature at the stages of Runge-Kutta steps along a road.
pub(crate) struct Bend<'a, R> {
    road: &'a dyn Road,
    /// Mean of the step; `None` on a road without jumps, where each stage has its own.
    mean: Option<R>,
}

impl<'a, R: Real> Bend<'a, R> {
    pub(crate) fn new(road: &'a dyn Road) -> Self {
        Self { road, mean: None }
    }

    /// A step of length `h` \[s\] begins with the velocities [v_x, v_y, omega_z] at the pose
    /// [e_psi, s, e_y].
    #[inline(always)]
    pub(crate) fn begin(&mut self, v: &[R; 3], pose: &[R; 3], h: f64) {
        if !self.road.jumps() {
            return;
        }
        let [_, s, e_y] = *pose;
        // Along a straight line s changes by what the car goes ahead.
        let [_, forward, aside] = pose_rates(v, pose, s.constant(0.0));
        let (e_y, ahead) = (e_y + aside * (0.5 * h), forward * h);
        self.mean =
            Some(s.map_with([e_y, ahead], |s, [e_y, ahead]| self.road.mean_kappa(s, e_y, ahead)));
    }

    /// Curvature of the stage at `s` \[1/m\].
    #[inline(always)]
    pub(crate) fn kappa(&self, s: R) -> R {
        self.mean.unwrap_or_else(|| s.map(|s| self.road.kappa(s)))
    }
}

impl Discretized {
    /// Adds to the Jacobians of a step from `x` what the change of the curvature along it makes of a car that is
    /// elsewhere along s.
    ///
    /// [`Discretized::linearize`] holds the curvature at each point of the step: a car ahead by d would turn with the
    /// same curvatures, though it leaves a bend earlier and has to turn less by kappa d. Where the rates of change
    /// of the pose go from f_1 to f_2 at a place s, deviations are multiplied by the saltation matrix
    /// `I + (f_2 - f_1) n' / (n' f_1)`, n being the direction of s (Leine and Nijmeijer, Dynamics and
    /// Bifurcations of Non-Smooth Mechanical Systems, 2004, section 7.1). A change that is spread over the step is
    /// taken to lie in its middle.
    ///
    /// A car that may be `far` \[m\] from `x` along s can be past the next bend, and the matrix then says too much: the
    /// greater the change of heading kappa far, the less of it is added.
    pub fn follow_bend(&self, x: &State, road: &impl Road, far: f64, step: &mut Linearization) {
        let ds = step.next[4] - x.s;
        let (before, after) = (road.kappa(x.s), road.kappa(step.next[4]));
        let change = after - before;
        if change == 0.0 {
            return;
        }
        let share = match road.jumps() {
            true => ((after - road.mean_kappa(x.s, 0.0, ds)) / change).clamp(0.0, 1.0),
            false => 0.5,
        };
        let e_y = x.e_y + share * (step.next[5] - x.e_y);
        let space = [1.0 - before * e_y, 1.0 - after * e_y];
        if space[0].min(space[1]) < LEAST_SPACE {
            return;
        }
        // s' after the change over s' before it.
        let ratio = space[0] / space[1];
        let stray = change * far / STRAY;
        let part = 1.0 / (1.0 + stray * stray);
        let turned = part * (before - after * ratio);
        // A change of heading leads astray for the rest of the step.
        let astray = turned * step.next[0] * self.dt * (1.0 - share);
        let jump = Vector6::new(0.0, 0.0, 0.0, turned, part * (ratio - 1.0), astray);
        let mut by_state = step.a.row(4) * share;
        by_state[4] += 1.0 - share;
        let by_input = step.b.row(4) * share;
        step.a += jump * by_state;
        step.b += jump * by_input;
    }
}

/// The numbers without their derivatives.
#[inline(always)]
pub(crate) fn reals<T: Number, const N: usize>(x: &[T], first: usize) -> [T::Real; N] {
    std::array::from_fn(|i| x[first + i].real())
}
