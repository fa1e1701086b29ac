//! Kinematic bicycle: the wheels roll where they point,
//!
//! v_x' = a,  omega_z = v_x tan(delta)/l,  v_y = l_r omega_z.
//!
//! As a six-state model v_y and omega_z are states that follow these values.

use super::axles::longitudinal;
use crate::number::Number;
use crate::params::CarParams;
use crate::state::NU;

/// Time in which v_y and omega_z follow the rolling values where the continuous model needs
/// rates: slow enough for RK4 with 0.1 s, faster than any change a driver makes [s].
const FOLLOW_TIME: f64 = 0.05;

/// Velocities [v_x, v_y, omega_z] of a car that rolls.
#[inline(always)]
pub(super) fn velocities<T: Number>(car: &CarParams, v_x: T, delta: T) -> [T; 3] {
    let omega_z = v_x * delta.tan() * (1.0 / car.wheelbase());
    [v_x, omega_z * car.l_r, omega_z]
}

/// v_x' by the command and what resists.
#[inline(always)]
pub(super) fn speed_rate<T: Number>(car: &CarParams, v_x: T, a: T) -> T {
    let along = longitudinal(car, v_x, a);
    let mut a = if along.front_acts { along.axle[0] + along.axle[1] } else { along.axle[1] };
    if let Some(resistance) = along.resistance {
        a = a - resistance;
    }
    a
}

/// Rates of v_x, v_y and omega_z towards the rolling values.
#[inline(always)]
pub(super) fn velocity_rates<T: Number>(car: &CarParams, v: &[T; 3], u: &[T; NU]) -> [T; 3] {
    let a = speed_rate(car, v[0], u[0]);
    let rolling = velocities(car, v[0], u[1]);
    let along = velocities(car, a, u[1]);
    let follow = |i: usize| along[i] + (rolling[i] - v[i]) * (1.0 / FOLLOW_TIME);
    [a, follow(1), follow(2)]
}
