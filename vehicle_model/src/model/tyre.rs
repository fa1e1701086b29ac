//! Lateral tyre forces: slip angles and the Pacejka curve.

use crate::number::Number;
use crate::params::Tyre;

/// Lowest v_x the slip angles divide by [m/s].
const MIN_SLIP_SPEED: f64 = 0.05;

/// v_x with the floor the slip angles use.
#[inline(always)]
pub(crate) fn slip_speed<T: Number>(v_x: T) -> T {
    T::select(v_x.above(MIN_SLIP_SPEED), v_x, v_x.constant(MIN_SLIP_SPEED))
}

/// Slip angles of the front and rear axle, positive when the force points left:
/// alpha_f = delta - atan((v_y + l_f omega_z)/v_x), alpha_r = -atan((v_y - l_r omega_z)/v_x).
#[inline(always)]
pub(super) fn slip_angles<T: Number>(l_f: f64, l_r: f64, v: &[T; 3], delta: T) -> [T; 2] {
    let [v_x, v_y, omega_z] = *v;
    let per_speed = slip_speed(v_x).recip();
    [
        delta - ((v_y + omega_z * l_f) * per_speed).atan(),
        -((v_y - omega_z * l_r) * per_speed).atan(),
    ]
}

/// F_y = D sin(C atan(B alpha)).
#[inline(always)]
pub(super) fn lateral_force<T: Number>(tyre: &Tyre, peak: T, alpha: T) -> T {
    let (sin, _) = ((alpha * tyre.b).atan() * tyre.c).sin_cos();
    peak * sin
}
