//! Dynamic bicycle (single-track) model:
//!
//! v_x'     = a - F_yf sin(delta)/m + omega_z v_y
//! v_y'     = (F_yf cos(delta) + F_yr)/m - omega_z v_x
//! omega_z' = (l_f F_yf cos(delta) - l_r F_yr)/I_z
//!
//! (Rajamani 2012, ch. 2; Xue et al. 2023, section II). A share of a on the steered front axle
//! acts along the wheel: cos(delta) of it forward, sin(delta) to the left.

use super::axles::{AxleForces, Longitudinal, longitudinal, vertical_loads};
use super::{Number, kinematic, tyre};
use crate::params::{CarParams, Tyre};
use crate::state::NU;

/// Least share of the lateral force that full longitudinal force leaves: keeps the friction
/// ellipse's slope finite.
const MIN_ELLIPSE_SHARE: f64 = 0.05;

/// Rates of v_x, v_y and omega_z.
pub(super) fn velocity_rates<T: Number>(
    car: &CarParams,
    v: &[T; 3],
    u: &[T; NU],
    grip: &[T; 2],
) -> [T; 3] {
    let share = blend_share(car, v[0]);
    let Some(share) = share else { return tyre_rates(car, v, u, grip) };
    let rolling = kinematic::velocity_rates(car, v, u);
    if share.re() == 0.0 {
        return rolling;
    }
    let tyres = tyre_rates(car, v, u, grip);
    std::array::from_fn(|i| rolling[i] + (tyres[i] - rolling[i]) * share)
}

/// Share of the tyre model at this speed, a smoothstep between the blend speeds; `None` where the
/// tyre model acts alone.
fn blend_share<T: Number>(car: &CarParams, v_x: T) -> Option<T> {
    let (low, high) = (car.blend_speed_low, car.blend_speed_high);
    if v_x.re() >= high || (low == 0.0 && high == 0.0) {
        return None;
    }
    if v_x.re() <= low {
        return Some(T::from(0.0));
    }
    let t = (v_x - low) / (high - low);
    Some(t * t * (-(t * 2.0) + 3.0))
}

/// Rates by the tyre forces alone.
fn tyre_rates<T: Number>(car: &CarParams, v: &[T; 3], u: &[T; NU], grip: &[T; 2]) -> [T; 3] {
    let [v_x, v_y, omega_z] = *v;
    let (sin_delta, cos_delta) = u[1].sin_cos();
    let along = longitudinal(car, v_x, u[0]);
    let forces = axle_forces(car, v, u[1], grip, &along);
    let [f_yf, f_yr] = forces.lateral;
    let [f_xf, f_xr] = forces.long;

    // Without the ellipse the axles' accelerations are the commanded ones to the last bit.
    let [a_xf, a_xr] =
        if car.combined_slip { [f_xf / car.mass, f_xr / car.mass] } else { along.axle };
    let mut a_x = a_xr;
    let mut v_y_dot = (f_yf * cos_delta + f_yr) / car.mass - omega_z * v_x;
    let mut omega_z_dot = (f_yf * cos_delta * car.l_f - f_yr * car.l_r) / car.inertia_z;
    if along.front_acts {
        a_x += a_xf * cos_delta;
        v_y_dot += a_xf * sin_delta;
        if car.front_force_yaw {
            omega_z_dot += a_xf * sin_delta * (car.mass * car.l_f / car.inertia_z);
        }
    }
    if let Some(resistance) = along.resistance {
        a_x -= resistance;
    }
    [a_x - f_yf * sin_delta / car.mass + omega_z * v_y, v_y_dot, omega_z_dot]
}

/// Forces of both axles.
pub(super) fn forces<T: Number>(
    car: &CarParams,
    v: &[T; 3],
    u: &[T; NU],
    grip: &[T; 2],
) -> AxleForces<T> {
    axle_forces(car, v, u[1], grip, &longitudinal(car, v[0], u[0]))
}

fn axle_forces<T: Number>(
    car: &CarParams,
    v: &[T; 3],
    delta: T,
    grip: &[T; 2],
    along: &Longitudinal<T>,
) -> AxleForces<T> {
    let slip = tyre::slip_angles(car.l_f, car.l_r, v, delta);
    let vertical = vertical_loads(car, v[0], along);
    let tyres = [&car.tyre_front, &car.tyre_rear];
    let axle = |i: usize| {
        axle_force(car, tyres[i], vertical[i], grip[i], slip[i], along.axle[i] * car.mass)
    };
    let (front, rear) = (axle(0), axle(1));
    AxleForces { long: [front.0, rear.0], lateral: [front.1, rear.1], vertical, slip }
}

/// Longitudinal and lateral force of one axle.
fn axle_force<T: Number>(
    car: &CarParams,
    tyre: &Tyre,
    load: T,
    grip: T,
    slip: T,
    asked: T,
) -> (T, T) {
    let peak = load * tyre.mu * grip;
    let mut long = asked;
    let mut lateral = tyre::lateral_force(tyre, peak, slip);
    if car.combined_slip && asked.re() != 0.0 {
        if long.re().abs() > peak.re() {
            long = if long.re() > 0.0 { peak } else { -peak };
        }
        let used = long * peak.recip();
        let left = -(used * used) + 1.0;
        let least = MIN_ELLIPSE_SHARE * MIN_ELLIPSE_SHARE;
        lateral *= if left.re() > least { left.sqrt() } else { T::from(MIN_ELLIPSE_SHARE) };
    }
    (long, lateral)
}
