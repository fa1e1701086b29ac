//! Learning model predictive control with error dynamics regression for autonomous racing
//! (Xue, Zhu, Dolan, Borrelli 2023).
//!
//! | in the paper | here |
//! |---|---|
//! | data D^j, cost-to-go | [`learning::dataset`] |
//! | safe set SS^j | [`learning::safe_set`] |
//! | error dynamics regression | [`learning::regression`] |
//! | FHOCP | [`fhocp`] |
//! | the loop | [`Controller`] |
#![forbid(unsafe_code)]
// The same bits on every machine: no function of the platform's mathematical library.
#![cfg_attr(not(test), deny(clippy::disallowed_methods))]

mod actuator;
mod affine;
pub mod config;
mod controller;
mod delay;
mod derive;
mod drive;
mod error;
pub mod fhocp;
mod filter;
mod lanes;
mod learn;
mod learned_model;
pub mod learning;
mod memory;
mod observe;
mod optimize;
mod plan;
mod presets;
mod recovery;
mod snapshot;
mod status;
mod store;

pub use affine::Affine;
pub use config::Config;
pub use controller::Controller;
pub use error::{ConfigError, DataError};
pub use learned_model::LearnedModel;
pub use plan::Plan;
pub use presets::Preset;
pub use snapshot::ControllerState;
pub use status::{
    Action, Command, LapKind, LapResult, Measurement, Phase, Pose, Probe, Reason, SolveStatus,
    Status,
};
pub use store::Learned;
