//! The L track against the numbers of an independent implementation.

#![allow(clippy::unwrap_used)]

use std::path::PathBuf;
use track::{GlobalState, Segment, State, Track, wrap_angle};

/// Bar of the comparison; the implementations agree much closer than this.
const TOLERANCE: f64 = 1e-9;

fn read(name: &str) -> String {
    // A relative folder counts from the workspace, wherever the test is started.
    let named = std::env::var_os("LMPC_REFERENCE_DIR");
    let named = named.map_or_else(|| PathBuf::from("tests/data/reference"), PathBuf::from);
    let dir = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../..").join(named);
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

/// Places of the file's track in its own frame, which may start elsewhere than at (0, 0, 0).
struct Frame {
    track: Track,
    start: Vec<f64>,
    breaks: Vec<f64>,
}

impl Frame {
    fn read() -> Self {
        let json: serde_json::Value = serde_json::from_str(&read("l_track.json")).unwrap();
        let (start, breaks) = (numbers(&json["start_pose"]), numbers(&json["s_breaks"]));
        Self { track: reference_track(), start, breaks }
    }

    /// From our frame to the file's.
    fn out(&self, (x, y): (f64, f64), psi: f64) -> (f64, f64, f64) {
        let (sin, cos) = self.start[2].sin_cos();
        (self.start[0] + x * cos - y * sin, self.start[1] + x * sin + y * cos, psi + self.start[2])
    }

    /// From the file's frame to ours.
    fn back(&self, x: f64, y: f64, psi: f64) -> GlobalState {
        let (sin, cos) = self.start[2].sin_cos();
        let (dx, dy) = (x - self.start[0], y - self.start[1]);
        let (x, y, psi) = (dx * cos + dy * sin, dy * cos - dx * sin, psi - self.start[2]);
        GlobalState { x, y, psi, ..GlobalState::default() }
    }

    /// Our pose at s in the file's frame.
    fn pose(&self, s: f64) -> (f64, f64, f64) {
        self.out(self.track.position(s), self.track.heading(s))
    }
}

fn close(a: f64, b: f64, what: &str) {
    assert!((a - b).abs() <= TOLERANCE, "{what}: {a} against {b}");
}

#[test]
fn reference_l_track_key_poses() {
    let json: serde_json::Value = serde_json::from_str(&read("l_track.json")).unwrap();
    let frame = Frame::read();
    close(frame.track.length(), json["L"].as_f64().unwrap(), "length");
    let poses = json["key_poses_x_y_psi_unwrapped"].as_array().unwrap();
    assert_eq!(poses.len(), frame.breaks.len());
    for (s, pose) in frame.breaks.iter().zip(poses) {
        // The last one is the end of the lap, not the beginning of the next.
        let (x, y, psi) = frame.pose(s.min(frame.track.length().next_down()));
        let pose = numbers(pose);
        close(x, pose[0], "x");
        close(y, pose[1], "y");
        close(psi, pose[2], "psi");
    }
}

#[test]
fn reference_l_track_samples() {
    let frame = Frame::read();
    for row in rows("l_track_samples.csv") {
        let s = row[0].min(frame.track.length().next_down());
        let (x, y, psi) = frame.pose(s);
        close(x, row[1], "x");
        close(y, row[2], "y");
        close(wrap_angle(psi - row[3]), 0.0, "psi");
        // At a break the last bit of s decides which side of the jump it is on.
        if frame.breaks.iter().all(|b| (b - s).abs() > TOLERANCE) {
            close(frame.track.kappa(s), row[4], "kappa");
        }
    }
}

#[test]
fn reference_global_to_frenet_and_back() {
    let frame = Frame::read();
    let length = frame.track.length();
    for row in rows("global_to_frenet.csv") {
        let g = frame.back(row[0], row[1], row[2]);
        for hint in [None, Some(row[3] - 0.02 * length), Some(row[3] + 1.02 * length)] {
            let x = frame.track.to_frenet(&g, hint);
            let ahead = frame.track.wrap(x.s - row[3]);
            close(ahead.min(length - ahead), 0.0, "s");
            close(x.e_y, row[4], "e_y");
            close(wrap_angle(x.e_psi - row[5]), 0.0, "e_psi");
        }
        let x = State { s: row[3], e_y: row[4], e_psi: row[5], ..State::default() };
        let back = frame.track.to_global(&x);
        let (x, y, psi) = frame.out((back.x, back.y), back.psi);
        close(x, row[0], "x");
        close(y, row[1], "y");
        close(wrap_angle(psi - row[2]), 0.0, "psi");
    }
}
