//! Random tracks fit their car, and a written track is the same when it is read.

#![allow(clippy::unwrap_used)]

#[path = "../track/tests/common/mod.rs"]
mod common;

use common::ellipse;
use vehicle_model::track::{ImportOptions, points_to_toml, random};
use vehicle_model::{CarParams, Track};

#[test]
fn every_car_gets_tracks_it_can_drive() {
    for name in CarParams::builtin_names() {
        let car = CarParams::builtin(name).unwrap();
        let lock = car.wheelbase() / car.delta_max.tan();
        let (mut left, mut right, mut tight) = (0, 0, 0);
        for seed in 0..100 {
            let track = random(seed, &car).unwrap();
            let radius = 1.0 / track.max_abs_kappa();
            assert!(radius > 1.5 * lock, "{name} {seed}: {radius} {lock}");
            assert!(track.narrowest() > 3.0 * car.width, "{name} {seed}");
            // No place of the track, widths included, belongs to two places of the line.
            let (mut length, mut turned) = (0.0, 0.0_f64);
            while length < track.length() {
                let (x, y) = track.position(length);
                let heading = track.heading(length);
                turned = turned.max(turned_within(&track, length, 6.0 * radius));
                for (side, width) in
                    [(1.0, track.width_left(length)), (-1.0, -track.width_right(length))]
                {
                    let e_y = 0.99 * width;
                    let found =
                        track.project(x - e_y * heading.sin(), y + e_y * heading.cos(), None);
                    let apart = (found.s - length).rem_euclid(track.length());
                    let apart = apart.min(track.length() - apart);
                    assert!(apart < 1e-6 * track.length(), "{name} {seed} {side} at {length}");
                }
                length += 0.01 * track.length();
            }
            tight += usize::from(turned > 2.0);
            let end = track.heading(track.length().next_down());
            if end > 0.0 { left += 1 } else { right += 1 }
        }
        assert!(left > 30 && right > 30 && tight > 25, "{name} {left} {right} {tight}");
    }
}

/// Turn of the line within a distance.
fn turned_within(track: &Track, s: f64, distance: f64) -> f64 {
    let end = (s + distance).min(track.length().next_down());
    (track.heading(end) - track.heading(s)).abs()
}

#[test]
fn the_seed_decides() {
    let car = CarParams::builtin("barc").unwrap();
    let [a, again, b] = [7, 7, 8].map(|seed| random(seed, &car).unwrap());
    assert_eq!(a, again);
    assert_ne!(a.fingerprint(), b.fingerprint());
}

#[test]
fn a_written_track_is_the_same_track() {
    let mut tracks: Vec<Track> =
        Track::builtin_names().map(|name| Track::builtin(name).unwrap()).collect();
    let car = CarParams::builtin("kart").unwrap();
    tracks.extend((0..20).map(|seed| random(seed, &car).unwrap()));
    for track in tracks {
        let text = track.to_toml().unwrap();
        let read = Track::from_toml(&text).unwrap();
        assert_eq!(read.fingerprint(), track.fingerprint(), "{text}");
        assert_eq!(read, track);
    }
    let points = ellipse(90);
    let read = Track::from_toml(&points_to_toml("e", &points, None)).unwrap();
    assert_eq!(read, Track::from_points("e", &points).unwrap());
    // Smoothed and cut, written and read again.
    let mut csv = String::new();
    for (i, p) in points.iter().enumerate() {
        let off = if i % 2 == 0 { 0.05 } else { -0.05 };
        csv.push_str(&format!("{},{},{},{}\n", p.x, p.y + off, 30.0, 30.0));
    }
    let imported = Track::import("e.csv", &csv, &ImportOptions::default()).unwrap();
    assert!(imported.changes.len() > 1, "{:?}", imported.changes);
    assert_eq!(Track::from_toml(&imported.to_toml()).unwrap(), imported.track);
}
