//! Laps that a person, or another program, drove: from a recording to data to learn from.
//!
//! recording -> stretches without gaps -> smoothed, one state a control period -> frame of the
//! track -> inputs, recorded or reckoned -> [`controller::Controller::adopt`].

mod drive;
mod inputs;
mod log;
mod signal;
pub mod smooth;
mod table;

use std::path::Path;

use anyhow::{Context as _, Result, bail};
use controller::Pose;
use vehicle_model::Input;

pub use drive::{LapAccount, ResampledDrive, drive};

/// What a file says of a drive, in the order of time.
#[derive(Debug, Clone, Default)]
pub struct Recording {
    /// The states.
    pub states: Vec<Recorded>,
    /// The inputs, each from its time on \[s\].
    pub inputs: Vec<(f64, Input)>,
    /// Whether the inputs are those that acted; else they were commanded, and act after the delay
    /// and the lag of the actuators.
    pub applied: bool,
    /// Rows or messages that could not be used.
    pub unusable: u64,
}

/// One recorded state.
#[derive(Debug, Clone, Copy)]
pub struct Recorded {
    /// When \[s\].
    pub time: f64,
    /// Where; its velocities are not used.
    pub pose: Pose,
    /// Velocities [v_x, v_y, omega_z], where they were measured \[m/s, m/s, rad/s\].
    pub velocities: Option<[f64; 3]>,
    /// Steering angle, where it was measured \[rad\].
    pub steer: Option<f64>,
}

/// Which recorded inputs are used.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum InputChoice {
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

/// Longest interval of the states: what the car does between states further apart is unknown [s].
const MOST_INTERVAL: f64 = 2.0;

/// Reads an event log of LCM or a table in CSV.
///
/// # Errors
/// If the file cannot be read, or holds no states.
pub fn read(path: &Path, channel: &str) -> Result<Recording> {
    let shown = || path.display().to_string();
    let mut recording = if log::is_log(path).with_context(|| format!("cannot read {}", shown()))? {
        log::read(path, channel)?
    } else {
        table::read(path)?
    };
    recording.states.sort_by(|a, b| a.time.total_cmp(&b.time));
    recording.inputs.sort_by(|a, b| a.0.total_cmp(&b.0));
    let before = recording.states.len();
    recording.states.dedup_by(|later, earlier| later.time <= earlier.time);
    recording.unusable += (before - recording.states.len()) as u64;
    let interval = drive::median_interval(&recording.states);
    if recording.states.len() > 1 && interval > MOST_INTERVAL {
        bail!(
            "{}: the states are {interval:.1} s apart, expected at most {MOST_INTERVAL} s; check that \
             the times are in seconds",
            shown()
        );
    }
    Ok(recording)
}
