//! What a run looked like over time, for the verdict: speed, room, inputs and states.

use lcm_types::{ActuationReport, Heartbeat, MpcTelemetry};
use safety::BridgeState;
use serde::Serialize;
use vehicle_model::State;

use super::observe::{Heard, Rule};

/// Points of one curve at most. \[-\]
const MOST: usize = 400;
/// A picture begins this long before the faults. \[ns\]
const BEFORE_NS: i64 = 1_000_000_000;

/// What was applied at an instant.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Applied {
    /// Since the faults began. \[s\]
    pub time_s: f64,
    /// Acceleration. \[m/s^2\]
    pub a_mps2: f64,
    /// Steering angle. \[rad\]
    pub delta_rad: f64,
}

/// The car at an instant; its true state where it sends that.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct CarSample {
    /// Since the faults began. \[s\]
    pub time_s: f64,
    /// Longitudinal velocity. \[m/s\]
    pub v_x_mps: f64,
    /// How far the farthest point of the body is beyond the edge, negative inside. \[m\]
    pub beyond_m: f64,
}

/// A state from an instant on.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Since {
    /// Since the faults began. \[s\]
    pub time_s: f64,
    /// Name of the state.
    pub state: String,
}

/// A run over time, from one second before its faults.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Timeline {
    /// The car.
    pub car: Vec<CarSample>,
    /// What was applied.
    pub applied: Vec<Applied>,
    /// Where it came from: `held`, `command`, `plan`, `stop`.
    pub source: Vec<Since>,
    /// States of the bridge, by its heartbeats and answers.
    pub bridge: Vec<Since>,
    /// States of the controller, by its heartbeats.
    pub controller: Vec<Since>,
    /// Results of the controller's steps, by its telemetry.
    pub solver: Vec<Since>,
}

impl Timeline {
    /// Whether there is nothing to draw.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.car.is_empty() && self.applied.is_empty()
    }
}

impl Heard {
    /// The run over time, with the faults beginning at `start_ns`.
    pub(super) fn timeline(&self, start_ns: i64, rule: &Rule<'_>) -> Timeline {
        let time_s = |ns: i64| (ns - start_ns) as f64 * 1e-9;
        let shown = |ns: i64| ns >= start_ns - BEFORE_NS;
        let driven = self.judged().iter().filter(|state| shown(state.h.mono_ns)).map(|state| {
            let lcm_types::Frenet { s, e_y, e_psi, .. } = state.frenet;
            let x = State { s, e_y, e_psi, ..State::default() };
            let beyond_m = rule.edges.beyond(rule.track, &x);
            CarSample { time_s: time_s(state.h.mono_ns), v_x_mps: state.vx, beyond_m }
        });
        let reports = || self.reports.iter().filter(|report| shown(report.h.mono_ns));
        let applied = reports().map(|r| Applied {
            time_s: time_s(r.h.mono_ns),
            a_mps2: r.accel,
            delta_rad: r.steer,
        });
        let source = reports().map(|r| (time_s(r.h.mono_ns), source(r.source)));
        let phase = |(ns, state): (i64, i8)| (time_s(ns), BridgeState::name_of(state));
        let of = |beat: &Heartbeat| (beat.h.mono_ns, beat.state);
        let mut bridge: Vec<_> = self.beats.iter().map(of).collect();
        bridge.extend(self.acks.iter().map(|ack| (ack.h.mono_ns, ack.state)));
        bridge.sort_unstable();
        let steps = self.controller.steps.iter();
        Timeline {
            car: thinned(driven.collect()),
            applied: thinned(applied.collect()),
            source: changes(source),
            bridge: changes(bridge.into_iter().map(phase)),
            controller: changes(self.controller.beats.iter().map(of).map(phase)),
            solver: changes(steps.map(|step| (time_s(step.h.mono_ns), status(step.status)))),
        }
    }
}

/// The states where they change, from the last before the picture on.
fn changes(states: impl Iterator<Item = (f64, &'static str)>) -> Vec<Since> {
    let begin = -(BEFORE_NS as f64) * 1e-9;
    let mut found: Vec<Since> = Vec::new();
    for (time_s, state) in states {
        if found.last().is_none_or(|last| last.state != state) {
            found.push(Since { time_s, state: state.to_owned() });
        }
    }
    let first = found.iter().rposition(|since| since.time_s <= begin).unwrap_or(0);
    found.drain(..first);
    if let Some(first) = found.first_mut() {
        first.time_s = first.time_s.max(begin);
    }
    found
}

/// At most [`MOST`] of the points, evenly.
fn thinned<T>(points: Vec<T>) -> Vec<T> {
    let every = points.len().div_ceil(MOST).max(1);
    points.into_iter().step_by(every).collect()
}

/// `source` of a report in words.
fn source(source: i8) -> &'static str {
    match source {
        ActuationReport::NOBODY => "held",
        ActuationReport::COMMAND => "command",
        ActuationReport::PLAN => "plan",
        ActuationReport::SAFE_STOP => "stop",
        _ => "unknown",
    }
}

/// `status` of a step in words.
fn status(status: i8) -> &'static str {
    match status {
        MpcTelemetry::SOLVED => "SOLVED",
        MpcTelemetry::MAX_ITER => "MAX_ITER",
        MpcTelemetry::INFEASIBLE => "INFEASIBLE",
        MpcTelemetry::NUMERIC => "NUMERIC",
        MpcTelemetry::TIMEOUT => "TIMEOUT",
        MpcTelemetry::FALLBACK => "FALLBACK",
        _ => "unknown",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_state_is_named_once_and_from_the_beginning_of_the_picture() {
        let all = [(-9.0, "IDLE"), (-5.0, "RUNNING"), (-4.0, "RUNNING"), (0.5, "SAFE_STOP")];
        let found = changes(all.into_iter());
        let found: Vec<_> = found.iter().map(|s| (s.time_s, s.state.as_str())).collect();
        assert_eq!(found, [(-1.0, "RUNNING"), (0.5, "SAFE_STOP")]);
    }

    #[test]
    fn a_curve_has_few_points_spread_over_all_of_it() {
        let few = thinned((0..1_001).collect::<Vec<_>>());
        assert!(few.len() <= MOST && few[0] == 0 && *few.last().unwrap_or(&0) > 990, "{few:?}");
        assert_eq!(thinned(vec![1, 2, 3]), [1, 2, 3]);
    }
}
