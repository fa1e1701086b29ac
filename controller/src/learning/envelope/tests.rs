//! What a near miss takes from the speed before it.

use vehicle_model::{CarParams, Input, Segment, State, Track};

use super::*;
use crate::config::Config;

const BRAKING_FROM: f64 = 1000.0;
const FAST: f64 = 40.0;
const SLOW: f64 = 10.0;

/// A ring road of 2 km.
fn ring() -> Track {
    let radius = 1000.0 / std::f64::consts::PI;
    let half = Segment::arc(radius, std::f64::consts::PI);
    Track::from_segments("ring", &[half, half], 6.0, 6.0).unwrap()
}

/// The samples of a lap at 40 m/s that brakes with `a` \[m/s^2\] to 10 m/s and then stays as slow.
fn lap(a: f64) -> Vec<Sample> {
    let speed = |s: f64| {
        let squared = FAST * FAST - 2.0 * a * (s - BRAKING_FROM).max(0.0);
        squared.max(SLOW * SLOW).sqrt()
    };
    (0..2000).map(|i| sample(f64::from(i), speed(f64::from(i)))).collect()
}

/// On the ring road's line at a speed.
fn sample(s: f64, v_x: f64) -> Sample {
    let x = State { v_x, omega_z: v_x * std::f64::consts::PI / 1000.0, s, ..State::default() };
    Sample { time: s, x, u: Input::default(), next: None }
}

/// A lap that neither follows another nor leads to one.
fn alone(samples: &[Sample]) -> Driven<'_> {
    Driven { samples, before: None, behind: None }
}

fn envelope_of<'a>(laps: impl Iterator<Item = Driven<'a>>, misses: &[NearMiss]) -> Envelope {
    let car = CarParams::builtin("iac").unwrap();
    let config = Config::default().envelope;
    let track = ring();
    let bends = Bends::new(&car, &track);
    Envelope::new(&config, &car, [1.0; 2], (&track, &bends), laps, (misses, 1))
}

fn envelope(lap: &[Sample], misses: &[NearMiss]) -> Envelope {
    envelope_of(std::iter::once(alone(lap)), misses)
}

/// A slow lap with samples close to the line does not hold up a fast one that passed the line between two
/// samples far apart, whether or not it led to another lap.
#[test]
fn the_fastest_lap_counts_at_the_line() {
    let slow: Vec<_> = (0..2000).map(|i| sample(f64::from(i), SLOW)).collect();
    let fast: Vec<_> = (0..39).map(|i| sample(25.0 + 50.0 * f64::from(i), FAST)).collect();
    let (last, next) = (sample(1975.0, FAST), sample(25.0, FAST));
    let between = Driven {
        samples: &fast,
        before: Some(Seen { sample: &last, offset: -2000.0 }),
        behind: Some(Seen { sample: &next, offset: 2000.0 }),
    };
    for fast in [between, alone(&fast)] {
        let found = envelope_of([alone(&slow), fast].into_iter(), &[]);
        for s in [0.0, 0.5, 12.0, 1000.0, 1960.0, 1999.5] {
            assert!((found.driven_at(s) - FAST).abs() < 1e-9, "at {s} m: {}", found.driven_at(s));
            assert!(found.at(s) > FAST, "at {s} m: {}", found.at(s));
        }
    }
}

/// Where all grip is used, the way that a point mass needs to cross the track times the growth is a tenth of
/// the track's width, but no growth exceeds the configured one.
#[test]
fn a_fast_bend_of_a_narrow_track_grows_less() {
    let car = CarParams::builtin("barc").unwrap();
    let grip = car.tyre_front.mu.min(car.tyre_rear.mu) * GRAVITY;
    for (speed, limited) in [(140.0, true), (5.0, false)] {
        let mut lap = lap(0.0);
        for sample in &mut lap {
            sample.x.v_x = speed;
            // More than the tyres hold.
            sample.x.omega_z = 2.0 * grip / speed;
        }
        let config = Config::default().envelope;
        let bends = Bends { kappa: vec![1.0; 10], ds: 200.0 };
        let found = Envelope::new(
            &config,
            &car,
            [1.0; 2],
            (&ring(), &bends),
            std::iter::once(alone(&lap)),
            (&[], 1),
        );
        let growth = found.at(500.0) / speed - 1.0;
        let crossing = speed * (2.0 * 12.0 / grip).sqrt();
        let expected = if limited { 0.1 * 12.0 / crossing } else { config.growth_least };
        assert!((growth - expected).abs() < 1e-3 * expected, "{growth} not {expected}");
    }
}

/// Where a lap braked harder than the envelope's own brakes do, a slower end takes the same kinetic
/// energy off every speed before it: the braking stays that of the lap.
#[test]
fn before_a_near_miss_the_car_brakes_as_a_driven_lap_did() {
    let a = 18.0;
    let lap = lap(a);
    let end = BRAKING_FROM + (FAST * FAST - SLOW * SLOW) / (2.0 * a);
    let miss = NearMiss { lap: 0, s: [end, end + 20.0], speed: SLOW, used: 1.0 };
    let (free, held) = (envelope(&lap, &[]), envelope(&lap, &[miss]));
    let energy = SLOW * SLOW - miss.allowed(0) * miss.allowed(0);
    for s in [1005.0, 1015.0, 1025.0, 1035.0] {
        let driven = FAST * FAST - 2.0 * a * (s - BRAKING_FROM);
        let expected = (driven - energy).sqrt();
        assert!((held.at(s) - expected).abs() < 0.02 * expected, "{} not {expected}", held.at(s));
        assert!(held.at(s) < free.at(s), "at {s} m");
    }
    assert!((held.at(end + 10.0) - miss.allowed(0)).abs() < 1e-9);
    // Behind it nothing changes.
    assert_eq!(held.at(end + 200.0), free.at(end + 200.0));
}

/// A lap that lost speed faster than brakes and drag take it, as in a bend, raises the speed before a
/// place that may now be faster just as much.
#[test]
fn before_a_faster_bend_the_car_brakes_as_a_driven_lap_did() {
    let a = 18.0;
    let end = BRAKING_FROM + (FAST * FAST - SLOW * SLOW) / (2.0 * a);
    let free = envelope(&lap(a), &[]);
    let after = free.at(end + 10.0);
    assert!(after > 1.3 * SLOW, "{after}");
    for s in [end - 25.0, end - 20.0, end - 15.0] {
        let expected = (after * after + 2.0 * a * (end - s)).sqrt();
        assert!((free.at(s) - expected).abs() < 0.02 * expected, "{} not {expected}", free.at(s));
    }
}

/// A lap that braked gently leaves it to the brakes of the car and its drag.
#[test]
fn before_a_near_miss_the_car_brakes_as_hard_as_it_can() {
    let lap = lap(6.0);
    let car = CarParams::builtin("iac").unwrap();
    let end = BRAKING_FROM + (FAST * FAST - SLOW * SLOW) / 12.0;
    let miss = NearMiss { lap: 0, s: [end, end + 20.0], speed: SLOW, used: 1.0 };
    let held = envelope(&lap, &[miss]);
    for s in [end - 50.0, end - 35.0, end - 20.0] {
        let (here, after) = (held.at(s), held.at(s + 10.0));
        let mean = 0.5 * (here + after);
        let drag = 0.5 * car.rho * car.cd * car.area * mean * mean / car.mass;
        let expected = 2.0 * 10.0 * (-car.a_min + drag);
        let lost = here * here - after * after;
        assert!((lost - expected).abs() < 0.02 * expected, "{lost} not {expected}");
    }
}
