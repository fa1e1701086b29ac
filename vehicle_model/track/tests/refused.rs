//! What is no track is refused, with the place and what was expected.

#![allow(clippy::unwrap_used)]

mod common;

use common::{ellipse, peanut};
use std::f64::consts::{FRAC_PI_2, PI};
use track::{Segment, Track, TrackError, TrackPoint};

fn refused(segments: &[Segment], width: f64) -> TrackError {
    Track::from_segments("bad", segments, width, width).unwrap_err()
}

fn refused_points(points: &[TrackPoint]) -> TrackError {
    Track::from_points("bad", points).unwrap_err()
}

/// A closed curve through n points.
fn curve(n: usize, width: f64, xy: impl Fn(f64) -> (f64, f64)) -> Vec<TrackPoint> {
    (0..n)
        .map(|i| {
            let (x, y) = xy(2.0 * PI * i as f64 / n as f64);
            TrackPoint { x, y, width_left: width, width_right: width }
        })
        .collect()
}

#[test]
fn an_open_track() {
    let half = [Segment::straight(50.0), Segment::arc(20.0, PI)];
    let segments = [half[0], half[1], Segment::straight(50.5), half[1]];
    let error = refused(&segments, 4.0);
    let TrackError::Open { end, gap, turn, .. } = error else { panic!("{error}") };
    assert!((gap - 0.5).abs() < 1e-9 && turn.abs() < 1e-9 && (end.x + 0.5).abs() < 1e-9);
    let text = error.to_string();
    assert!(text.starts_with("open track: the end at s = 226.164 m (x = -0.500"), "{text}");

    let segments = [half[0], half[1], half[0], Segment::arc(20.0, PI - 0.1)];
    let error = refused(&segments, 4.0);
    assert!(matches!(error, TrackError::Open { turn, .. } if (turn + 0.1).abs() < 1e-9), "{error}");
}

#[test]
fn an_open_list_of_points() {
    let points = ellipse(90);
    let error = refused_points(&points[..80]);
    let TrackError::Gap { end, gap, limit } = error else { panic!("{error}") };
    assert!(gap > limit && (end.x, end.y) == (points[79].x, points[79].y));
    assert!(error.to_string().starts_with("open track: the last point at s = "), "{error}");
    assert!(Track::from_points("two points missing", &points[..88]).is_ok());
}

#[test]
fn a_track_that_crosses_itself_at_a_shallow_angle() {
    let eight = |y: f64| move |t: f64| (80.0 * t.cos(), y * (2.0 * t).sin());
    let error = refused_points(&curve(120, 4.0, eight(10.0)));
    let TrackError::Crossing { first, second } = error else { panic!("{error}") };
    for place in [first, second] {
        assert!(place.x.hypot(place.y) < 0.1, "{place}");
    }
    assert!(error.to_string().starts_with("the centre line crosses itself: s = "), "{error}");
    // Steeper, it is a bridge; a small loop is none, however steep.
    assert!(Track::from_points("bridge", &curve(120, 4.0, eight(60.0))).is_ok());
    let mut points = curve(120, 4.0, |t| (80.0 * t.cos(), 60.0 * t.sin()));
    points.swap(40, 41);
    let error = refused_points(&points);
    assert!(matches!(error, TrackError::TooCoarse { .. } | TrackError::Crossing { .. }), "{error}");
}

#[test]
fn a_track_that_runs_back_over_itself() {
    let straight = Segment::straight(40.0);
    let corner = Segment::arc(10.0, FRAC_PI_2);
    let lap = [straight, corner].repeat(4);
    let twice = [lap.clone(), lap].concat();
    let error = refused(&twice, 4.0);
    assert!(matches!(error, TrackError::Crossing { .. }), "{error}");
}

#[test]
fn a_track_that_passes_near_itself_is_none_of_these() {
    let (track, middle) = peanut();
    let other = track.project(track.position(middle).0, track.position(middle).1 + 1.0, None);
    assert!(track.wrap(other.s - middle) > 10.0, "the branches lie side by side: {other:?}");
}

#[test]
fn a_bend_narrower_than_its_inner_width() {
    let straight = Segment::straight(50.0);
    let error = refused(&[straight, Segment::arc(4.0, PI)].repeat(2), 4.5);
    let TrackError::TooTight { place, radius, width } = error else { panic!("{error}") };
    assert!((place.s - 50.0).abs() < 1e-9 && (radius - 4.0).abs() < 1e-9 && width == 4.5);
    let text = "too narrow a bend at s = 50.000 m (x = 50.000, y = 0.000): its radius is 4.000 m, \
                expected more than the inner width of 4.500 m; smooth the line more, or make the \
                track narrower there";
    assert_eq!(error.to_string(), text);
    // The outer side may be as wide as it likes.
    let bend = Segment::arc(4.0, PI).with_widths(3.9, 30.0);
    assert!(Track::from_segments("wide outside", &[straight, bend].repeat(2), 3.0, 30.0).is_ok());

    // An ellipse has its least radius b^2 / a = 4.05 m at both ends.
    let error = refused_points(&curve(400, 4.2, |t| (20.0 * t.cos(), 9.0 * t.sin())));
    let TrackError::TooTight { place, radius, .. } = error else { panic!("{error}") };
    assert!((place.x.abs() - 20.0).abs() < 0.1 && (radius - 4.05).abs() < 0.01, "{error}");
}

#[test]
fn points_too_coarse_for_their_bend() {
    let mut points = curve(60, 1.0, |t| (20.0 * t.cos(), 10.0 * t.sin()));
    points.drain(27..34);
    let error = refused_points(&points);
    let TrackError::TooCoarse { place, turn, limit, .. } = error else { panic!("{error}") };
    assert!(place.x < -15.0 && turn > limit, "{error}");
    assert!(error.to_string().starts_with("too coarse at s = "), "{error}");
    // Nor does the spline silently drive back along itself.
    let spike = TrackPoint { x: 21.0, ..points[5] };
    points = curve(60, 1.0, |t| (20.0 * t.cos(), 10.0 * t.sin()));
    points.insert(8, spike);
    assert!(matches!(refused_points(&points), TrackError::TooCoarse { .. }));
}

#[test]
fn too_few_and_repeated_points() {
    let error = refused_points(&ellipse(7));
    assert_eq!(error.to_string(), "points: found 7, expected at least 8");
    assert!(
        Track::from_points("octagon", &curve(8, 2.0, |t| (t.cos() * 9.0, t.sin() * 9.0))).is_ok()
    );
    let mut points = ellipse(90);
    points.insert(4, points[3]);
    let error = refused_points(&points);
    let TrackError::Duplicate { ref item, place } = error else { panic!("{error}") };
    assert_eq!((item.as_str(), place.x), ("point 5", points[3].x));
    assert!(matches!(refused_points(&[]), TrackError::TooFew { found: 0, .. }));
    assert!(matches!(refused(&[], 1.0), TrackError::TooFew { what: "segments", found: 0, .. }));
}

#[test]
fn numbers_out_of_range() {
    let good = [Segment::straight(50.0), Segment::arc(20.0, PI)].repeat(2);
    for (i, segment, width, text) in [
        (0, Segment::straight(-5.0), 4.0, "segment 1: length is -5, expected a length above 0 m"),
        (0, Segment::straight(f64::NAN), 4.0, "segment 1: length is NaN, expected a length"),
        (1, Segment::arc(0.0, PI), 4.0, "segment 2: length is 0, expected a length above 0 m"),
        (1, Segment::arc(20.0, 7.0), 4.0, "segment 2: angle is 7, expected less than a full turn"),
        (0, good[0], -1.0, "segment 1: width_left is -1, expected a width above 0 m"),
        (0, good[0], f64::INFINITY, "segment 1: width_left is inf, expected a width above 0 m"),
    ] {
        let mut segments = good.clone();
        segments[i] = segment;
        let error = refused(&segments, width).to_string();
        assert!(error.starts_with(text), "{error}");
    }
    let mut points = ellipse(90);
    points[2].y = f64::NAN;
    let text = "point 3: y is NaN, expected metres from -1e8 to 1e8";
    assert_eq!(refused_points(&points).to_string(), text);
    let mut points = ellipse(90);
    points[2].width_right = 0.0;
    let text = "point 3: width_right is 0, expected a width above 0 m, at most 1e8 m";
    assert_eq!(refused_points(&points).to_string(), text);
}
