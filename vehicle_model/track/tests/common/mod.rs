//! Tracks that several tests drive on.

#![allow(dead_code, unreachable_pub, clippy::unwrap_used, clippy::expect_used)]

use std::f64::consts::{PI, TAU};
use track::{Segment, Track, TrackPoint};

/// Half axes of the ellipse [m].
pub const ELLIPSE: (f64, f64) = (60.0, 35.0);

/// n points of an ellipse, counter-clockwise, with widths that vary along it.
pub fn ellipse(n: usize) -> Vec<TrackPoint> {
    (0..n)
        .map(|i| {
            let angle = TAU * i as f64 / n as f64;
            TrackPoint {
                x: ELLIPSE.0 * angle.cos(),
                y: ELLIPSE.1 * angle.sin(),
                width_left: 4.0 + angle.cos(),
                width_right: 5.0 + 0.5 * (2.0 * angle).sin(),
            }
        })
        .collect()
}

/// The same points driven the other way round: left becomes right.
pub fn clockwise(points: &[TrackPoint]) -> Vec<TrackPoint> {
    let swap =
        |p: &TrackPoint| TrackPoint { width_left: p.width_right, width_right: p.width_left, ..*p };
    points.iter().rev().map(swap).collect()
}

/// Two lobes joined by a waist where the two directions of driving pass each other with 1 m
/// between their centre lines and 0.1 m between their edges. It starts at the waist, whose middle
/// is at the progress given with it; the other branch is to the left.
pub fn peanut() -> (Track, f64) {
    let (radius, half_gap) = (5.0_f64, 0.5);
    let h = radius + half_gap;
    let d = ((2.0 * radius).powi(2) - h * h).sqrt();
    let lobe = 2.0 * (PI - (h / d).atan());
    let waist = lobe - PI;
    let (lobe, waist) = (Segment::arc(radius, lobe), Segment::arc(-radius, waist));
    let track = Track::from_segments("peanut", &[waist, lobe, waist, lobe], 0.45, 0.45).unwrap();
    (track, 0.5 * waist.length)
}

/// An oval of two half circles with a taper on its straights.
pub fn tapered() -> Track {
    let straight = Segment::straight(80.0);
    let segments = [
        straight.with_taper((3.0, 4.0), (6.0, 5.0)),
        Segment::arc(25.0, PI).with_widths(6.0, 5.0),
        straight.with_taper((6.0, 5.0), (3.0, 4.0)),
        Segment::arc(25.0, PI),
    ];
    Track::from_segments("tapered", &segments, 3.0, 4.0).unwrap()
}

/// The tracks every promise is held on.
pub fn all() -> Vec<Track> {
    let mut tracks: Vec<Track> =
        Track::builtin_names().map(|name| Track::builtin(name).expect("ships")).collect();
    assert_eq!(tracks.len(), 2);
    tracks.push(peanut().0);
    tracks.push(tapered());
    tracks.push(Track::from_points("ellipse", &ellipse(90)).unwrap());
    tracks.push(Track::from_points("ellipse back", &clockwise(&ellipse(90))).unwrap());
    tracks
}
