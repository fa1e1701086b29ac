//! What a car cannot drive is named with its place.

#![allow(clippy::unwrap_used)]

use std::f64::consts::PI;
use vehicle_model::track::random;
use vehicle_model::{CarParams, Segment, Track, TrackError};

/// A stadium with straights of 30 m and bends of this radius; one width for both sides.
fn stadium(radius: f64, width: f64) -> Track {
    let half = [Segment::straight(30.0), Segment::arc(radius, PI)];
    Track::from_segments("stadium", &half.repeat(2), width, width).unwrap()
}

#[test]
fn cars_fit_the_tracks_of_their_scale() {
    for name in CarParams::builtin_names() {
        let car = CarParams::builtin(name).unwrap();
        for seed in 0..10 {
            assert_eq!(random(seed, &car).unwrap().problems_for(&car), [], "{name} {seed}");
        }
    }
    let barc = CarParams::builtin("barc").unwrap();
    let [l, road] = ["l", "road_course"].map(|name| Track::builtin(name).unwrap());
    assert_eq!(l.problems_for(&barc), []);
    assert_eq!(road.problems_for(&CarParams::builtin("iac").unwrap()), []);
}

#[test]
fn a_narrow_place_is_named() {
    let car = CarParams::builtin("kart").unwrap();
    let half = [
        Segment::straight(30.0).with_taper((3.0, 3.0), (0.4 * car.width, 0.5 * car.width)),
        Segment::arc(10.0, PI),
    ];
    let track = Track::from_segments("narrow", &half.repeat(2), 3.0, 3.0).unwrap();
    let problems = track.problems_for(&car);
    let [TrackError::TooNarrow { place, width, body }] = problems[..] else {
        panic!("{problems:?}")
    };
    assert!((29.0..30.1).contains(&place.s.rem_euclid(30.0 + 10.0 * PI)), "{place}");
    assert!((width - 0.9 * car.width).abs() < 0.06 && body == car.width, "{width}");
    assert!(problems[0].to_string().contains("unit of the widths"), "{}", problems[0]);
}

#[test]
fn a_hairpin_counts_on_its_outer_line_and_a_short_bend_on_the_line_that_cuts_it() {
    let car = CarParams::builtin("iac").unwrap();
    let lock = car.wheelbase() / car.delta_max.tan();
    // Half a turn: the outer edge, less half the body, decides.
    let room = 2.0;
    let radius = lock - room + 0.5 * car.width;
    let taken = stadium(radius + 0.15, room).problems_for(&car);
    assert_eq!(taken, []);
    let refused = stadium(radius - 0.15, room).problems_for(&car);
    let [TrackError::TooSharp { radius, lock: found, .. }] = refused[..] else {
        panic!("{refused:?}")
    };
    assert!((found - lock).abs() < 1e-12 && (radius - lock + 0.15).abs() < 0.1, "{radius}");
    // Four quarter turns of the same radius are cut.
    let quarter = [Segment::straight(40.0), Segment::arc(0.5 * lock, 0.5 * PI)];
    let square = |width: f64| {
        Track::from_segments("square", &quarter.repeat(4), width, width).unwrap().problems_for(&car)
    };
    assert!(square(0.5 * car.width + 0.5).len() == 1);
    assert_eq!(square(0.5 * car.width + 1.5), []);
}
