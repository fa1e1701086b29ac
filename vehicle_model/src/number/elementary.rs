//! Sine, cosine and inverse tangent in plain arithmetic: the same bits in every lane and on every
//! machine, whatever its mathematical library. Errors stay below 2e-16 relative to the larger of
//! the result and, for sine and cosine, 1e-16 absolute.

use std::f64::consts::{FRAC_2_PI, FRAC_PI_2, FRAC_PI_4};

use super::Real;

/// Adding and subtracting it rounds to an integer.
const ROUND: f64 = 6_755_399_441_055_744.0; // 1.5 * 2^52
/// pi/2 in three parts of 33 bits or more: products of the first two with small integers are exact.
const HALF_PI: [f64; 3] =
    [1.570_796_326_734_125_6, 6.077_100_506_303_966e-11, 2.022_266_248_795_950_6e-21];
/// Largest argument that is reduced with these; above it the `libm` crate takes over.
const LARGEST: f64 = 1e5;

/// Taylor coefficients of (sin r - r)/r^3 in r^2; the next one adds less than 1e-18 at pi/4.
const SIN: [[f64; 4]; 2] = [
    [-1.0 / 6.0, 1.0 / 120.0, -1.0 / 5_040.0, 1.0 / 362_880.0],
    [
        -1.0 / 39_916_800.0,
        1.0 / 6_227_020_800.0,
        -1.0 / 1_307_674_368_000.0,
        1.0 / 355_687_428_096_000.0,
    ],
];
/// Taylor coefficients of (cos r - 1)/r^2 in r^2; the next one adds less than 1e-17 at pi/4.
const COS: [[f64; 4]; 2] = [
    [-1.0 / 2.0, 1.0 / 24.0, -1.0 / 720.0, 1.0 / 40_320.0],
    [-1.0 / 3_628_800.0, 1.0 / 479_001_600.0, -1.0 / 87_178_291_200.0, 1.0 / 20_922_789_888_000.0],
];
/// Chebyshev fit of (atan z - z)/z^3 in z^2 for |z| up to tan(pi/8), to 2e-19 of atan z.
const ATAN: [[f64; 4]; 3] = [
    [-0.3333333333333333, 0.19999999999999804, -0.14285714285659779, 0.11111111105150588],
    [-0.09090908753259112, 0.07692296368042296, -0.0666642476020052, 0.05878927554473807],
    [-0.05230443640686948, 0.045515447340221615, -0.03456931506332609, 0.016284375050043393],
];
/// tan(pi/8) and tan(3 pi/8): where the reduction changes.
const ATAN_LIMITS: [f64; 2] = [0.414_213_562_373_095_05, 2.414_213_562_373_095];
/// What pi/2 has beyond its double.
const FRAC_PI_2_REST: f64 = 6.123_233_995_736_766e-17;

/// Sine and cosine.
#[inline(always)]
pub(super) fn sin_cos<T: Real>(x: T) -> (T, T) {
    // x = n pi/2 + r, n = 4 m + quadrant.
    let n = (x * FRAC_2_PI + ROUND) - ROUND;
    let r = ((x - n * HALF_PI[0]) - n * HALF_PI[1]) - n * HALF_PI[2];
    let m = (n * 0.25 + ROUND) - ROUND;
    let quadrant = n - m * 4.0;

    let square = r * r;
    let sin_r = r + r * square * polynomial(square, &SIN);
    let cos_r = square * polynomial(square, &COS) + 1.0;
    // Quadrants are -2..=2; odd ones swap the two.
    let odd = (quadrant.abs() - 1.0).abs().below(0.5);
    let sin = T::select(odd, cos_r, sin_r);
    let cos = T::select(odd, sin_r, cos_r);
    let sin = T::select((quadrant - 0.5).abs().above(1.0), -sin, sin);
    let cos = T::select((quadrant + 0.5).abs().above(1.0), -cos, cos);

    let far = x.abs().above(LARGEST);
    if x.any(far) {
        return (T::select(far, x.map(libm::sin), sin), T::select(far, x.map(libm::cos), cos));
    }
    (sin, cos)
}

/// Inverse tangent.
#[inline(always)]
pub(super) fn atan<T: Real>(x: T) -> T {
    // atan t = base + atan z with |z| at most tan(pi/8): z is t, (t - 1)/(t + 1) or -1/t.
    let t = x.abs();
    let (middle, far) = (t.above(ATAN_LIMITS[0]), t.above(ATAN_LIMITS[1]));
    let one = t.constant(1.0);
    let numerator = T::select(far, -one, T::select(middle, t - 1.0, t));
    let denominator = T::select(far, t, T::select(middle, t + 1.0, one));
    let z = numerator / denominator;
    let base = T::select(middle, t.constant(FRAC_PI_4), t.constant(0.0));
    let base = T::select(far, t.constant(FRAC_PI_2), base);
    let rest = base * (FRAC_PI_2_REST / FRAC_PI_2);

    let square = z * z;
    let y = base + (z + (z * square * polynomial(square, &ATAN) + rest));
    T::select(x.below(0.0), -y, y)
}

/// The polynomial with these coefficients, the constant one first, in blocks that do not wait for
/// each other (Estrin's scheme).
#[inline(always)]
fn polynomial<T: Real, const BLOCKS: usize>(x: T, coefficients: &[[f64; 4]; BLOCKS]) -> T {
    let square = x * x;
    let fourth = square * square;
    let mut sum = x.constant(0.0);
    for (i, c) in coefficients.iter().rev().enumerate() {
        let block = (x * c[1] + c[0]) + square * (x * c[3] + c[2]);
        sum = if i == 0 { block } else { sum * fourth + block };
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against the standard library, whose errors are below one unit in the last place.
    #[test]
    fn as_accurate_as_the_standard_library() {
        for i in -400_000..400_000 {
            let x = f64::from(i) * 1.7e-4;
            let (sin, cos) = sin_cos(x);
            assert!((sin - x.sin()).abs() < 2.5e-16, "sin {x}");
            assert!((cos - x.cos()).abs() < 2.5e-16, "cos {x}");
            let error = atan(x) - f64::atan(x);
            assert!(error.abs() <= 3e-16 * f64::atan(x).abs(), "atan {x}: {error:e}");
        }
        for x in [1e-300, 1e-9, 1.0, 1e5, 1.1e5, 1e12, 1e300] {
            assert!((atan(x) - f64::atan(x)).abs() <= 3e-16 * f64::atan(x));
            let (sin, cos) = sin_cos(x);
            assert!((sin - x.sin()).abs() < 2.5e-16 && (cos - x.cos()).abs() < 2.5e-16, "{x}");
        }
        assert!(atan(f64::NAN).is_nan() && sin_cos(f64::NAN).0.is_nan());
        assert_eq!(atan(f64::INFINITY), FRAC_PI_2);
        assert_eq!(atan(f64::NEG_INFINITY), -FRAC_PI_2);
    }
}
