//! What goes into the core and what comes out.

use lcm_types::{ActuationReport, BootId, Heartbeat, SeqNumber};
use vehicle_model::{Limited, State};

use super::command::{DecodedCommand, Reject};
use super::order::{Denied, Order};
use super::rules::Setup;

/// States of the bridge; their numbers are those of [`Heartbeat`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[repr(i8)]
pub enum BridgeState {
    /// Nothing is known of the car.
    #[default]
    Boot = Heartbeat::BOOT,
    /// Holds the car.
    Idle = Heartbeat::IDLE,
    /// A controller holds the grant; the car is held.
    Armed = Heartbeat::ARMED,
    /// The controller drives.
    Running = Heartbeat::RUNNING,
    /// Brakes along the track; IDLE at standstill.
    SafeStop = Heartbeat::SAFE_STOP,
    /// The car failed; ends by reset.
    Fault = Heartbeat::FAULT,
    /// Emergency stop; ends by reset at standstill.
    Estop = Heartbeat::ESTOP,
}

impl BridgeState {
    /// As people read it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Boot => "BOOT",
            Self::Idle => "IDLE",
            Self::Armed => "ARMED",
            Self::Running => "RUNNING",
            Self::SafeStop => "SAFE_STOP",
            Self::Fault => "FAULT",
            Self::Estop => "ESTOP",
        }
    }

    /// The same of a state in a message, which may be none of these.
    #[must_use]
    pub fn name_of(state: i8) -> &'static str {
        use BridgeState::{Armed, Boot, Estop, Fault, Idle, Running, SafeStop};
        let all = [Boot, Idle, Armed, Running, SafeStop, Fault, Estop];
        all.into_iter()
            .find(|bridge_state| *bridge_state as i8 == state)
            .map_or("unknown", Self::name)
    }
}

/// Where the applied input comes from; the numbers of `CAR/ACT`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[repr(i8)]
pub enum InputSource {
    /// Nobody: the car is held.
    #[default]
    None = ActuationReport::NOBODY,
    /// The command in force.
    Command = ActuationReport::COMMAND,
    /// Its fallback plan.
    Plan = ActuationReport::PLAN,
    /// The safe stop.
    Stop = ActuationReport::SAFE_STOP,
}

/// What happens to the bridge.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum BridgeEvent<'a> {
    /// The car's state in the track's frame, with its quality as in [`lcm_types::VehicleState`].
    State(State, i8),
    /// A command that passed [`super::decode`].
    Command(&'a DecodedCommand),
    /// Heartbeat of the controller with this boot id.
    Heartbeat(BootId),
    /// The controller with this boot id was set up so.
    Setup(BootId, Setup),
    /// The state with this sequence number went out to the controller.
    Published(SeqNumber),
    /// The operator.
    Order(Order),
    /// The car failed.
    CarFailed,
    /// The bridge is to end: a car that drives is stopped first.
    End,
    /// Time to act.
    Tick,
    /// The car has the last tick's input. A host that is held up between the two says so, and the
    /// input's rate is counted from here.
    Sent,
}

/// What became of an event.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Answer {
    /// Nothing to say.
    #[default]
    None,
    /// Believed, or obeyed.
    Accepted,
    /// A command that was not believed, or a heartbeat of another controller than the armed one.
    Rejected(Reject),
    /// An order that was not obeyed.
    Denied(Denied),
}

/// What the car gets, and what there is to say.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Output {
    /// Input to apply from this event on, and what was asked; new with each [`BridgeEvent::Tick`].
    pub applied: Limited,
    /// Where it comes from.
    pub source: InputSource,
    /// What became of the event.
    pub answer: Answer,
}

/// Commands so far, by what became of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct CommandCounts {
    /// Believed. \[-\]
    pub ok: i64,
    /// Refused by number or sender, and heartbeats of another controller than the armed one. \[-\]
    pub old: i64,
    /// Refused by age. \[-\]
    pub stale: i64,
    /// Refused by anything else. \[-\]
    pub bad: i64,
    /// Of those in `bad`: another type, or another version of it. \[-\]
    pub wrong_type: i64,
    /// Missing by the numbers. \[-\]
    pub lost: i64,
    /// Ticks with an input that a limit moved. \[-\]
    pub limited: i64,
    /// Stops so far. \[-\]
    pub stops: i64,
}
