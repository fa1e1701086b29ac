//! Single-track (bicycle) models of the car in the Frenet frame: the velocity rates of each kind
//! of model, and the Frenet kinematics that all have in common (the paper's text, without a number).
//!
//! The equations are written once, over a generic number: plain `f64` gives values, dual numbers
//! give exact Jacobians of the same code, lanes of a vector register several cars at once.

mod axles;
mod bicycle;
mod ground;
mod kinematic;
mod spatial;
mod tyre;

use serde::{Deserialize, Serialize};

use crate::number::Number;
use crate::params::CarParams;
use crate::road::{MIN_FRENET_SCALE, Road};
use crate::state::{Input, NU, NX, State};

pub use axles::AxleForces;
pub(crate) use ground::{Ground, Terrain, ground};
pub use spatial::{SPATIAL_RATES, SPATIAL_VARIABLES, SpatialExpansion};
pub(crate) use tyre::slip_speed;

/// Which equations a model uses.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ModelKind {
    /// Bicycle with tyre forces.
    #[default]
    Dynamic,
    /// Bicycle that rolls where its wheels point, as a six-state model.
    Kinematic,
}

/// Velocities that move the pose during one step of the kinematic model, whose velocity rows jump
/// to their new values algebraically.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PoseConvention {
    /// From the measured velocities linearly to the new ones.
    #[default]
    Interpolated,
    /// The measured velocities held over the step.
    Held,
    /// The kinematic velocities of the new steering angle from the start of the step.
    Algebraic,
}

/// An input that is held over a step, with what depends on it alone.
#[derive(Clone, Copy)]
pub(crate) struct Held<T> {
    pub(crate) a: T,
    pub(crate) delta: T,
    pub(crate) sin_delta: T,
    pub(crate) cos_delta: T,
}

impl<T: Number> Held<T> {
    /// The input [a, delta].
    #[inline(always)]
    pub(crate) fn new(u: &[T; NU]) -> Self {
        let (sin_delta, cos_delta) = u[1].sin_cos();
        Self { a: u[0], delta: u[1], sin_delta, cos_delta }
    }

    /// Tangent of the steering angle.
    #[inline(always)]
    pub(crate) fn tan_delta(&self) -> T {
        self.sin_delta * self.cos_delta.recip()
    }
}

/// A continuous-time model of one car.
#[derive(Debug, Clone, PartialEq)]
pub struct Model {
    /// Which equations.
    pub kind: ModelKind,
    /// The car.
    pub params: CarParams,
    /// Factors on the friction coefficient of the front and rear axle, by default 1 [-].
    pub grip: [f64; 2],
    /// How the kinematic model moves its pose.
    pub pose: PoseConvention,
}

impl Model {
    /// A model with unchanged grip.
    #[must_use]
    pub fn new(kind: ModelKind, params: CarParams) -> Self {
        Self { kind, params, grip: [1.0, 1.0], pose: PoseConvention::default() }
    }

    /// Time derivative of the state [v_x, v_y, omega_z, e_psi, s, e_y] on a path of curvature
    /// `kappa` [1/m].
    #[must_use]
    pub fn derivative(&self, x: &State, u: &Input, kappa: f64) -> [f64; NX] {
        self.derivative_generic(&state_array(x), &Held::new(&[u.a, u.delta]), kappa, &self.grip)
    }

    /// Forces of both axles in this state.
    #[must_use]
    pub fn forces(&self, x: &State, u: &Input) -> AxleForces<f64> {
        let v = [x.v_x, x.v_y, x.omega_z];
        bicycle::forces(&self.params, &v, &[u.a, u.delta], &self.grip, None)
    }

    /// [`Model::derivative`] on any road.
    #[must_use]
    pub fn derivative_along(&self, x: &State, u: &Input, road: &dyn Road) -> [f64; NX] {
        let held = Held::new(&[u.a, u.delta]);
        self.rates_along(&state_array(x), &held, road, road.kappa(x.s), &self.grip)
    }

    /// [`Model::forces`] on any road.
    #[must_use]
    pub fn forces_along(&self, x: &State, u: &Input, road: &dyn Road) -> AxleForces<f64> {
        if road.is_flat() {
            return self.forces(x, u);
        }
        let terrain = Terrain::new(road, x.s);
        let v = [x.v_x, x.v_y, x.omega_z];
        let (_, below) = ground(&terrain, &v, &[x.e_psi, x.s, x.e_y]);
        let grip = self.grip.map(|grip| grip * terrain.friction);
        bicycle::forces(&self.params, &v, &[u.a, u.delta], &grip, Some(&below))
    }

    /// Share of each axle's peak force in use, sqrt(F_x^2 + F_y^2)/(mu F_z) [-].
    #[must_use]
    pub fn utilisation(&self, forces: &AxleForces<f64>) -> [f64; 2] {
        let mu = [self.params.tyre_front.mu, self.params.tyre_rear.mu];
        std::array::from_fn(|i| {
            libm::hypot(forces.long[i], forces.lateral[i])
                / (mu[i] * self.grip[i] * forces.vertical[i])
        })
    }

    /// The one source of the equations; `grip` are the factors on the friction coefficients.
    #[inline(always)]
    pub(crate) fn derivative_generic<T: Number>(
        &self,
        x: &[T; NX],
        u: &Held<T>,
        kappa: T::Real,
        grip: &[T; 2],
    ) -> [T; NX] {
        let velocity = self.velocity_rates(&[x[0], x[1], x[2]], u, grip, None);
        let pose = pose_rates(&[x[0], x[1], x[2]], &[x[3], x[4], x[5]], kappa);
        [velocity[0], velocity[1], velocity[2], pose[0], pose[1], pose[2]]
    }

    /// The same on any road, whose surface is looked up at the value of s, with this curvature.
    #[inline(always)]
    pub(crate) fn rates_along<T: Number>(
        &self,
        x: &[T; NX],
        u: &Held<T>,
        road: &dyn Road,
        kappa: T::Real,
        grip: &[T; 2],
    ) -> [T; NX] {
        if road.is_flat() {
            return self.derivative_generic(x, u, kappa, grip);
        }
        self.derivative_on(x, u, &Terrain::bent(road, x[4].real(), kappa), grip)
    }

    /// The same on a road that is not flat.
    #[inline(always)]
    pub(crate) fn derivative_on<T: Number>(
        &self,
        x: &[T; NX],
        u: &Held<T>,
        terrain: &Terrain<T::Real>,
        grip: &[T; 2],
    ) -> [T; NX] {
        let v = [x[0], x[1], x[2]];
        let (pose, below) = ground(terrain, &v, &[x[3], x[4], x[5]]);
        let grip = grip.map(|grip| grip.scale(terrain.friction));
        let velocity = self.velocity_rates(&v, u, &grip, Some(&below));
        [velocity[0], velocity[1], velocity[2], pose[0], pose[1], pose[2]]
    }

    /// Rates of [v_x, v_y, omega_z], which on a flat road do not depend on the pose.
    #[inline(always)]
    pub(crate) fn velocity_rates<T: Number>(
        &self,
        v: &[T; 3],
        u: &Held<T>,
        grip: &[T; 2],
        below: Option<&Ground<T>>,
    ) -> [T; 3] {
        match self.kind {
            ModelKind::Dynamic => bicycle::velocity_rates(&self.params, v, u, grip, below),
            ModelKind::Kinematic => kinematic::velocity_rates(&self.params, v, u, below),
        }
    }

    /// Longitudinal acceleration of the kinematic model.
    #[inline(always)]
    pub(crate) fn kinematic_rate<T: Number>(
        &self,
        v_x: T,
        u: &Held<T>,
        below: Option<&Ground<T>>,
    ) -> T {
        kinematic::speed_rate(&self.params, v_x, u.a, below)
    }

    /// Kinematic velocities at a speed.
    #[inline(always)]
    pub(crate) fn rolling_velocities<T: Number>(&self, v_x: T, u: &Held<T>) -> [T; 3] {
        kinematic::velocities(&self.params, v_x, u.tan_delta())
    }
}

/// Rates of the pose [e_psi, s, e_y] from the velocities [v_x, v_y, omega_z] (Frenet kinematics
/// of Xue et al. 2023, which the paper states in its text, without a number).
#[inline(always)]
pub(crate) fn pose_rates<T: Number>(v: &[T; 3], pose: &[T; 3], kappa: T::Real) -> [T; 3] {
    let [v_x, v_y, omega_z] = *v;
    let [e_psi, _, e_y] = *pose;
    let (sin_psi, cos_psi) = e_psi.sin_cos();
    let scale = -e_y.scale(kappa) + 1.0;
    let least = scale.constant(MIN_FRENET_SCALE);
    let scale = T::select(scale.below(MIN_FRENET_SCALE), least, scale);
    let s_dot = (v_x * cos_psi - v_y * sin_psi) * scale.recip();
    [omega_z - s_dot.scale(kappa), s_dot, v_x * sin_psi + v_y * cos_psi]
}

/// The state as an array in the common order.
pub(crate) fn state_array(x: &State) -> [f64; NX] {
    [x.v_x, x.v_y, x.omega_z, x.e_psi, x.s, x.e_y]
}
