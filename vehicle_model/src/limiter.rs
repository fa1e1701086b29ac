//! What a car may be asked: box, rates and speed cap of the input, one implementation for all.

use crate::params::CarParams;
use crate::state::Input;

/// Violations below this are solver tolerance and are not reported as clipping. \[m/s^2, rad\]
const TOLERANCE: f64 = 1e-6;

/// One limit; its value is its bit in [`Limited::bits`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(i32)]
pub enum Limit {
    /// Greatest steering angle.
    Steering = 0x01,
    /// Greatest steering rate.
    SteeringRate = 0x02,
    /// Least and greatest acceleration.
    Acceleration = 0x04,
    /// Greatest jerk.
    Jerk = 0x08,
    /// Speed cap.
    SpeedCap = 0x10,
    /// Not a number, or infinite: the input before is kept.
    NotFinite = 0x20,
}

/// Limits of the input.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limiter {
    /// Least acceleration, braking negative. \[m/s^2\]
    pub a_min: f64,
    /// Greatest acceleration. \[m/s^2\]
    pub a_max: f64,
    /// Greatest steering angle. \[rad\]
    pub delta_max: f64,
    /// Greatest jerk; infinite for none. \[m/s^3\]
    pub a_rate_max: f64,
    /// Greatest steering rate; infinite for none. \[rad/s\]
    pub delta_rate_max: f64,
    /// Speed towards which the car may be accelerated; infinite for none. \[m/s\]
    pub speed_cap: f64,
}

/// An input after its limits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limited {
    /// As asked.
    pub asked: Input,
    /// As the car may have it; finite and inside the box for whatever was asked.
    pub sent: Input,
    /// Limits that moved the input by more than rounding, see [`Limit`]. \[bits\]
    pub bits: i32,
}

impl Limited {
    /// Whether this limit moved the input.
    #[must_use]
    pub fn by(&self, limit: Limit) -> bool {
        self.bits & limit as i32 != 0
    }
}

impl Limiter {
    /// Time in which an excess over the speed cap is to vanish. \[s\]
    pub const CAP_TIME: f64 = 0.5;

    /// The car's own limits, without a speed cap.
    #[must_use]
    pub fn new(car: &CarParams) -> Self {
        Self {
            a_min: car.a_min,
            a_max: car.a_max,
            delta_max: car.delta_max,
            a_rate_max: car.a_rate_max.unwrap_or(f64::INFINITY),
            delta_rate_max: car.delta_rate_max.unwrap_or(f64::INFINITY),
            speed_cap: f64::INFINITY,
        }
    }

    /// Limits an input that follows `before` by `dt` \[s\] at the speed `v_x` \[m/s\].
    #[must_use]
    pub fn limit(&self, asked: Input, before: Input, v_x: f64, dt: f64) -> Limited {
        let mut bits = 0;
        let mut bound = |value: f64, least: f64, most: f64, limit: Limit| {
            // Has an answer for crossed bounds, and none for bounds that are no numbers.
            let bounded = value.max(least).min(most);
            if (bounded - value).abs() > TOLERANCE {
                bits |= limit as i32;
            }
            bounded
        };
        let finite = |value: f64, other: f64| if value.is_finite() { value } else { other };
        let (was_a, was_delta) = (finite(before.a, 0.0), finite(before.delta, 0.0));
        let (jerk, rate) = (self.a_rate_max * dt, self.delta_rate_max * dt);
        // An unknown speed may be above the cap.
        let to_cap = if self.speed_cap == f64::INFINITY {
            f64::INFINITY
        } else {
            finite((self.speed_cap - v_x) / Self::CAP_TIME, 0.0)
        };
        let a = finite(asked.a, was_a);
        let a = bound(a, f64::NEG_INFINITY, to_cap, Limit::SpeedCap);
        let a = bound(a, was_a - jerk, was_a + jerk, Limit::Jerk);
        let a = bound(a, self.a_min, self.a_max, Limit::Acceleration);
        let delta = finite(asked.delta, was_delta);
        let delta = bound(delta, was_delta - rate, was_delta + rate, Limit::SteeringRate);
        let delta = bound(delta, -self.delta_max, self.delta_max, Limit::Steering);
        if !asked.is_finite() {
            bits |= Limit::NotFinite as i32;
        }
        Limited { asked, sent: Input { a, delta }, bits }
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt as _, SeedableRng as _};

    use super::*;

    const LIMITER: Limiter = Limiter {
        a_min: -5.0,
        a_max: 2.0,
        delta_max: 0.4,
        a_rate_max: 50.0,
        delta_rate_max: 1.0,
        speed_cap: 10.0,
    };

    fn limit(a: f64, delta: f64, before: Input, v_x: f64) -> Limited {
        LIMITER.limit(Input { a, delta }, before, v_x, 0.1)
    }

    #[test]
    fn each_limit_is_named() {
        let rest = Input::default();
        let cases = [
            (limit(9.0, 0.0, rest, 0.0), Input { a: 2.0, delta: 0.0 }, 0x04 | 0x08),
            (limit(4.0, 0.0, rest, 0.0), Input { a: 2.0, delta: 0.0 }, 0x04),
            (
                limit(-5.0, 0.0, Input { a: 2.0, delta: 0.0 }, 0.0),
                Input { a: -3.0, delta: 0.0 },
                0x08,
            ),
            (limit(0.0, 0.3, rest, 0.0), Input { a: 0.0, delta: 0.1 }, 0x02),
            (
                limit(0.0, 0.5, Input { a: 0.0, delta: 0.4 }, 0.0),
                Input { a: 0.0, delta: 0.4 },
                0x01,
            ),
            (limit(2.0, 0.0, rest, 10.5), Input { a: -1.0, delta: 0.0 }, 0x10),
            (limit(1.0, 0.05, rest, 9.0), Input { a: 1.0, delta: 0.05 }, 0),
        ];
        for (got, sent, bits) in cases {
            assert!((got.sent.a - sent.a).abs() < 1e-12, "{got:?}");
            assert!((got.sent.delta - sent.delta).abs() < 1e-12, "{got:?}");
            assert_eq!(got.bits, bits, "{got:?}");
        }
    }

    #[test]
    fn less_than_the_tolerance_is_no_clipping() {
        let limiter = Limiter { a_max: 0.0, a_rate_max: f64::INFINITY, ..LIMITER };
        let bits = |a: f64| limiter.limit(Input { a, delta: 0.0 }, Input::default(), 0.0, 0.1).bits;
        assert_eq!((bits(TOLERANCE), bits(1.01 * TOLERANCE)), (0, 0x04));
    }

    #[test]
    fn whatever_is_asked_the_sent_input_is_finite_and_inside() {
        let odd = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300, -1e300, 0.0];
        for a in odd {
            for delta in odd {
                for before in odd {
                    for v_x in odd {
                        let was = Input { a: before, delta: before };
                        let got = limit(a, delta, was, v_x);
                        assert!((-5.0..=2.0).contains(&got.sent.a), "{got:?}");
                        assert!((-0.4..=0.4).contains(&got.sent.delta), "{got:?}");
                        let finite = a.is_finite() && delta.is_finite();
                        assert_eq!(got.by(Limit::NotFinite), !finite);
                    }
                }
            }
        }
    }

    #[test]
    fn the_sent_input_is_the_nearest_that_the_limits_allow() {
        let mut random = rand_pcg::Pcg64::seed_from_u64(3);
        let mut seen = [0_u32; 5];
        let mut before = Input::default();
        for n in 0..200_000 {
            let (asked_a, asked_delta) =
                (random.random_range(-7.0..4.0), random.random_range(-0.6..0.6));
            let (v_x, dt) = (random.random_range(0.0..12.0), random.random_range(0.0..0.3));
            let got = LIMITER.limit(Input { a: asked_a, delta: asked_delta }, before, v_x, dt);
            // Box and rates meet, as the input before was in the box; the cap yields to both.
            let (least, most) = ((before.a - 50.0 * dt).max(-5.0), (before.a + 50.0 * dt).min(2.0));
            let cap = ((10.0 - v_x) / 0.5).max(least);
            let a = asked_a.max(least).min(most.min(cap));
            let (left, right) =
                ((before.delta + 1.0 * dt).min(0.4), (before.delta - 1.0 * dt).max(-0.4));
            let delta = asked_delta.max(right).min(left);
            assert!((got.sent.a - a).abs() < 1e-9, "{n}: {got:?}, expected {a}");
            assert!((got.sent.delta - delta).abs() < 1e-9, "{n}: {got:?}, expected {delta}");
            let moved = [got.sent.a != asked_a, got.sent.delta != asked_delta];
            let named = [0x04 | 0x08 | 0x10, 0x01 | 0x02].map(|bits| got.bits & bits != 0);
            let beyond = [(got.sent.a - asked_a).abs(), (got.sent.delta - asked_delta).abs()];
            if beyond.iter().all(|by| *by == 0.0 || *by > 1e-5) {
                assert_eq!(moved, named, "{n}: {got:?}");
            }
            for (bit, count) in seen.iter_mut().enumerate() {
                *count += u32::from(got.bits & 1 << bit != 0);
            }
            before = got.sent;
        }
        assert!(seen.iter().all(|count| *count > 1000), "{seen:?}");
    }
}
