//! The messages of the racing LMPC on an LCM network.
//!
//! The types are generated from the `.lcm` files in `lcm/`, the same files from which `lcm-gen`
//! makes the C, Python and Java side. Units and frames stand with each field: SI, radians,
//! ISO 8855 (x forward, y left, angles and curvature positive to the left).
//!
//! | type | channel | from → to |
//! |---|---|---|
//! | [`VehicleState`] | [`channels::STATE`] | car → controller |
//! | [`ActuationCommand`] | [`channels::COMMAND`] | controller → car |
//! | [`ActuationReport`] | [`channels::ACTUATION`] | car → all |
//! | [`MpcTelemetry`] | [`channels::TELEMETRY`] | controller → all |
//! | [`LapResult`] | [`channels::LAP`] | controller → all |
//! | [`Heartbeat`] | [`channels::HEARTBEAT`] + name | each program → all |
//! | [`OperatorCommand`] | [`channels::OPERATOR`] | operator → car, controller |
//! | [`OperatorAck`] | [`channels::OPERATOR_ACK`] | car, controller → operator |
//! | [`Hello`] | [`channels::HELLO`] | each program with a key → each other |
//! | [`Setup`] | [`channels::SETUP`] | controller → bridge |
//! | [`Track`] | [`channels::TRACK`] | controller → all |
//!
//! Bytes from a network are not trusted: [`Message::decode`] returns a value or an [`Error`], and
//! never reserves more memory than the bytes at hand account for.
//!
//! ```
//! use lcm_types::{Checked, VehicleState};
//! let state = VehicleState { vx: 2.5, ..VehicleState::default() };
//! let mut bytes = Vec::new();
//! state.seal_into(&mut bytes)?; // with the CRC in its last field
//! assert_eq!(VehicleState::open(&bytes)?.vx, 2.5);
//! # Ok::<(), lcm_types::Error>(())
//! ```
#![forbid(unsafe_code)]

mod arrival;
pub mod channels;
pub mod crc;
mod error;
pub mod eventlog;
mod ids;
mod message;
#[cfg(test)]
mod message_tests;
mod plan;
pub mod schema;
pub mod signature;
pub mod value;
pub mod wire;

pub use arrival::Arrival;
pub use error::Error;
pub use ids::{ArmToken, BootId, LapIndex, MonoTime, SeqNumber};
pub use message::{Checked, Message};
pub use plan::plan_step;

// What the file of random messages, shared with an example, calls this crate.
#[cfg(test)]
extern crate self as lcm_types;

include!(concat!(env!("OUT_DIR"), "/messages.rs"));

/// A type with every feature of the language.
#[cfg(test)]
#[allow(missing_docs, unreachable_pub, reason = "types of the tests")]
#[allow(clippy::useless_conversion, reason = "lengths are converted whatever their type")]
mod sample {
    include!(concat!(env!("OUT_DIR"), "/sample.rs"));
}
