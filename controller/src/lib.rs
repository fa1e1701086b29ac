//! Learning model predictive control with error dynamics regression for autonomous racing
//! (Xue, Zhu, Dolan, Borrelli 2023).
#![forbid(unsafe_code)]

mod affine;
pub mod config;
mod error;
pub mod fhocp;
mod presets;
mod status;

pub use affine::Affine;
pub use config::Config;
pub use error::ConfigError;
pub use presets::Preset;
pub use status::{
    Action, Command, LapKind, LapResult, Measurement, Phase, Pose, Probe, Reason, SolveStatus,
    Status,
};
