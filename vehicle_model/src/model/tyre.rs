//! Lateral tyre forces: slip angles and the Pacejka curve.

use std::f64::consts::FRAC_PI_2;

use crate::number::{Function, Number, Real};
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

/// F_y = D sin(C atan(B alpha)), its derivative by alpha a secant's where the tyre says so.
#[inline(always)]
pub(super) fn lateral_force<T: Number>(tyre: &Tyre, peak: T, alpha: T) -> T {
    peak * alpha.through(&Curve { tyre })
}

impl Tyre {
    /// F_y / D at a slip angle, and its derivative as linearisations have it \[1/rad\].
    #[must_use]
    pub fn force_share(&self, alpha: f64) -> (f64, f64) {
        let (sin, cos) = curve(self, alpha);
        let tangent = cos * self.b * self.c / (1.0 + self.b * self.b * alpha * alpha);
        let excess = match self.secant.length > 0.0 {
            true => excess_slope(self, alpha, sin, cos),
            false => 0.0,
        };
        (sin, tangent + excess)
    }

    /// The slip angle, peak slip at most, whose F_y / D is `share` \[rad\]; that of the peak beyond it.
    #[must_use]
    pub fn slip_of(&self, share: f64) -> f64 {
        let most = libm::sin(self.c.min(1.0) * FRAC_PI_2);
        if share.abs() >= most {
            return self.peak_slip().copysign(share);
        }
        libm::tan(libm::asin(share) / self.c) / self.b
    }
}

/// sin(C atan(B alpha)) with that derivative.
struct Curve<'a> {
    tyre: &'a Tyre,
}

impl Function for Curve<'_> {
    #[inline(always)]
    fn at<T: Number>(&self, alpha: T) -> T {
        let (sin, cos) = curve(self.tyre, alpha);
        if self.tyre.secant.length == 0.0 || T::PLAIN {
            return sin;
        }
        let excess = excess_slope(self.tyre, alpha.real(), sin.real(), cos.real());
        // Zero in value: alpha's derivatives alone.
        let change = alpha - alpha.constant(1.0).scale(alpha.real());
        sin + change.scale(excess)
    }
}

/// sin and cos of C atan(B alpha). A closure would be compiled apart from the vector instructions
/// around it.
#[inline(always)]
fn curve<T: Number>(tyre: &Tyre, alpha: T) -> (T, T) {
    ((alpha * tyre.b).atan() * tyre.c).sin_cos()
}

/// By how much the secant's slope exceeds the tangent's where the curve has this sine and cosine.
#[inline(always)]
fn excess_slope<R: Real>(tyre: &Tyre, alpha: R, sin: R, cos: R) -> R {
    let secant = &tyre.secant;
    let (zero, one) = (alpha.constant(0.0), alpha.constant(1.0));
    // The curve is odd.
    let sin = R::select(alpha.below(0.0), -sin, sin);
    let alpha = alpha.abs();
    let share = (alpha - secant.from) * (1.0 / (secant.full - secant.from));
    let share = R::select(share.above(1.0), one, share);
    // The tangent is the limit of short secants, whose quotients lose their digits.
    let long = share.above(1e-3);
    if !share.any(long) {
        return zero;
    }
    let length = R::select(long, share * secant.length, one);
    let slope = cos * (tyre.b * tyre.c) / (alpha * alpha * (tyre.b * tyre.b) + 1.0);
    R::select(long, (sin - curve(tyre, alpha - length).0) / length - slope, zero)
}
