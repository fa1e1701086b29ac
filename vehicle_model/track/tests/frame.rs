//! Global to Frenet and back, on every kind of track.

mod common;

use common::{all, peanut, tapered};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use std::f64::consts::PI;
use track::{GlobalState, State, Track, wrap_angle};

/// Bar of the round trip.
const TOLERANCE: f64 = 1e-9;

/// The shorter way round from b to a.
fn apart(track: &Track, a: f64, b: f64) -> f64 {
    let d = track.wrap(a - b);
    d.min(track.length() - d)
}

/// A state between the edges, and its progress.
fn draw(track: &Track, rng: &mut Pcg64Mcg) -> State {
    let s = rng.random_range(0.0..track.length());
    let e_y = rng.random_range(-track.width_right(s)..track.width_left(s));
    let e_psi = rng.random_range(-PI..PI);
    State { v_x: 3.0, v_y: -0.2, omega_z: 0.7, e_psi, s, e_y }
}

#[test]
fn a_state_survives_the_round_trip_cold_and_warm() {
    let mut rng = Pcg64Mcg::seed_from_u64(1);
    for track in all() {
        for _ in 0..2000 {
            let x = draw(&track, &mut rng);
            let g = track.to_global(&x);
            // Up to the way a car makes in a step, either direction, in any lap.
            let step = rng.random_range(-0.02..0.02) * track.length();
            let lap = f64::from(rng.random_range(-2_i32..3)) * track.length();
            for hint in [None, Some(x.s + step), Some(x.s + step + lap)] {
                let back = track.to_frenet(&g, hint);
                let what = format!("{} {x:?} hint {hint:?}: {back:?}", track.name());
                assert!(apart(&track, back.s, x.s) < TOLERANCE, "{what}");
                assert!((back.e_y - x.e_y).abs() < TOLERANCE, "{what}");
                assert!(wrap_angle(back.e_psi - x.e_psi).abs() < TOLERANCE, "{what}");
                assert!(back.e_psi > -PI && back.e_psi <= PI, "{what}");
                assert!((0.0..track.length()).contains(&back.s), "{what}");
                assert_eq!((back.v_x, back.v_y, back.omega_z), (x.v_x, x.v_y, x.omega_z));
            }
        }
    }
}

#[test]
fn a_projection_is_the_nearest_point_of_a_fine_polygon() {
    let mut rng = Pcg64Mcg::seed_from_u64(2);
    for track in all() {
        let n = 20_000;
        let step = track.length() / f64::from(n);
        let line: Vec<(f64, f64)> = (0..n).map(|i| track.position(step * f64::from(i))).collect();
        for _ in 0..100 {
            // Beyond the edges too: anywhere in the box around the track.
            let (x, y) = line[rng.random_range(0..line.len())];
            let x = x + rng.random_range(-0.3..0.3) * track.length();
            let y = y + rng.random_range(-0.3..0.3) * track.length();
            let nearest =
                line.iter().map(|p| (x - p.0).hypot(y - p.1)).fold(f64::INFINITY, f64::min);
            let foot = track.project(x, y, None);
            let what = format!("{}: ({x}, {y}) gave {foot:?}, {nearest}", track.name());
            assert!(foot.e_y.abs() <= nearest + 1e-9, "{what}");
            assert!(foot.e_y.abs() >= nearest - step, "{what}");
            assert!((foot.heading - track.heading(foot.s)).abs() < TOLERANCE, "{what}");
        }
    }
}

#[test]
fn a_warm_projection_stays_on_its_branch_of_a_waist() {
    let (track, s) = peanut();
    // 0.6 m to the side in the middle of the waist: past the edge, nearer to the other branch.
    let x = State { s, e_y: 0.6, ..State::default() };
    let g = track.to_global(&x);
    for hint in [s - 0.5, s, s + 0.5] {
        let warm = track.project(g.x, g.y, Some(hint));
        assert!((warm.e_y - 0.6).abs() < TOLERANCE, "{warm:?}");
        assert!((warm.s - s).abs() < TOLERANCE, "{warm:?}");
    }
    let cold = track.project(g.x, g.y, None);
    assert!((cold.e_y - 0.4).abs() < TOLERANCE, "{cold:?}");
    assert!(apart(&track, cold.s, s) > 10.0, "{cold:?}");
}

#[test]
fn a_wrong_hint_does_not_mislead() {
    // A car put back on the track elsewhere: far along the lap, and just across the infield. In
    // a waist narrower than the track is wide the hint is all there is.
    for track in all().into_iter().filter(|track| track.name() != "peanut") {
        for k in 0..50 {
            let s = track.length() * f64::from(k) / 50.0;
            let g = track.to_global(&State { s, ..State::default() });
            for part in [0.3, 0.5, 0.7] {
                let x = track.to_frenet(&g, Some(s + part * track.length()));
                assert!(apart(&track, x.s, s) < TOLERANCE, "{} {s} {x:?}", track.name());
            }
        }
    }
}

#[test]
fn a_projection_is_continuous_over_the_line() {
    for track in all() {
        let mut hint = track.length() - 0.05;
        for k in -50..50 {
            let s = f64::from(k) * 1e-3;
            let g = track.to_global(&State { s, e_y: 0.1, ..State::default() });
            let foot = track.project(g.x, g.y, Some(hint));
            assert!(apart(&track, foot.s, s) < TOLERANCE, "{} {k} {foot:?}", track.name());
            assert!((0.0..track.length()).contains(&foot.s));
            assert!((foot.e_y - 0.1).abs() < TOLERANCE);
            hint = foot.s;
        }
    }
}

#[test]
fn progress_wraps_in_every_lap() {
    for track in all() {
        let length = track.length();
        for (s, wrapped) in [(0.0, 0.0), (length, 0.0), (-length, 0.0), (2.0 * length, 0.0)] {
            assert_eq!(track.wrap(s), wrapped, "{s}");
        }
        for s in [-1e-300, -1e-17, f64::NAN, f64::INFINITY] {
            assert_eq!(track.wrap(s), 0.0, "{s}");
        }
        let s = 0.37 * length;
        for lap in [-2.0, -1.0, 1.0, 5.0] {
            let there = s + lap * length;
            assert!((track.wrap(there) - s).abs() < TOLERANCE);
            assert!((track.kappa(there) - track.kappa(s)).abs() < TOLERANCE);
            assert!((track.width_left(there) - track.width_left(s)).abs() < TOLERANCE);
            assert!((track.width_right(there) - track.width_right(s)).abs() < TOLERANCE);
        }
    }
}

#[test]
fn curvature_is_the_derivative_of_heading_and_heading_of_position() {
    let d = 1e-5;
    for track in all() {
        for k in 0..997 {
            let s = d + (track.length() - 2.0 * d) * f64::from(k) / 997.0;
            let ((x_0, y_0), (x_1, y_1)) = (track.position(s - d), track.position(s + d));
            let speed = (x_1 - x_0).hypot(y_1 - y_0) / (2.0 * d);
            assert!((speed - 1.0).abs() < 2e-6, "{} {s}: |r'| = {speed}", track.name());
            let along = (y_1 - y_0).atan2(x_1 - x_0);
            assert!(wrap_angle(along - track.heading(s)).abs() < 1e-6, "{} {s}", track.name());
            let kappa = (track.heading(s + d) - track.heading(s - d)) / (2.0 * d);
            let (low, high) = (track.kappa(s - d), track.kappa(s + d));
            let slack = 1e-5 * track.max_abs_kappa();
            assert!(kappa > low.min(high) - slack, "{} {s}: {kappa} {low} {high}", track.name());
            assert!(kappa < low.max(high) + slack, "{} {s}: {kappa} {low} {high}", track.name());
            assert!(low.abs() <= track.max_abs_kappa() * (1.0 + 1e-6));
        }
    }
}

#[test]
fn curvature_jumps_where_a_segment_begins() {
    let track = Track::builtin("l").unwrap();
    let arc = 1.0 / 1.1525;
    assert_eq!(track.kappa(2.251_f64.next_down()), 0.0);
    assert_eq!(track.kappa(2.251), arc);
    assert_eq!(track.kappa(2.252 - track.length()), arc);
    assert_eq!(track.max_abs_kappa(), 1.0 / 1.0201675);
}

#[test]
fn widths_vary_along_a_taper() {
    let track = tapered();
    for (s, left, right) in [(0.0, 3.0, 4.0), (40.0, 4.5, 4.5), (60.0, 5.25, 4.75)] {
        assert!((track.width_left(s) - left).abs() < 1e-12, "{s}");
        assert!((track.width_right(s) - right).abs() < 1e-12, "{s}");
    }
    assert_eq!((track.width_left(100.0), track.width_right(100.0)), (6.0, 5.0));
    assert_eq!(track.narrowest(), 7.0);
    let end = track.length() - 1.0;
    assert_eq!((track.width_left(end), track.width_right(end)), (3.0, 4.0));
}

#[test]
fn nothing_panics_on_what_is_no_number() {
    for track in all() {
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            for hint in [None, Some(1.0), Some(bad)] {
                let foot = track.project(bad, 1.0, hint);
                assert!((0.0..track.length()).contains(&foot.s), "{foot:?}");
                assert!(!foot.e_y.is_finite(), "{foot:?}");
            }
            assert!(track.project(0.1, 0.1, Some(bad)).e_y.is_finite());
            assert!(track.kappa(bad).is_finite());
            assert!(track.width_left(bad).is_finite());
            let g = GlobalState { x: bad, ..GlobalState::default() };
            assert!(!track.to_frenet(&g, Some(0.0)).is_finite());
        }
    }
}
