//! The tracks that ship: they close; the road course can be driven and keeps clear of itself.

#![allow(clippy::unwrap_used)]

use track::Track;

/// Distance along the lap below which two places belong to the same corner [m].
const SAME_CORNER: f64 = 120.0;

#[test]
fn the_l_track_is_the_one_of_the_study() {
    let track = Track::builtin("l").unwrap();
    assert!((track.length() - 17.461412207630154).abs() < 1e-14);
    let end = track.length().next_down();
    let (x, y) = track.position(end);
    assert!(x.hypot(y) < 1e-14, "the lap misses its start by {:e} m", x.hypot(y));
    assert!((track.heading(end) - 2.0 * std::f64::consts::PI).abs() < 1e-14);
    // By hand: after the first half circle and the straight behind it; after the second one.
    let half = std::f64::consts::PI;
    for (s, x, y, psi) in [
        (2.251 + 1.1525 * half, 2.251, 2.305, half),
        (2.251 + 1.1525 * half + 0.901, 1.35, 2.305, half),
        (track.length() - 0.905905, -0.905905, 0.0, 2.0 * half),
        (track.length() - 0.905905 - 1.2206275 * half / 2.0, -2.1265325, 1.2206275, 1.5 * half),
    ] {
        let (x_s, y_s) = track.position(s);
        assert!((x_s - x).hypot(y_s - y) < 1e-14, "{s}: {x_s} {y_s}");
        assert!((track.heading(s) - psi).abs() < 1e-14, "{s}");
    }
    assert_eq!((track.width_left(9.0), track.width_right(9.0)), (0.55, 0.55));
}

#[test]
fn the_road_course_closes_and_is_drivable() {
    let track = Track::builtin("road_course").unwrap();
    assert!((track.length() - 2836.65).abs() < 0.01, "{}", track.length());
    let end = track.length().next_down();
    let (x, y) = track.position(end);
    assert!(x.hypot(y) < 1e-9, "the lap misses its start by {:e} m", x.hypot(y));
    let turn = track.heading(end) + 2.0 * std::f64::consts::PI;
    assert!(turn.abs() < 1e-12, "{turn:e}");
    // The full-size car: tan(0.314 rad) / 2.9718 m, with room for correction.
    let full_lock = 0.314_f64.tan() / 2.9718;
    assert!(track.max_abs_kappa() < 0.5 * full_lock, "{}", track.max_abs_kappa());
    for k in 0..100 {
        let s = track.length() * f64::from(k) / 100.0;
        assert_eq!(track.width_left(s) + track.width_right(s), 9.0);
    }
}

#[test]
fn the_road_course_keeps_clear_of_itself() {
    let track = Track::builtin("road_course").unwrap();
    let step = 2.0;
    let places: Vec<(f64, f64, f64)> = (0..1418)
        .map(|k| {
            let s = step * f64::from(k);
            (s, track.position(s).0, track.position(s).1)
        })
        .collect();
    for a in &places {
        for b in &places {
            let along = track.wrap(b.0 - a.0).min(track.wrap(a.0 - b.0));
            if along > SAME_CORNER {
                let clear = (a.1 - b.1).hypot(a.2 - b.2);
                assert!(clear > 30.0, "{a:?} and {b:?} are {clear} m apart");
            }
        }
    }
}
