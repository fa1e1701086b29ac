//! A track that crosses itself on a bridge.

#![allow(clippy::unwrap_used)]

use std::f64::consts::PI;
use track::{Segment, State, Track};

/// A figure of eight of two three-quarter circles.
fn eight() -> Track {
    let arm = 30.0;
    let segments = [
        Segment::straight(arm - 10.0),
        Segment::arc(arm, 1.5 * PI),
        Segment::straight(2.0 * arm),
        Segment::arc(-arm, 1.5 * PI),
        Segment::straight(arm + 10.0),
    ];
    Track::from_segments("eight", &segments, 4.0, 4.0).unwrap()
}

#[test]
fn both_passages_are_known() {
    let track = eight();
    let [(first, second)] = track.bridges() else { panic!("{:?}", track.bridges()) };
    for place in [first, second] {
        assert!((place.x + 10.0).abs() < 1e-9 && place.y.abs() < 1e-9, "{place}");
    }
    assert!((first.s - (20.0 + 45.0 * PI + 30.0)).abs() < 1e-9, "{first}");
    assert!((second.s - (110.0 + 90.0 * PI)).abs() < 1e-9, "{second}");
    assert_eq!(Track::builtin("l").unwrap().bridges(), []);
}

#[test]
fn a_car_is_found_on_its_own_passage_from_cold_and_while_it_drives() {
    let track = eight();
    let lap = |from: f64, to: f64| {
        let apart = track.wrap(from - to);
        apart.min(track.length() - apart)
    };
    let mut last = None;
    for k in 0..4000 {
        // Two laps, from side to side and with a drifting heading.
        let s = 2.0 * track.length() * f64::from(k) / 4000.0;
        let e_y = 3.8 * (0.11 * s).sin();
        let x = State { s, e_y, e_psi: 0.6 * (0.07 * s).cos(), ..State::default() };
        let global = track.to_global(&x);
        let cold = track.to_frenet(&global, None);
        assert!(lap(cold.s, s) < 1e-6 && (cold.e_y - e_y).abs() < 1e-6, "{s}: {cold:?}");
        let warm = track.to_frenet(&global, last);
        assert!(lap(warm.s, s) < 1e-6 && (warm.e_psi - x.e_psi).abs() < 1e-6, "{s}: {warm:?}");
        last = Some(warm.s);
    }
}
