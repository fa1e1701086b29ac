//! What the messages of a drive look like: Foxglove's own message types, as JSON.

use lcm_types::eventlog::Event;
use lcm_types::{Checked as _, Message as _, MpcTelemetry, Track, VehicleState, channels};
use serde_json::{Value, json};

/// Edges of the track, from `MAP/TRACK`.
pub const TRACK: &str = "scene/track";
/// The car, from `CAR/STATE`.
pub const CAR: &str = "scene/car";
/// The predicted trajectory, from `LMPC/TELEM`.
pub const PREDICTION: &str = "scene/prediction";
/// Points of the local safe set, from `LMPC/TELEM`, on the track.
pub const SAFE_SET: &str = "scene/safe_set";
/// Where the car's frame is in the world's, from `CAR/STATE`.
pub const FRAME: &str = "tf";
/// All topics.
pub const TOPICS: [&str; 5] = [TRACK, CAR, PREDICTION, SAFE_SET, FRAME];

const WORLD: &str = "world";
/// Length of the drawn car, in widths of the track: a log does not tell the car's size. \[-\]
const CAR_LENGTH: f64 = 0.4;
/// Size without a track. \[m\]
const CAR_DEFAULT: f64 = 0.4;

/// Type of a derived topic.
#[must_use]
pub fn type_of(topic: &str) -> &'static str {
    if topic == FRAME { "foxglove.FrameTransform" } else { "foxglove.SceneUpdate" }
}

/// Schema of a derived topic's type. Foxglove knows it by name; other readers find the outline.
#[must_use]
pub fn schema(name: &str) -> Value {
    let time = json!({ "type": "object", "title": "time", "properties": {
        "sec": { "type": "integer" }, "nsec": { "type": "integer" } } });
    let text = json!({ "type": "string" });
    let numbers = |names: &[&str]| {
        let each = names.iter().map(|name| ((*name).to_owned(), json!({ "type": "number" })));
        json!({ "type": "object", "properties": each.collect::<serde_json::Map<_, _>>() })
    };
    let (vector, turn) = (numbers(&["x", "y", "z"]), numbers(&["x", "y", "z", "w"]));
    if name == type_of(FRAME) {
        return json!({ "type": "object", "title": name, "properties": {
            "timestamp": time, "parent_frame_id": text, "child_frame_id": text,
            "translation": vector, "rotation": turn } });
    }
    let pose = json!({ "type": "object",
        "properties": { "position": vector, "orientation": turn } });
    let color = numbers(&["r", "g", "b", "a"]);
    let list = |items: Value| json!({ "type": "array", "items": items });
    let solid = json!({ "type": "object",
        "properties": { "pose": pose, "size": vector, "color": color } });
    let line = json!({ "type": "object", "properties": {
        "type": { "type": "integer" }, "pose": pose, "thickness": { "type": "number" },
        "scale_invariant": { "type": "boolean" }, "points": list(vector), "color": color,
        "colors": list(color), "indices": list(json!({ "type": "integer" })) } });
    let nothing = list(json!({ "type": "object" }));
    let entity = json!({ "type": "object", "properties": {
        "timestamp": time, "frame_id": text, "id": text, "lifetime": time,
        "frame_locked": { "type": "boolean" }, "metadata": nothing, "arrows": nothing,
        "cubes": list(solid.clone()), "spheres": list(solid), "cylinders": nothing,
        "lines": list(line), "triangles": nothing, "texts": nothing, "models": nothing } });
    json!({ "type": "object", "title": name,
        "properties": { "deletions": nothing, "entities": list(entity) } })
}

/// Draws the messages.
#[derive(Debug)]
pub struct Scene {
    track: Option<Track>,
    drawn: bool,
}

impl Scene {
    /// With the track that is known from the beginning, if any.
    #[must_use]
    pub fn new(track: Option<Track>) -> Self {
        Self { track, drawn: false }
    }

    /// Draws the track again with the next message: for who has come later.
    pub fn redraw(&mut self) {
        self.drawn = false;
    }

    /// Topics and messages that a message of the log gives.
    pub fn take(&mut self, event: &Event) -> Vec<(&'static str, Value)> {
        let mut drawn = Vec::new();
        if event.channel == channels::TRACK
            && let Ok(track) = Track::open(&event.data)
        {
            self.drawn &= self.track.as_ref().is_some_and(|t| t.track_id == track.track_id);
            self.track = Some(track);
        }
        if let (Some(track), false) = (&self.track, self.drawn) {
            drawn.push((TRACK, edges(track, event.utime)));
            self.drawn = true;
        }
        match event.channel.as_str() {
            channels::STATE => {
                if let Ok(state) = VehicleState::open(&event.data)
                    && state.valid & VehicleState::POSE != 0
                {
                    drawn.push((CAR, self.car(&state, event.utime)));
                    drawn.push((FRAME, frame(&state, event.utime)));
                }
            }
            channels::TELEMETRY => {
                if let Ok(told) = MpcTelemetry::decode(&event.data) {
                    let points = told.pred.iter().map(|p| point(p.x.into(), p.y.into()));
                    let line = line(STRIP, points.collect(), self.size() * 0.1, [1.0, 0.5, 0.0]);
                    let lines = json!({ "lines": [line] });
                    drawn.push((PREDICTION, update(event.utime, "prediction", lines)));
                    drawn.extend(self.safe_set(&told, event.utime).map(|set| (SAFE_SET, set)));
                }
            }
            _ => {}
        }
        drawn
    }

    /// Length of the car as drawn. \[m\]
    fn size(&self) -> f64 {
        let width = self.track.as_ref().and_then(|track| {
            let left = track.w_left.first()?;
            track.w_right.first().map(|right| f64::from(left + right))
        });
        width.map_or(CAR_DEFAULT, |width| width * CAR_LENGTH)
    }

    fn car(&self, state: &VehicleState, utime: i64) -> Value {
        let (length, height) = (self.size(), 0.3 * self.size());
        let cube = json!({
            "pose": pose(state.x, state.y, 0.5 * height, state.yaw),
            "size": { "x": length, "y": 0.5 * length, "z": height },
            "color": color([0.1, 0.4, 1.0]),
        });
        update(utime, "car", json!({ "cubes": [cube] }))
    }

    /// The points have track coordinates: v_x, v_y, omega_z, e_psi, s, e_y.
    fn safe_set(&self, told: &MpcTelemetry, utime: i64) -> Option<Value> {
        let track = self.track.as_ref()?;
        let size = self.size() * 0.15;
        let spheres = told.ss.iter().filter_map(|x| {
            let [_, _, _, _, s, e_y] = <[f32; 6]>::try_from(x.as_slice()).ok()?;
            let (x, y) = on_track(track, s.into(), e_y.into())?;
            Some(json!({
                "pose": pose(x, y, 0.0, 0.0),
                "size": { "x": size, "y": size, "z": size },
                "color": color([0.2, 0.8, 0.3]),
            }))
        });
        let spheres: Vec<Value> = spheres.collect();
        Some(update(utime, "safe_set", json!({ "spheres": spheres })))
    }
}

const STRIP: u8 = 0;
const LOOP: u8 = 1;

fn edges(track: &Track, utime: i64) -> Value {
    let samples = track.x.iter().zip(&track.y).zip(&track.yaw);
    let edge = |offsets: &[f32], side: f64| {
        let points = samples.clone().zip(offsets).map(|(((&x, &y), &yaw), &width)| {
            let (sin, cos) = f64::from(yaw).sin_cos();
            let offset = side * f64::from(width);
            point(f64::from(x) - offset * sin, f64::from(y) + offset * cos)
        });
        let kind = if track.closed { LOOP } else { STRIP };
        line(kind, points.collect(), 0.0, [0.6, 0.6, 0.6])
    };
    let lines = [edge(&track.w_left, 1.0), edge(&track.w_right, -1.0)];
    update(utime, "track", json!({ "lines": lines }))
}

/// World position of a place beside the centre line \[m\], along an arc from the sample before it;
/// `None` where the message has no sample before it.
#[must_use]
pub fn on_track(track: &Track, s: f64, e_y: f64) -> Option<(f64, f64)> {
    let s = if track.closed { s.rem_euclid(track.length) } else { s };
    let after = track.s.partition_point(|&sample| f64::from(sample) <= s);
    let i = after.checked_sub(1)?;
    let at = |values: &[f32]| values.get(i).copied().map(f64::from);
    let (ds, yaw, kappa) = (s - at(&track.s)?, at(&track.yaw)?, at(&track.kappa)?);
    let middle = yaw + 0.5 * kappa * ds;
    let end = yaw + kappa * ds;
    let x = at(&track.x)? + ds * middle.cos() - e_y * end.sin();
    let y = at(&track.y)? + ds * middle.sin() + e_y * end.cos();
    Some((x, y))
}

/// An entity that replaces the last one of its name.
fn update(utime: i64, id: &str, shapes: Value) -> Value {
    let mut entity = json!({
        "timestamp": time(utime), "frame_id": WORLD, "id": id,
        "lifetime": { "sec": 0, "nsec": 0 }, "frame_locked": false, "metadata": [],
        "arrows": [], "cubes": [], "spheres": [], "cylinders": [], "lines": [],
        "triangles": [], "texts": [], "models": [],
    });
    if let (Some(entity), Value::Object(shapes)) = (entity.as_object_mut(), shapes) {
        entity.extend(shapes);
    }
    json!({ "deletions": [], "entities": [entity] })
}

/// A thickness of 0 is two pixels, whatever the distance.
fn line(kind: u8, points: Vec<Value>, thickness: f64, rgb: [f64; 3]) -> Value {
    let pixels = thickness == 0.0;
    json!({
        "type": kind, "pose": pose(0.0, 0.0, 0.0, 0.0),
        "thickness": if pixels { 2.0 } else { thickness }, "scale_invariant": pixels,
        "points": points, "color": color(rgb), "colors": [], "indices": [],
    })
}

fn frame(state: &VehicleState, utime: i64) -> Value {
    let pose = pose(state.x, state.y, 0.0, state.yaw);
    json!({
        "timestamp": time(utime), "parent_frame_id": WORLD, "child_frame_id": "car",
        "translation": pose["position"], "rotation": pose["orientation"],
    })
}

fn point(x: f64, y: f64) -> Value {
    json!({ "x": x, "y": y, "z": 0.0 })
}

fn pose(x: f64, y: f64, z: f64, yaw: f64) -> Value {
    let (sin, cos) = (0.5 * yaw).sin_cos();
    json!({
        "position": { "x": x, "y": y, "z": z },
        "orientation": { "x": 0.0, "y": 0.0, "z": sin, "w": cos },
    })
}

fn color([r, g, b]: [f64; 3]) -> Value {
    json!({ "r": r, "g": g, "b": b, "a": 1.0 })
}

fn time(utime: i64) -> Value {
    json!({ "sec": utime.div_euclid(1_000_000), "nsec": utime.rem_euclid(1_000_000) * 1000 })
}

#[cfg(test)]
mod tests {
    use super::*;
    use protocol::telemetry::track_message;

    #[test]
    fn a_place_on_the_message_is_the_place_on_the_track() {
        let track = vehicle_model::Track::builtin("l").unwrap_or_else(|| unreachable!());
        let message = track_message(&track);
        let step = track.length() / message.kappa.len() as f64;
        for i in 0..1000 {
            let (s, e_y) = (f64::from(i) * 0.0371, f64::from(i % 7 - 3) * 0.05);
            let x = vehicle_model::State { s: track.wrap(s), e_y, ..Default::default() };
            let expected = track.to_global(&x);
            let found = on_track(&message, s, e_y).unwrap_or_default();
            let apart = (found.0 - expected.x).hypot(found.1 - expected.y);
            // Where the curvature steps between two samples, the first one's goes on too far.
            let before = (track.wrap(s) / step) as usize % message.kappa.len();
            let after = (before + 1) % message.kappa.len();
            let jump = f64::from(message.kappa[after] - message.kappa[before]).abs();
            let most = 1e-4 + jump * step * (0.5 * step + e_y.abs());
            assert!(apart < most, "{apart} m apart at s = {s}, expected below {most} m");
        }
    }
}
