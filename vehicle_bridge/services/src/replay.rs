//! A log's states through the controller again: do the same commands come out?

use std::collections::BTreeMap;
use std::io::{Read, Seek};

use anyhow::Result;
use controller::Controller;
use lcm_types::eventlog::{Damage, EventReader};
use lcm_types::{
    ActuationCommand, BootId, Checked as _, Message as _, OperatorAck, OperatorCommand, SeqNumber,
    VehicleState, channels,
};
use vehicle_model::Input;

use super::operator;
use super::schedule::Schedule;
use protocol::convert;

/// What a replay found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Replay {
    /// Commands to drive, each to a state of its own. \[-\]
    pub commands: u64,
    /// Of those, the ones that came out in the same bits. \[-\]
    pub identical: u64,
    /// Number of the first command that did not.
    pub first_difference: Option<SeqNumber>,
    /// Commands whose state is not in the log. \[-\]
    pub without_state: u64,
    /// Messages of its channels that could not be read. \[-\]
    pub unreadable: u64,
    /// What of the log is no event.
    pub damage: Damage,
}

impl Replay {
    /// Whether all commands came out again.
    #[must_use]
    pub fn is_identical(&self) -> bool {
        self.commands > 0 && self.identical == self.commands && self.without_state == 0
    }
}

/// Gives every state that a command in `log` answers to the controller, which must know what the
/// one that was recorded knew at its start. The operator's speed cap acts from where the service
/// acknowledged it in the log. A state may stand behind its command: a recorder beside the service
/// can hear them in either order.
///
/// # Errors
/// If the log cannot be read.
pub fn replay(mut log: impl Read + Seek, controller: &mut Controller) -> Result<Replay> {
    let (states, unreadable) = states(&mut log)?;
    log.rewind()?;
    let mut player = Player {
        track_id: convert::track_id(controller.track()),
        schedule: Schedule::new(convert::nanoseconds(controller.config().horizon.period)),
        states,
        caps: BTreeMap::new(),
        cap: None,
        last: None,
        found: Replay { unreadable, ..Replay::default() },
        controller,
    };
    let mut events = EventReader::new(log);
    for event in events.by_ref() {
        let event = event?;
        match event.channel.as_str() {
            channels::OPERATOR => match OperatorCommand::open(&event.data) {
                Ok(order) if order.command == OperatorCommand::SET_SPEED_CAP => {
                    player.caps.insert(order.request_id, order.value);
                }
                Ok(_) => {}
                Err(_) => player.found.unreadable += 1,
            },
            channels::OPERATOR_ACK => match OperatorAck::decode(&event.data) {
                // The bridge answers too; the plans changed when the service did.
                Ok(ack) if ack.h.sender.starts_with("bridge@") => {}
                Ok(ack) => player.acknowledged(&ack)?,
                Err(_) => player.found.unreadable += 1,
            },
            channels::COMMAND | channels::COMMAND_DRY => {
                match ActuationCommand::open(&event.data) {
                    Ok(command) => player.answer(&command),
                    Err(_) => player.found.unreadable += 1,
                }
            }
            _ => {}
        }
    }
    Ok(Replay { damage: events.damage(), ..player.found })
}

/// States by the sender's start and number.
type States = BTreeMap<(BootId, SeqNumber), VehicleState>;

/// All states of a log, and how many of their messages could not be read.
fn states(log: impl Read) -> Result<(States, u64)> {
    let (mut states, mut unreadable) = (States::new(), 0);
    for event in EventReader::new(log) {
        let event = event?;
        if event.channel != channels::STATE {
            continue;
        }
        match VehicleState::open(&event.data) {
            Ok(state) => drop(states.insert((state.h.sender_start(), state.h.number()), state)),
            Err(_) => unreadable += 1,
        }
    }
    Ok((states, unreadable))
}

/// The service's part in a drive, from its messages.
struct Player<'a> {
    controller: &'a mut Controller,
    track_id: i64,
    schedule: Schedule,
    states: States,
    /// Speed caps ordered, by the number of the order. \[m/s\]
    caps: BTreeMap<i64, f64>,
    cap: Option<f64>,
    last: Option<Last>,
    found: Replay,
}

/// The last state answered.
#[derive(Clone, Copy)]
struct Last {
    boot_id: BootId,
    seq: SeqNumber,
    meas_mono_ns: i64,
    /// The controller answered it.
    stepped: bool,
    input: Input,
    /// The controller is to be told what was applied: it was not what it said.
    cut: bool,
}

impl Player<'_> {
    fn acknowledged(&mut self, ack: &OperatorAck) -> Result<()> {
        if let Some(cap) = self.caps.remove(&ack.request_id).filter(|_| ack.accepted) {
            self.cap = (cap > 0.0).then_some(cap);
            self.controller.set_speed_cap(operator::plan_cap(self.cap, self.controller))?;
        }
        Ok(())
    }

    fn answer(&mut self, command: &ActuationCommand) {
        let drives = command.mode == ActuationCommand::MODE_DRIVE;
        let answered = (BootId::new(command.state_boot_id), SeqNumber::new(command.state_seq));
        let Some(state) = self.states.get(&answered) else {
            self.found.without_state += u64::from(drives);
            return;
        };
        let (boot_id, meas_mono_ns) = (state.h.sender_start(), state.meas_mono_ns);
        if let Some(last) =
            self.last.filter(|l| (l.boot_id, l.meas_mono_ns) == (boot_id, meas_mono_ns))
            && (if drives { last.stepped } else { last.seq == state.h.number() })
        {
            // The same measurement again, or no new one to answer: no step.
            return;
        }
        if self.last.is_none_or(|last| last.boot_id != boot_id) {
            self.schedule.restart(meas_mono_ns, state.h.mono_ns);
        }
        let input = self.last.map(|last| last.input).unwrap_or_default();
        let seq = state.h.number();
        let mut next = Last { boot_id, seq, meas_mono_ns, stepped: false, input, cut: true };
        let time_ns = self.schedule.time(meas_mono_ns);
        if let (true, Some(time_ns), Some(pose)) =
            (drives, time_ns, convert::pose(state, self.track_id))
        {
            let period = self.controller.config().horizon.period;
            let applied = self.last.filter(|last| last.cut).map(|last| last.input);
            let measurement = convert::measurement(pose, time_ns, period, applied);
            let wanted = self.controller.step(&measurement).input;
            let input = operator::capped(wanted, input, state.vx, self.cap, self.controller);
            next = Last { stepped: true, input, cut: input != wanted, ..next };
            self.compare(command, input);
        }
        self.last = Some(next);
    }

    fn compare(&mut self, command: &ActuationCommand, input: Input) {
        self.found.commands += 1;
        let same = input.a.to_bits() == command.accel.to_bits()
            && input.delta.to_bits() == command.steer.to_bits();
        self.found.identical += u64::from(same);
        if !same && self.found.first_difference.is_none() {
            self.found.first_difference = Some(command.h.number());
        }
    }
}
