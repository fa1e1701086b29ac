//! Options of `lmpc learn`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use driven_laps::InputChoice;

use super::ControllerArgs;

const EXAMPLES: &str = "\
Examples:
  lmpc learn drive.log --car barc --track l --out learned.lmpc
  lmpc race --load learned.lmpc               drives on from those laps, without warm-up laps
  lmpc serve --learned learned.lmpc
  lmpc learn out/race/trajectory.csv --out learned.lmpc
  lmpc learn kart.csv --car kart.toml --track circuit.csv --inputs reckoned --out learned.lmpc

Takes an event log of LCM with CAR/STATE, that channel exported as CSV, `trajectory.csv` of a race,
or any table with time, place and heading (docs/learn.md). Whoever drove: laps that left the track
with the body, or stood, are refused.";

/// Options of `lmpc learn`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct LearnArgs {
    /// Event log or table of the drive
    #[arg(value_name = "LOG|CSV")]
    pub file: PathBuf,
    /// Car, track and configuration; those of the race that goes on from the data.
    #[command(flatten)]
    pub controller: ControllerArgs,
    /// Where to keep the learned data; an earlier file stays as FILE.bak
    #[arg(long, value_name = "FILE")]
    pub out: PathBuf,
    /// Which recorded inputs are used
    #[arg(long, value_enum, default_value_t, value_name = "SOURCE")]
    pub inputs: InputsName,
    /// Take the states as they are
    #[arg(long)]
    pub no_smooth: bool,
    /// Channel of the states in a log
    #[arg(long, default_value = lcm_types::channels::STATE, value_name = "CHANNEL")]
    pub channel: String,
    /// Print the account as JSON
    #[arg(long)]
    pub json: bool,
}

/// Names of the sources of inputs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub enum InputsName {
    /// Those of the recording if it has any, else reckoned ones.
    #[default]
    Auto,
    /// The recording's, taken for commands: they act after the delay and the lag of the actuators.
    Commanded,
    /// The recording's, taken for what acted.
    Applied,
    /// Reckoned from the states by inverse dynamics.
    Reckoned,
}

impl From<InputsName> for InputChoice {
    fn from(name: InputsName) -> Self {
        match name {
            InputsName::Auto => Self::Auto,
            InputsName::Commanded => Self::Commanded,
            InputsName::Applied => Self::Applied,
            InputsName::Reckoned => Self::Reckoned,
        }
    }
}
