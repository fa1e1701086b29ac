//! Learning model predictive control with error dynamics regression for autonomous racing
//! (Xue, Zhu, Dolan, Borrelli 2023).
#![forbid(unsafe_code)]

pub mod config;
mod error;
mod presets;
mod status;

pub use config::Config;
pub use error::ConfigError;
pub use presets::Preset;
pub use status::{
    Action, Command, LapKind, LapResult, Measurement, Phase, Pose, Probe, Reason, SolveStatus,
    Status,
};
