//! Dynamic bicycle (single-track) model:
//!
//! v_x'     = a - F_yf sin(delta)/m + omega_z v_y
//! v_y'     = (F_yf cos(delta) + F_yr)/m - omega_z v_x
//! omega_z' = (l_f F_yf cos(delta) - l_r F_yr)/I_z
//!
//! (Rajamani 2012, ch. 2; Xue et al. 2023, section II). A share of a on the steered front axle
//! acts along the wheel: cos(delta) of it forward, sin(delta) to the left.

use super::axles::{AxleForces, Longitudinal, longitudinal, vertical_loads};
use super::{Ground, Held, kinematic, tyre};
use crate::number::{Number, Real};
use crate::params::{CarParams, Tyre};
use crate::state::NU;

/// Least share of the lateral force that full longitudinal force leaves: keeps the friction
/// ellipse's slope finite.
const MIN_ELLIPSE_SHARE: f64 = 0.05;

/// Rates of v_x, v_y and omega_z.
#[inline(always)]
pub(super) fn velocity_rates<T: Number>(
    car: &CarParams,
    v: &[T; 3],
    u: &Held<T>,
    grip: &[T; 2],
    below: Option<&Ground<T>>,
) -> [T; 3] {
    let (low, high) = (car.blend_speed_low, car.blend_speed_high);
    let blends = low != 0.0 || high != 0.0;
    let (acting, blended) = (v[0].above(low), v[0].below(high));
    if blends && !v[0].real().any(acting) {
        return kinematic::velocity_rates(car, v, u, below);
    }
    let tyres = tyre_rates(car, v, u, grip, below);
    if !blends || !v[0].real().any(blended) {
        return tyres;
    }
    let rolling = kinematic::velocity_rates(car, v, u, below);
    // Share of the tyre model, a smoothstep between the blend speeds.
    let t = (v[0] - low) * (1.0 / (high - low));
    let share = t * t * (-(t * 2.0) + 3.0);
    let mut rates = tyres;
    for (rate, rolling) in rates.iter_mut().zip(rolling) {
        let between = rolling + (*rate - rolling) * share;
        *rate = T::select(blended, T::select(acting, between, rolling), *rate);
    }
    rates
}

/// Rates by the tyre forces alone.
#[inline(always)]
fn tyre_rates<T: Number>(
    car: &CarParams,
    v: &[T; 3],
    u: &Held<T>,
    grip: &[T; 2],
    below: Option<&Ground<T>>,
) -> [T; 3] {
    let [v_x, v_y, omega_z] = *v;
    let Held { a, delta, sin_delta, cos_delta } = *u;
    let along = longitudinal(car, v_x, a, below);
    let forces = axle_forces(car, v, delta, grip, &along, below);
    let [f_yf, f_yr] = forces.lateral;
    let [f_xf, f_xr] = forces.long;

    // Without the ellipse the axles' accelerations are the commanded ones to the last bit.
    let [a_xf, a_xr] = if car.combined_slip {
        [f_xf * (1.0 / car.mass), f_xr * (1.0 / car.mass)]
    } else {
        along.axle
    };
    let (per_mass, per_inertia) = (1.0 / car.mass, 1.0 / car.inertia_z);
    let mut a_x = a_xr;
    let f_yf_across = f_yf * cos_delta;
    let mut v_y_dot = (f_yf_across + f_yr) * per_mass - omega_z * v_x;
    let mut omega_z_dot = f_yf_across * (car.l_f * per_inertia) - f_yr * (car.l_r * per_inertia);
    if along.front_acts {
        a_x = a_x + a_xf * cos_delta;
        v_y_dot = v_y_dot + a_xf * sin_delta;
        if car.front_force_yaw {
            omega_z_dot = omega_z_dot + a_xf * sin_delta * (car.mass * car.l_f * per_inertia);
        }
    }
    if let Some(resistance) = along.resistance {
        a_x = a_x - resistance;
    }
    if let Some(below) = below {
        a_x = a_x + below.gravity[0];
        v_y_dot = v_y_dot + below.gravity[1];
    }
    [a_x - f_yf * sin_delta * per_mass + omega_z * v_y, v_y_dot, omega_z_dot]
}

/// Forces of both axles.
#[inline(always)]
pub(super) fn forces<T: Number>(
    car: &CarParams,
    v: &[T; 3],
    u: &[T; NU],
    grip: &[T; 2],
    below: Option<&Ground<T>>,
) -> AxleForces<T> {
    axle_forces(car, v, u[1], grip, &longitudinal(car, v[0], u[0], below), below)
}

#[inline(always)]
fn axle_forces<T: Number>(
    car: &CarParams,
    v: &[T; 3],
    delta: T,
    grip: &[T; 2],
    along: &Longitudinal<T>,
    below: Option<&Ground<T>>,
) -> AxleForces<T> {
    let slip = tyre::slip_angles(car.l_f, car.l_r, v, delta);
    let vertical = vertical_loads(car, v[0], along, below);
    let [front, rear] = along.axle;
    let front = axle_force(car, &car.tyre_front, vertical[0], grip[0], slip[0], front * car.mass);
    let rear = axle_force(car, &car.tyre_rear, vertical[1], grip[1], slip[1], rear * car.mass);
    AxleForces { long: [front.0, rear.0], lateral: [front.1, rear.1], vertical, slip }
}

/// Longitudinal and lateral force of one axle.
#[inline(always)]
fn axle_force<T: Number>(
    car: &CarParams,
    tyre: &Tyre,
    load: T,
    grip: T,
    slip: T,
    asked: T,
) -> (T, T) {
    let peak = load * tyre.mu * grip;
    let lateral = tyre::lateral_force(tyre, peak, slip);
    if !car.combined_slip {
        return (asked, lateral);
    }
    let exceeded = peak.real().less(asked.abs().real());
    let most = T::select(asked.above(0.0), peak, -peak);
    let long = T::select(exceeded, most, asked);
    let used = long * peak.recip();
    let left = -(used * used) + 1.0;
    let least = left.constant(MIN_ELLIPSE_SHARE);
    let share = T::select(left.above(MIN_ELLIPSE_SHARE * MIN_ELLIPSE_SHARE), left.sqrt(), least);
    // A rolling wheel keeps all of its lateral force, whatever its load.
    let rolling = T::select(asked.abs().above(0.0), lateral * share, lateral);
    (long, rolling)
}
