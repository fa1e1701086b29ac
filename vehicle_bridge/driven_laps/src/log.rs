//! A drive from an event log of LCM: states, and what was applied or commanded.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufReader, Read as _};
use std::path::Path;

use anyhow::{Context as _, Result, bail};
use controller::Pose;
use lcm_types::eventlog::{EventReader, SYNC};
use lcm_types::{ActuationCommand, ActuationReport, Checked as _, VehicleState, channels};
use vehicle_model::{GlobalState, Input, State};

use super::{Recorded, Recording};

/// Whether the file begins as an event log does.
pub(super) fn is_log(path: &Path) -> std::io::Result<bool> {
    let mut first = [0; 4];
    let mut file = File::open(path)?;
    Ok(file.read_exact(&mut first).is_ok() && first == SYNC.to_be_bytes())
}

/// Two clocks that differ by more than this share do not run alike: the drive was a simulation that
/// waited for its driver.
const SAME_PACE: f64 = 0.02;

/// Reads a log. Times are those of the measurements.
pub(super) fn read(path: &Path, channel: &str) -> Result<Recording> {
    let shown = path.display();
    let file = File::open(path).with_context(|| format!("cannot read {shown}"))?;
    let mut events = EventReader::new(BufReader::new(file));
    let mut recording = Recording { rows: "messages", ..Recording::default() };
    let (mut clock, mut reports, mut commands) = (Clock::default(), Vec::new(), Vec::new());
    let mut seen: BTreeMap<String, u64> = BTreeMap::new();
    // Either clock from its first time on: what counts from 1970 has no bits left for microseconds.
    let (mut first_logged, mut first_measured, mut number) = (None, None, 0);
    while let Some(event) = events.next_event().with_context(|| format!("cannot read {shown}"))? {
        let start = *first_logged.get_or_insert(event.utime);
        let logged = event.utime.wrapping_sub(start) as f64 * 1e-6;
        number += 1;
        *seen.entry(event.channel.clone()).or_default() += 1;
        let readable = match event.channel.as_str() {
            name if name == channel => VehicleState::open(&event.data).is_ok_and(|state| {
                let time = if state.meas_mono_ns == 0 {
                    logged
                } else {
                    let start = *first_measured.get_or_insert(state.meas_mono_ns);
                    state.meas_mono_ns.wrapping_sub(start) as f64 * 1e-9
                };
                clock.pairs.push((logged, time));
                let recorded = recorded(&state, time, number);
                if recorded.is_some_and(|state| state.velocities.is_none() || state.steer.is_none())
                {
                    recording.lacks.push((number, "not marked as valid".into()));
                }
                recording.states.extend(recorded);
                recorded.is_some()
            }),
            channels::ACTUATION => ActuationReport::open(&event.data).is_ok_and(|report| {
                reports.push((logged, Input { a: report.accel, delta: report.steer }));
                true
            }),
            channels::COMMAND => ActuationCommand::open(&event.data).is_ok_and(|command| {
                if command.enable && command.mode == ActuationCommand::MODE_DRIVE {
                    commands.push((logged, Input { a: command.accel, delta: command.steer }));
                }
                true
            }),
            _ => true,
        };
        if !readable {
            recording.left_out.add(number, "no message that can be read");
        }
    }
    if recording.states.is_empty() {
        let names: Vec<String> = seen.iter().map(|(name, n)| format!("{name} ({n})")).collect();
        bail!(
            "{shown} holds no states of the car (lmpc.vehicle_state_t) on channel {channel}; it has \
             {}. Give --channel, or record the messages of `lmpc vehicle car`, which makes such \
             states of a car's own messages",
            if names.is_empty() { "no messages".to_owned() } else { names.join(", ") }
        );
    }
    recording.applied = !reports.is_empty();
    clock.settle();
    let measured = |inputs: Vec<(f64, Input)>, side| {
        inputs.into_iter().map(|(logged, u)| (clock.measured(logged, side), u)).collect()
    };
    recording.inputs = if recording.applied {
        until_then(measured(reports, Side::Behind))
    } else {
        measured(commands, Side::Before)
    };
    Ok(recording)
}

/// When states were logged and when they were measured, in the order of the log \[s\].
#[derive(Debug, Default)]
struct Clock {
    pairs: Vec<(f64, f64)>,
    /// Median difference, where the clocks run alike \[s\].
    offset: Option<f64>,
}

/// Which state a message belongs to where the clocks do not run alike.
#[derive(Debug, Clone, Copy)]
enum Side {
    /// The state before it, which a command answers.
    Before,
    /// The state behind it, up to which a report tells what acted.
    Behind,
}

impl Clock {
    /// Takes the median difference of the two clocks, if they run alike.
    fn settle(&mut self) {
        let (Some(first), Some(last)) = (self.pairs.first(), self.pairs.last()) else { return };
        let pace = (last.1 - first.1) / (last.0 - first.0).max(1e-9);
        if (pace - 1.0).abs() < SAME_PACE {
            let mut offsets: Vec<f64> = self.pairs.iter().map(|(l, m)| m - l).collect();
            let middle = offsets.len() / 2;
            self.offset = Some(*offsets.select_nth_unstable_by(middle, f64::total_cmp).1);
        }
    }

    /// Time on the clock of the measurements of what was logged at `logged`: by the median
    /// difference, as messages come late by turns, or by the states around it.
    fn measured(&self, logged: f64, side: Side) -> f64 {
        if let Some(offset) = self.offset {
            return logged + offset;
        }
        let next = self.pairs.partition_point(|pair| pair.0 <= logged);
        let at = match side {
            Side::Before => next.saturating_sub(1),
            Side::Behind => next.min(self.pairs.len() - 1),
        };
        self.pairs[at].1
    }
}

/// A report tells what acted since the one before it.
pub(super) fn until_then(reports: Vec<(f64, Input)>) -> Vec<(f64, Input)> {
    let first = reports.iter().zip(reports.iter().skip(1)).map(|(a, b)| b.0 - a.0).next();
    let mut since = reports.first().map_or(0.0, |report| report.0) - first.unwrap_or(0.0);
    let mut inputs = Vec::with_capacity(reports.len());
    for (time, input) in reports {
        inputs.push((since, input));
        since = time;
    }
    inputs
}

fn recorded(state: &VehicleState, time: f64, row: u64) -> Option<Recorded> {
    let has = |bit| state.valid & bit != 0;
    let pose = if has(VehicleState::POSE) {
        let (x, y, psi) = (state.x, state.y, state.yaw);
        Pose::Global(GlobalState { x, y, psi, ..GlobalState::default() })
    } else if has(VehicleState::FRENET) {
        let (s, e_y, e_psi) = (state.frenet.s, state.frenet.e_y, state.frenet.e_psi);
        Pose::Frenet(State { s, e_y, e_psi, ..State::default() })
    } else {
        return None;
    };
    let velocities = has(VehicleState::VEL).then_some([state.vx, state.vy, state.yaw_rate]);
    let steer = has(VehicleState::STEER).then_some(state.steer);
    Some(Recorded { time, row, pose, velocities, steer })
}
