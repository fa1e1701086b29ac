//! One message of a network, decoded.

use lcm_types::{
    ActuationCommand, ActuationReport, Checked as _, Error, Header, Heartbeat, LapResult,
    Message as _, MpcTelemetry, OperatorAck, OperatorCommand, Setup, Track, VehicleState, channels,
};

/// A message of ours.
#[derive(Debug, Clone, PartialEq)]
pub enum Seen {
    /// On `CAR/STATE`.
    State(VehicleState),
    /// On `CAR/ACT`.
    Report(ActuationReport),
    /// On `LMPC/CMD` or `LMPC/CMD_DRY`.
    Command(ActuationCommand),
    /// On `LMPC/TELEM`.
    Step(MpcTelemetry),
    /// On `LMPC/LAP`.
    Lap(LapResult),
    /// On `MAP/TRACK`.
    Track(Track),
    /// On `LMPC/SETUP`.
    Setup(Setup),
    /// On `OP/CMD`.
    Order(OperatorCommand),
    /// On `OP/ACK`.
    Answer(OperatorAck),
    /// On `HB/`, with the name that follows.
    Beat(String, Heartbeat),
}

impl Seen {
    /// Decodes a message by its channel, checksum included; `None` on channels that are not ours.
    ///
    /// # Errors
    /// If the bytes are no message of the channel's type.
    #[must_use]
    pub fn read(channel: &str, bytes: &[u8]) -> Option<Result<Self, Error>> {
        Some(match channel {
            channels::STATE => VehicleState::open(bytes).map(Self::State),
            channels::ACTUATION => ActuationReport::open(bytes).map(Self::Report),
            channels::COMMAND | channels::COMMAND_DRY => {
                ActuationCommand::open(bytes).map(Self::Command)
            }
            channels::TELEMETRY => MpcTelemetry::decode(bytes).map(Self::Step),
            channels::LAP => LapResult::decode(bytes).map(Self::Lap),
            channels::TRACK => Track::open(bytes).map(Self::Track),
            channels::SETUP => Setup::open(bytes).map(Self::Setup),
            channels::OPERATOR => OperatorCommand::open(bytes).map(Self::Order),
            channels::OPERATOR_ACK => OperatorAck::decode(bytes).map(Self::Answer),
            other => {
                let name = other.strip_prefix(channels::HEARTBEAT)?;
                Heartbeat::decode(bytes).map(|beat| Self::Beat(name.to_owned(), beat))
            }
        })
    }

    /// Its sender, number and times.
    #[must_use]
    pub fn header(&self) -> &Header {
        match self {
            Self::State(m) => &m.h,
            Self::Report(m) => &m.h,
            Self::Command(m) => &m.h,
            Self::Step(m) => &m.h,
            Self::Lap(m) => &m.h,
            Self::Track(m) => &m.h,
            Self::Setup(m) => &m.h,
            Self::Order(m) => &m.h,
            Self::Answer(m) => &m.h,
            Self::Beat(_, m) => &m.h,
        }
    }
}
