//! What goes to a page, as JSON: only what it does not have yet.

use log_export::scene::on_track;
use serde_json::{Value, json};

use crate::lap::short;
use crate::model::ViewModel;

/// Stages of a plan and points of a safe set that a page gets, at most. \[-\]
const POINTS: usize = 400;

/// What one page has already.
#[derive(Debug, Clone, Default)]
pub(crate) struct Cursor {
    world: u64,
    laps: u64,
    epoch: u64,
    samples: usize,
    steps: u64,
}

/// Events for a page: a name and its data each.
pub(crate) type Events = Vec<(&'static str, String)>;

/// What is new since the cursor, at `now_ns`; with `status`, also the states of all programs.
pub(crate) fn events(model: &ViewModel, cursor: &mut Cursor, now_ns: i64, status: bool) -> Events {
    let mut out = Events::new();
    if model.world_version != cursor.world {
        cursor.world = model.world_version;
        // Another track: all laps are others.
        (cursor.laps, cursor.epoch, cursor.samples) = (u64::MAX, u64::MAX, 0);
        out.push(("world", text(&model.world)));
    }
    if let Some(laps) = &model.laps
        && laps.version != cursor.laps
    {
        cursor.laps = laps.version;
        let (last, best) = (laps.last.as_deref(), laps.best.as_deref());
        out.push(("laps", text(&json!({ "rows": laps.rows, "last": last, "best": best }))));
    }
    if status {
        let seen = model.watch.snapshot(now_ns);
        out.push(("status", text(&json!({ "seen": seen, "ended": model.ended }))));
    }
    out.push(("frame", text(&frame(model, cursor, now_ns))));
    out
}

fn frame(model: &ViewModel, cursor: &mut Cursor, now_ns: i64) -> Value {
    let mut frame = json!({ "now": short(now_ns as f64 * 1e-9), "states": model.states_seen });
    let Some(map) = frame.as_object_mut() else { return frame };
    if let Some(car) = car(model, now_ns) {
        map.insert("car".to_owned(), car);
    }
    if let Some(laps) = &model.laps {
        let fresh = laps.epoch != cursor.epoch;
        if fresh {
            (cursor.epoch, cursor.samples) = (laps.epoch, 0);
        }
        let added = laps.current.samples.get(cursor.samples..).unwrap_or_default();
        cursor.samples = laps.current.samples.len();
        let lap = json!({
            "lap": laps.current.lap, "fresh": fresh, "whole": laps.current.whole, "add": added,
        });
        map.insert("lap".to_owned(), lap);
    }
    let missing = model.steps_seen.saturating_sub(cursor.steps);
    if missing > 0 {
        let missing = usize::try_from(missing).unwrap_or(usize::MAX).min(model.steps.len());
        let added: Vec<_> = model
            .steps
            .iter()
            .skip(model.steps.len() - missing)
            .map(|step| json!([step.total_us, step.build_us, step.solve_us, step.status]))
            .collect();
        map.insert("steps".to_owned(), Value::Array(added));
        map.insert("plan".to_owned(), plan(model));
        cursor.steps = model.steps_seen;
    }
    frame
}

fn car(model: &ViewModel, now_ns: i64) -> Option<Value> {
    let (state, arrival_ns) = model.watch.state()?;
    let place = model.watch.place(state);
    let (use_f, use_r) = model.tyres(state);
    let report = model.watch.report();
    Some(json!({
        "at": short(arrival_ns as f64 * 1e-9),
        "age": short(now_ns.saturating_sub(arrival_ns).max(0) as f64 * 1e-9),
        "x": short(state.x), "y": short(state.y), "yaw": short(state.yaw),
        "s": place.map(|(s, ..)| short(s)), "e_y": place.map(|(_, e_y, _)| short(e_y)),
        "v": short(state.vx), "lap": state.frenet.lap, "quality": state.quality,
        "a": report.map(|report| short(report.accel)),
        "delta": report.map(|report| short(report.steer)),
        "source": report.map(|report| report.source),
        "limited": report.map(|report| report.limited),
        "use_f": short(use_f), "use_r": short(use_r),
    }))
}

/// The plan and the safe set of the last step.
fn plan(model: &ViewModel) -> Value {
    let Some(step) = model.watch.step() else { return Value::Null };
    let states: Vec<_> = step
        .pred
        .iter()
        .take(POINTS)
        .map(|p| [p.x, p.y, p.s, p.vx].map(|value| short(f64::from(value))))
        .collect();
    let inputs: Vec<_> =
        step.u.iter().take(POINTS).map(|u| u.map(|value| short(f64::from(value)))).collect();
    let set: Vec<_> = model
        .watch
        .track()
        .map(|track| {
            let points = step.ss.iter().take(POINTS).enumerate();
            points
                .filter_map(|(i, point)| {
                    let &[v_x, _, _, _, s, e_y] = point.as_slice() else { return None };
                    let (x, y) = on_track(track, s.into(), e_y.into())?;
                    let lambda = step.ss_lambda.get(i).copied().map_or(f64::NAN, f64::from);
                    Some([x, y, lambda, f64::from(s), f64::from(v_x)].map(short))
                })
                .collect()
        })
        .unwrap_or_default();
    json!({
        "x": states, "u": inputs, "set": set, "support_min": step.support_min,
        "support_mean": step.support_mean, "iters": step.iters,
        "deadline_us": step.deadline_us,
    })
}

/// Numbers, words and lists: there is nothing that does not serialise.
fn text(value: &impl serde::Serialize) -> String {
    serde_json::to_string(value).unwrap_or_default()
}
