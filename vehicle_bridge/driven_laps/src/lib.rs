//! Laps that a person, or another program, drove: from a recording to data to learn from.
//!
//! recording -> stretches without gaps -> smoothed, one state a control period -> frame of the
//! track -> inputs, recorded or reckoned -> [`controller::Controller::adopt`].

mod clock;
mod drive;
mod inputs;
mod left_out;
mod log;
mod signal;
pub mod smooth;
mod table;
#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "code of tests")]
mod tests;

use std::borrow::Cow;
use std::path::Path;

use anyhow::{Context as _, Result, bail};
use controller::Pose;
use vehicle_model::Input;

pub use drive::{LapAccount, ResampledDrive, drive};
pub use left_out::LeftOut;

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
    /// What the rows are: lines of a table or messages of a log.
    pub rows: &'static str,
    /// Rows that could not be used.
    pub left_out: LeftOut,
    /// Rows whose inputs could not be used: those before them hold.
    pub inputs_left_out: LeftOut,
    /// What states lack of velocities and steering angle, by their rows.
    lacks: Vec<(u64, Cow<'static, str>)>,
}

impl Recording {
    /// Leaves out states without what most others have.
    fn drop_incomplete(&mut self, has: impl Fn(&Recorded) -> bool) {
        let lacking = self.states.iter().filter(|state| !has(state)).count();
        if lacking == 0 || 2 * lacking > self.states.len() {
            return;
        }
        for state in self.states.iter().filter(|state| !has(state)) {
            let place = self.lacks.binary_search_by_key(&state.row, |(row, _)| *row);
            let reason = place.map_or("no value", |place| &*self.lacks[place].1);
            self.left_out.add(state.row, reason);
        }
        self.states.retain(has);
    }
}

/// One recorded state.
#[derive(Debug, Clone, Copy)]
pub struct Recorded {
    /// When \[s\].
    pub time: f64,
    /// Line of the table, or number of the message in the log, from 1.
    pub row: u64,
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

/// Times may go back by this much, as messages overtake each other; the clock of a drive does not [s].
const MOST_BACK: f64 = 1.0;

/// The states between which the clock was set back; none if all go backwards, as in a table whose
/// latest row comes first.
fn set_back(states: &[Recorded]) -> Option<(&Recorded, &Recorded)> {
    let pairs = || states.iter().zip(states.iter().skip(1));
    let back = pairs().filter(|(before, after)| after.time < before.time).count();
    if 2 * back > states.len() {
        return None;
    }
    pairs().find(|(before, after)| before.time - after.time > MOST_BACK)
}

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
    recording.drop_incomplete(|state| state.velocities.is_some());
    recording.drop_incomplete(|state| state.steer.is_some());
    recording.lacks.clear();
    if let Some((before, after)) = set_back(&recording.states) {
        bail!(
            "{}, {} {}: the time goes back by {:.1} s there, expected one drive; cut the file into \
             one for each drive",
            shown(),
            recording.rows.trim_end_matches('s'),
            after.row,
            before.time - after.time
        );
    }
    recording.states.sort_by(|a, b| a.time.total_cmp(&b.time));
    recording.inputs.sort_by(|a, b| a.0.total_cmp(&b.0));
    let Recording { states, left_out, .. } = &mut recording;
    states.dedup_by(|later, earlier| {
        let again = later.time <= earlier.time;
        if again {
            left_out.add(later.row, "the time of another");
        }
        again
    });
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
