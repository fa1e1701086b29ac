//! Tracks through points against curves whose length and curvature are known.

mod common;

use common::{ELLIPSE, clockwise, ellipse};
use std::f64::consts::TAU;
use track::{Track, TrackPoint};

/// Length of the ellipse by the arithmetic-geometric mean (Gauss).
fn perimeter(a: f64, b: f64) -> f64 {
    let (mut x, mut y, mut sum, mut weight) = (a, b, 0.5 * (a * a + b * b), 0.25);
    for _ in 0..8 {
        let c = x - y;
        sum -= weight * c * c;
        weight *= 2.0;
        (x, y) = (0.5 * (x + y), (x * y).sqrt());
    }
    TAU * sum / x
}

/// Curvature a b / (a^2 sin^2 + b^2 cos^2)^(3/2) of the ellipse at the point nearest (x, y).
fn ellipse_kappa(x: f64, y: f64) -> f64 {
    let (a, b) = ELLIPSE;
    let angle = (y / b).atan2(x / a);
    a * b / ((a * angle.sin()).powi(2) + (b * angle.cos()).powi(2)).powf(1.5)
}

#[test]
fn an_ellipse_has_its_length_and_curvature() {
    for (n, length_error, kappa_error) in [(60, 3e-5, 1e-2), (120, 2e-6, 3e-3), (480, 1e-8, 2e-4)] {
        let track = Track::from_points("ellipse", &ellipse(n)).unwrap();
        let exact = perimeter(ELLIPSE.0, ELLIPSE.1);
        let error = (track.length() / exact - 1.0).abs();
        assert!(error < length_error, "{n} points: length {error:e}");
        let mut worst: f64 = 0.0;
        for k in 0..3000 {
            let s = track.length() * f64::from(k) / 3000.0;
            let (x, y) = track.position(s);
            worst = worst.max((track.kappa(s) / ellipse_kappa(x, y) - 1.0).abs());
        }
        assert!(worst < kappa_error, "{n} points: curvature {worst:e}");
        let most = ELLIPSE.0 / ELLIPSE.1.powi(2);
        assert!((track.max_abs_kappa() / most - 1.0).abs() < kappa_error);
    }
}

#[test]
fn the_other_direction_mirrors_curvature_and_widths() {
    let forth = Track::from_points("forth", &ellipse(120)).unwrap();
    let back = Track::from_points("back", &clockwise(&ellipse(120))).unwrap();
    assert!((forth.length() - back.length()).abs() < 1e-6);
    for k in 0..500 {
        let s = forth.length() * f64::from(k) / 500.0;
        let (x, y) = forth.position(s);
        let there = back.project(x, y, None);
        assert!(there.e_y.abs() < 1e-5, "{there:?}");
        assert!((forth.kappa(s) + back.kappa(there.s)).abs() < 5e-5);
        assert!((forth.width_left(s) - back.width_right(there.s)).abs() < 1e-4);
        assert!((forth.width_right(s) - back.width_left(there.s)).abs() < 1e-4);
    }
}

#[test]
fn points_lie_on_the_track_with_their_widths() {
    let points = ellipse(90);
    let track = Track::from_points("ellipse", &points).unwrap();
    for p in &points {
        let foot = track.project(p.x, p.y, None);
        assert!(foot.e_y.abs() < 1e-6, "{foot:?}");
        assert!((track.width_left(foot.s) - p.width_left).abs() < 1e-5);
        assert!((track.width_right(foot.s) - p.width_right).abs() < 1e-5);
    }
}

#[test]
fn uneven_spacing_does_not_bend_a_circle() {
    let radius = 30.0;
    let points: Vec<TrackPoint> = (0..60)
        .map(|i| {
            let even = f64::from(i) / 60.0;
            let angle = TAU * (even + 0.1 * (TAU * even).sin() / TAU);
            let (x, y) = (radius * angle.cos(), radius * angle.sin());
            TrackPoint { x, y, width_left: 4.0, width_right: 4.0 }
        })
        .collect();
    let track = Track::from_points("circle", &points).unwrap();
    assert!((track.length() / (TAU * radius) - 1.0).abs() < 1e-5, "{}", track.length());
    for k in 0..1000 {
        let kappa = track.kappa(track.length() * f64::from(k) / 1000.0);
        assert!((kappa * radius - 1.0).abs() < 5e-3, "{kappa}");
    }
}

#[test]
fn a_closed_list_is_the_same_track_as_an_open_one() {
    let open = ellipse(90);
    let mut closed = open.clone();
    closed.push(open[0]);
    assert_eq!(
        Track::from_points("ellipse", &open).unwrap(),
        Track::from_points("ellipse", &closed).unwrap()
    );
}
