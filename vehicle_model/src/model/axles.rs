//! Longitudinal forces and vertical loads of the two axles.

use super::Ground;
use crate::number::{Mask, Number, Real};
use crate::params::{CarParams, GOVERNOR_GAIN, GRAVITY};

/// Speed below which rolling resistance fades to zero, so that it stops a car and does not push
/// it [m/s].
const ROLLING_FADE_SPEED: f64 = 0.05;
/// Lowest speed at which a power limit is evaluated [m/s].
const MIN_POWER_SPEED: f64 = 0.5;
/// An axle never lifts off completely: least share of its static load.
const MIN_LOAD_SHARE: f64 = 0.02;

/// Forces of the axles of a bicycle model; index 0 is the front, 1 the rear axle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AxleForces<T> {
    /// Longitudinal force along the wheel \[N\].
    pub long: [T; 2],
    /// Lateral force across the wheel, positive to the left \[N\].
    pub lateral: [T; 2],
    /// Vertical load \[N\].
    pub vertical: [T; 2],
    /// Slip angle \[rad\].
    pub slip: [T; 2],
}

/// What acts along the car.
pub(super) struct Longitudinal<T> {
    /// Acceleration by the wheels of the front and rear axle [m/s^2].
    pub(super) axle: [T; 2],
    /// Whether any of it may be on the front axle.
    pub(super) front_acts: bool,
    /// Deceleration by drag and rolling resistance [m/s^2]; `None` if all are off.
    pub(super) resistance: Option<T>,
}

/// Splits the commanded acceleration between the axles, inside power and force limits.
#[inline(always)]
pub(super) fn longitudinal<T: Number>(
    car: &CarParams,
    v_x: T,
    a: T,
    below: Option<&Ground<T>>,
) -> Longitudinal<T> {
    let braking = a.below(0.0);
    let front_acts = car.drive_front != 0.0 || car.brake_front != 0.0;
    let resistance = resistance(car, v_x, below);
    let a = limited(car, v_x, a, braking, resistance);
    let axle = if front_acts {
        let (brake, drive) = (car.brake_front, car.drive_front);
        [
            T::select(braking, a * brake, a * drive),
            T::select(braking, a * (1.0 - brake), a * (1.0 - drive)),
        ]
    } else {
        [a.constant(0.0), a]
    };
    Longitudinal { axle, front_acts, resistance }
}

/// The commanded acceleration inside the limits of engine and brakes.
#[inline(always)]
fn limited<T: Number>(car: &CarParams, v_x: T, a: T, braking: Mask<T>, resistance: Option<T>) -> T {
    let mut driven = a;
    if let Some(force) = car.drive_force_max {
        let most = force / car.mass;
        driven = T::select(a.above(most), a.constant(most), driven);
    }
    if let Some(power) = car.power_max {
        let slow = v_x.constant(MIN_POWER_SPEED);
        let speed = T::select(v_x.above(MIN_POWER_SPEED), v_x, slow);
        let most = speed.recip() * (power / car.mass);
        driven = T::select(most.real().less(driven.real()), most, driven);
    }
    if let Some(top) = car.speed_max {
        let mut most = (-v_x + top) * GOVERNOR_GAIN;
        if let Some(resistance) = resistance {
            most = most + resistance;
        }
        driven = T::select(most.real().less(driven.real()), most, driven);
        driven = T::select(driven.below(0.0), a.constant(0.0), driven);
    }
    let mut braked = a;
    if let Some(force) = car.brake_force_max {
        let least = -force / car.mass;
        braked = T::select(a.below(least), a.constant(least), braked);
    }
    T::select(braking, braked, driven)
}

/// Deceleration by drag, rolling resistance and the studies' linear drag.
#[inline(always)]
fn resistance<T: Number>(car: &CarParams, v_x: T, below: Option<&Ground<T>>) -> Option<T> {
    let drag = 0.5 * car.rho * car.cd * car.area / car.mass;
    if drag == 0.0 && car.rolling == 0.0 && car.linear_drag == 0.0 {
        return None;
    }
    let mut sum = v_x * v_x.abs() * drag + v_x * car.linear_drag;
    if car.rolling != 0.0 {
        let speed = (v_x * v_x + ROLLING_FADE_SPEED * ROLLING_FADE_SPEED).sqrt();
        let rolling = v_x * speed.recip() * (car.rolling * GRAVITY);
        sum = sum + below.map_or(rolling, |below| rolling * below.load);
    }
    Some(sum)
}

/// Vertical loads: static, plus downforce, plus transfer by the longitudinal acceleration.
#[inline(always)]
pub(super) fn vertical_loads<T: Number>(
    car: &CarParams,
    v_x: T,
    along: &Longitudinal<T>,
    below: Option<&Ground<T>>,
) -> [T; 2] {
    let fixed = car.static_loads();
    let mut loads = [v_x.constant(fixed[0]), v_x.constant(fixed[1])];
    if let Some(below) = below {
        loads = fixed.map(|fixed| below.load * fixed);
    }
    let pressure = 0.5 * car.rho * car.area;
    for (load, cl) in loads.iter_mut().zip([car.cl_front, car.cl_rear]) {
        if pressure * cl != 0.0 {
            *load = *load + v_x * v_x * (pressure * cl);
        }
    }
    if car.h_cg != 0.0 {
        let mut a_x = along.axle[0] + along.axle[1];
        if let Some(resistance) = along.resistance {
            a_x = a_x - resistance;
        }
        let transfer = a_x * (car.mass * car.h_cg / car.wheelbase());
        loads[0] = loads[0] - transfer;
        loads[1] = loads[1] + transfer;
        for (load, fixed) in loads.iter_mut().zip(fixed) {
            let least = MIN_LOAD_SHARE * fixed;
            *load = T::select(load.below(least), load.constant(least), *load);
        }
    }
    loads
}
