//! A log's states through the controller again: do the same commands come out?

use std::collections::BTreeMap;
use std::io::Read;

use anyhow::Result;
use controller::Controller;
use lcm_types::eventlog::Reader;
use lcm_types::{ActuationCommand, Checked as _, VehicleState, channels};

use super::convert;
use super::schedule::Schedule;

/// What a replay found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Replay {
    /// Commands to drive, each to a state of its own. \[-\]
    pub commands: u64,
    /// Of those, the ones that came out in the same bits. \[-\]
    pub identical: u64,
    /// Number of the first command that did not.
    pub first_difference: Option<i64>,
    /// Commands whose state is not in the log. \[-\]
    pub without_state: u64,
    /// Messages of the two channels that could not be read. \[-\]
    pub unreadable: u64,
}

impl Replay {
    /// Whether all commands came out again.
    #[must_use]
    pub fn is_identical(&self) -> bool {
        self.commands > 0 && self.identical == self.commands && self.without_state == 0
    }
}

/// Gives every state that a command in `log` answers to the controller, which must know what the
/// one that was recorded knew at its start.
///
/// # Errors
/// If the log cannot be read.
pub fn replay(log: impl Read, controller: &mut Controller) -> Result<Replay> {
    let period = controller.config().horizon.period;
    let track_id = convert::track_id(controller.track());
    let mut schedule = Schedule::new(convert::nanoseconds(period));
    let mut states: BTreeMap<(i64, i64), VehicleState> = BTreeMap::new();
    let mut found = Replay::default();
    let mut last: Option<(i64, i64)> = None;
    for event in Reader::new(log) {
        let event = event?;
        if event.channel == channels::STATE {
            match VehicleState::open(&event.data) {
                Ok(state) => drop(states.insert((state.h.boot_id, state.h.seq), state)),
                Err(_) => found.unreadable += 1,
            }
        } else if event.channel == channels::COMMAND || event.channel == channels::COMMAND_DRY {
            let Ok(command) = ActuationCommand::open(&event.data) else {
                found.unreadable += 1;
                continue;
            };
            if command.mode != ActuationCommand::MODE_DRIVE {
                continue;
            }
            let Some(state) = states.get(&(command.state_boot_id, command.state_seq)) else {
                found.without_state += 1;
                continue;
            };
            let measured = (state.h.boot_id, state.meas_mono_ns);
            // The same measurement said again was answered without a step.
            if last == Some(measured) {
                continue;
            }
            if last.is_none_or(|(boot_id, _)| boot_id != state.h.boot_id) {
                schedule.restart(state.meas_mono_ns, state.h.mono_ns);
            }
            last = Some(measured);
            let Some(time_ns) = schedule.time(state.meas_mono_ns) else { continue };
            let Some(pose) = convert::pose(state, track_id) else { continue };
            let measurement = convert::measurement(pose, time_ns, period, None);
            let input = controller.step(&measurement).input;
            found.commands += 1;
            let same = input.a.to_bits() == command.accel.to_bits()
                && input.delta.to_bits() == command.steer.to_bits();
            found.identical += u64::from(same);
            if !same && found.first_difference.is_none() {
                found.first_difference = Some(command.h.seq);
            }
        }
    }
    Ok(found)
}
