//! Kinematic bicycle: the wheels roll where they point,
//!
//! v_x' = a,  omega_z = v_x tan(delta)/l,  v_y = l_r omega_z.
//!
//! As a six-state model v_y and omega_z are states that follow these values.

use super::axles::longitudinal;
use super::{Ground, Held};
use crate::number::Number;
use crate::params::CarParams;

/// Time in which v_y and omega_z follow the rolling values where the continuous model needs
/// rates: slow enough for RK4 with 0.1 s, faster than any change a driver makes [s].
const FOLLOW_TIME: f64 = 0.05;

/// Velocities [v_x, v_y, omega_z] of a car that rolls.
#[inline(always)]
pub(super) fn velocities<T: Number>(car: &CarParams, v_x: T, tan_delta: T) -> [T; 3] {
    let omega_z = v_x * tan_delta * (1.0 / car.wheelbase());
    [v_x, omega_z * car.l_r, omega_z]
}

/// v_x' by the command and what resists.
#[inline(always)]
pub(super) fn speed_rate<T: Number>(car: &CarParams, v_x: T, a: T, below: Option<&Ground<T>>) -> T {
    let along = longitudinal(car, v_x, a, below);
    let mut a = if along.front_acts { along.axle[0] + along.axle[1] } else { along.axle[1] };
    if let Some(resistance) = along.resistance {
        a = a - resistance;
    }
    below.map_or(a, |below| a + below.gravity[0])
}

/// Rates of v_x, v_y and omega_z towards the rolling values.
#[inline(always)]
pub(super) fn velocity_rates<T: Number>(
    car: &CarParams,
    v: &[T; 3],
    u: &Held<T>,
    below: Option<&Ground<T>>,
) -> [T; 3] {
    let a = speed_rate(car, v[0], u.a, below);
    let tan_delta = u.tan_delta();
    let rolling = velocities(car, v[0], tan_delta);
    let along = velocities(car, a, tan_delta);
    let follow = |i: usize| along[i] + (rolling[i] - v[i]) * (1.0 / FOLLOW_TIME);
    [a, follow(1), follow(2)]
}
