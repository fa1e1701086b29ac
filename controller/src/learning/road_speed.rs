//! What a part of the grip allows on the driven line: where the road has become slippery, the speeds
//! of earlier laps are no measure.
//!
//! ```text
//! v(s)^2 = min(share u_max A / kappa(s), v(s + ds)^2 + 2 ds brake)      backward, twice round
//! ```
//!
//! with the curvature kappa that the place needs on the line of the best lap (`bends.rs`; its yaw
//! rate alone would count a turn-in or a slide as a bend), the lateral acceleration A that the fitted grip
//! allows, and the greatest part u_max of it that the lap used.

use vehicle_model::{CarParams, GRAVITY, State, Track};

use super::bends::Bends;
use super::braking::{backward, between, deceleration, grid};
use super::dataset::Lap;
use super::envelope::Grip;

/// Part of the grip that a driven lap uses at least, and at most.
const USE: (f64, f64) = (0.6, 0.95);
/// Part of the grip that brakes may use before a bend.
const BRAKE_SHARE: f64 = 0.5;

/// Greatest speed along the track.
#[derive(Debug, Clone, Default)]
pub(crate) struct RoadSpeed {
    /// Distance of the grid points \[m\].
    ds: f64,
    /// Speed at each grid point \[m/s\]; empty if there is no bound.
    speed: Vec<f64>,
}

impl RoadSpeed {
    /// With this share of the fitted grip on the line of a lap; `driven` gives the share with which its
    /// samples were driven.
    pub(crate) fn new(
        car: &CarParams,
        (track, bends): (&Track, &Bends),
        (grip, share): ([f64; 2], f64),
        lap: &Lap,
        driven: impl Fn(usize) -> f64,
    ) -> Self {
        let (points, ds) = grid(car, track);
        let Grip { mu, down } = Grip::new(car, grip);
        let available = |v: f64| mu * (GRAVITY + down * v * v);
        let mut bend = vec![f64::NAN; points];
        let mut used: f64 = USE.0;
        for (i, pair) in lap.samples.windows(2).enumerate() {
            let (from, to) = (&pair[0].x, &pair[1].x);
            if to.s <= from.s || from.v_x <= 0.0 || to.v_x <= 0.0 {
                continue;
            }
            used = used.max((from.omega_z * from.v_x).abs() / available(from.v_x) / driven(i));
            let needed = |x: &State| bends.needed(x.s, x.e_y, x.omega_z / x.v_x).max(1e-6);
            // Squared speed at which the line takes all of the grip.
            let kappa = [from, to].map(|x| needed(x) / available(x.v_x));
            for k in (from.s / ds).ceil() as usize.. {
                let share = (k as f64 * ds - from.s) / (to.s - from.s);
                if share > 1.0 {
                    break;
                }
                bend[k % points] = kappa[0] + share * (kappa[1] - kappa[0]);
            }
        }
        let Some(start) = bend.iter().position(|v| !v.is_nan()) else { return Self::default() };
        let mut last = bend[start];
        let mut speed = vec![0.0; points];
        for i in 0..points {
            let i = (start + i) % points;
            if !bend[i].is_nan() {
                last = bend[i];
            }
            speed[i] = (share * used.min(USE.1) / last * track.friction(i as f64 * ds)).sqrt();
        }
        let brake = car.hardest_braking().min(BRAKE_SHARE * share * mu * GRAVITY);
        backward(&mut speed, |i, here, after| {
            let room = deceleration(track, i as f64 * ds, brake).max(0.0);
            here.min((after * after + 2.0 * ds * room).sqrt())
        });
        Self { ds, speed }
    }

    /// Whether there is a bound.
    pub(crate) fn bounds(&self) -> bool {
        !self.speed.is_empty()
    }

    /// Greatest speed at s \[m/s\]; infinite where nothing bounds it.
    pub(crate) fn at(&self, s: f64) -> f64 {
        between(&self.speed, self.ds, s)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use std::f64::consts::PI;

    use vehicle_model::{Input, Segment};

    use super::*;
    use crate::lap_number::LapNumber;
    use crate::learning::dataset::Sample;
    use crate::status::{LapKind, LapResult};

    /// A lap of a ring road of 100 m at 12 m/s, which takes all of the grip; the car yaws `slide` times as
    /// fast at s = 50 m.
    fn lap(slide: f64) -> Lap {
        let sample = |i: u32| {
            let (s, v_x) = (f64::from(i), 12.0);
            let omega_z = v_x * 2.0 * PI / 100.0 * if i == 50 { slide } else { 1.0 };
            let x = State { v_x, omega_z, s, ..State::default() };
            Sample { time: s / v_x, x, u: Input::default(), next: None }
        };
        let result = LapResult {
            lap: LapNumber::new(1),
            kind: LapKind::Learning,
            lap_time: 8.3,
            valid: true,
        };
        let samples = (0..=100).map(sample).collect();
        Lap { result, samples, start_time: 0.0, end_time: 8.3, follows: true }
    }

    #[test]
    fn a_slide_is_no_bend() {
        let car = CarParams::builtin("barc").unwrap();
        let half = Segment::arc(50.0 / PI, PI);
        let track = Track::from_segments("ring", &[half, half], 1.0, 1.0).unwrap();
        let bends = Bends::new(&car, &track);
        let speed = |lap: &Lap| {
            let road = RoadSpeed::new(&car, (&track, &bends), ([1.0; 2], 0.8), lap, |_| 1.0);
            move |s: f64| road.at(s)
        };
        let (steady, slid) = (speed(&lap(1.0)), speed(&lap(10.0)));
        // 0.95 of the grip that is left, on the radius of the ring.
        let mu = car.tyre_front.mu.min(car.tyre_rear.mu);
        let expected = (0.8 * 0.95 * mu * GRAVITY * 50.0 / PI).sqrt();
        for s in [20.0, 48.0, 50.0, 52.0, 80.0] {
            assert!((steady(s) - expected).abs() < 1e-3 * expected, "{} not {expected}", steady(s));
            assert!((slid(s) - expected).abs() < 1e-3 * expected, "{} not {expected}", slid(s));
        }
    }
}
