//! The curvature that a Runge-Kutta step meets.
//!
//! Where straights and arcs join, the curvature jumps. A Runge-Kutta step across such a place weighs the
//! curvatures of its four stages without a view of where in the step the jump lies: its heading error is off
//! by up to a third of jump times step length, by another amount at each crossing. The mean curvature of the
//! step, which its stages then share, turns the centre line by exactly as much as it turns.

use crate::model::pose_rates;
use crate::number::{Number, Real};
use crate::road::Road;

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
        let s = pose[1];
        let ds = pose_rates(v, pose, s.map(|s| self.road.kappa(s)))[1] * h;
        self.mean = Some(s.map_with(ds, |s, ds| self.road.mean_kappa(s, ds)));
    }

    /// Curvature of the stage at `s` \[1/m\].
    #[inline(always)]
    pub(crate) fn kappa(&self, s: R) -> R {
        self.mean.unwrap_or_else(|| s.map(|s| self.road.kappa(s)))
    }
}

/// The numbers without their derivatives.
#[inline(always)]
pub(crate) fn reals<T: Number, const N: usize>(x: &[T], first: usize) -> [T::Real; N] {
    std::array::from_fn(|i| x[first + i].real())
}
