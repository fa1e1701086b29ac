//! Names of the channels: one type on each, at most [`MAX_LENGTH`] bytes.

/// [`VehicleState`](crate::VehicleState).
pub const STATE: &str = "CAR/STATE";
/// [`ActuationReport`](crate::ActuationReport).
pub const ACTUATION: &str = "CAR/ACT";
/// [`ActuationCommand`](crate::ActuationCommand).
pub const COMMAND: &str = "LMPC/CMD";
/// [`ActuationCommand`](crate::ActuationCommand) of a dry run: what would be asked of the car.
pub const COMMAND_DRY: &str = "LMPC/CMD_DRY";
/// [`MpcTelemetry`](crate::MpcTelemetry).
pub const TELEMETRY: &str = "LMPC/TELEM";
/// [`LapResult`](crate::LapResult).
pub const LAP: &str = "LMPC/LAP";
/// [`Heartbeat`](crate::Heartbeat): this prefix and the name of the program.
pub const HEARTBEAT: &str = "HB/";
/// [`OperatorCommand`](crate::OperatorCommand).
pub const OPERATOR: &str = "OP/CMD";
/// [`OperatorAck`](crate::OperatorAck).
pub const OPERATOR_ACK: &str = "OP/ACK";
/// [`Setup`](crate::Setup).
pub const SETUP: &str = "LMPC/SETUP";
/// [`Track`](crate::Track).
pub const TRACK: &str = "MAP/TRACK";
/// [`Hello`](crate::Hello).
pub const HELLO: &str = "AUTH/HELLO";

/// Longest name LCM allows. \[B\]
pub const MAX_LENGTH: usize = 63;

/// True for a name every LCM implementation takes: 1 to 63 bytes, none of them a space or a control
/// character.
///
/// ```
/// use lcm_types::channels::is_valid;
/// assert!(is_valid("CAR1/STATE") && !is_valid("") && !is_valid("A\0B"));
/// ```
#[must_use]
pub fn is_valid(channel: &str) -> bool {
    (1..=MAX_LENGTH).contains(&channel.len())
        && !channel.chars().any(|c| c.is_control() || c.is_whitespace())
}
