//! The L track against the numbers of an independent implementation.

#![allow(clippy::unwrap_used)]

use std::path::PathBuf;
use vehicle_model::track::{Segment, wrap_angle};
use vehicle_model::{GlobalState, State, Track};

/// Bar of the comparison; the implementations agree much closer than this.
const TOLERANCE: f64 = 1e-9;

fn read(name: &str) -> String {
    let dir = std::env::var_os("LMPC_REFERENCE_DIR").map_or_else(
        || PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../tests/data/reference"),
        PathBuf::from,
    );
    std::fs::read_to_string(dir.join(name)).unwrap()
}

fn rows(name: &str) -> Vec<Vec<f64>> {
    let text = read(name);
    let rows: Vec<Vec<f64>> = text
        .lines()
        .skip(1)
        .map(|line| line.split(',').map(|v| v.trim().parse().unwrap()).collect())
        .collect();
    assert!(!rows.is_empty(), "{name} holds no rows");
    rows
}

fn numbers(value: &serde_json::Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect()
}

/// The track of the file `l_track.json`.
fn reference_track() -> Track {
    let json: serde_json::Value = serde_json::from_str(&read("l_track.json")).unwrap();
    let segments: Vec<Segment> = numbers(&json["segments_len"])
        .into_iter()
        .zip(numbers(&json["segments_kappa"]))
        .map(|(length, kappa)| Segment { kappa, ..Segment::straight(length) })
        .collect();
    let half = 0.5 * json["width"].as_f64().unwrap();
    Track::from_segments("reference", &segments, half, half).unwrap()
}

fn close(a: f64, b: f64, what: &str) {
    assert!((a - b).abs() <= TOLERANCE, "{what}: {a} against {b}");
}

#[test]
fn reference_l_track_key_poses() {
    let json: serde_json::Value = serde_json::from_str(&read("l_track.json")).unwrap();
    let track = reference_track();
    close(track.length(), json["L"].as_f64().unwrap(), "length");
    let breaks = numbers(&json["s_breaks"]);
    let poses = json["key_poses_x_y_psi_unwrapped"].as_array().unwrap();
    for (s, pose) in breaks.iter().zip(poses).take(breaks.len() - 1) {
        let pose = numbers(pose);
        close(track.position(*s).0, pose[0], "x");
        close(track.position(*s).1, pose[1], "y");
        close(track.heading(*s), pose[2], "psi");
    }
}

#[test]
fn reference_l_track_samples() {
    let track = reference_track();
    for row in rows("l_track_samples.csv") {
        let s = row[0];
        if s >= track.length() {
            continue;
        }
        close(track.position(s).0, row[1], "x");
        close(track.position(s).1, row[2], "y");
        close(track.heading(s), row[3], "psi");
        close(track.kappa(s), row[4], "kappa");
    }
}

#[test]
fn reference_global_to_frenet_and_back() {
    let track = reference_track();
    for row in rows("global_to_frenet.csv") {
        let g = GlobalState { x: row[0], y: row[1], psi: row[2], ..GlobalState::default() };
        for hint in [None, Some(row[3] - 0.4), Some(row[3] + 0.4 + track.length())] {
            let x = track.to_frenet(&g, hint);
            close(x.s, row[3], "s");
            close(x.e_y, row[4], "e_y");
            close(wrap_angle(x.e_psi - row[5]), 0.0, "e_psi");
        }
        let x = State { s: row[3], e_y: row[4], e_psi: row[5], ..State::default() };
        let back = track.to_global(&x);
        close(back.x, g.x, "x");
        close(back.y, g.y, "y");
        close(wrap_angle(back.psi - g.psi), 0.0, "psi");
    }
}

#[test]
fn reference_l_track_ships_exactly() {
    let (ours, reference) = (Track::builtin("l").unwrap(), reference_track());
    for row in rows("l_track_samples.csv") {
        let s = row[0].min(ours.length() * (1.0 - 1e-15));
        close(ours.position(s).0, row[1], "x");
        close(ours.position(s).1, row[2], "y");
        // Breaks may differ in the last bit, and curvature jumps there.
        close(ours.kappa(s + 1e-12), reference.kappa(s + 1e-12), "kappa");
    }
    close(ours.width_left(3.0) + ours.width_right(3.0), 1.1, "width");
}
