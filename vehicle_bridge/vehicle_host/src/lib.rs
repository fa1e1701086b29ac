//! Simulated vehicles, whatever computes them: what a host drives.

pub mod fmu;
mod plant;

use std::sync::Arc;

use vehicle_model::{CarParams, Disturbance, Input, State, Track};

/// Why a simulated vehicle cannot go on.
#[derive(Debug, thiserror::Error)]
pub enum VehicleError {
    /// What computes it refused a step.
    #[error("the vehicle {name} failed at {time:.3} s: {reason}")]
    Step {
        /// Which vehicle.
        name: String,
        /// Its time. \[s\]
        time: f64,
        /// What it says.
        reason: String,
    },
    /// What is to act on it is out of range, or cannot be changed.
    #[error("what acts on the vehicle: {0}")]
    Disturb(String),
}

/// A simulated vehicle on a track. States are in the track's frame with s wrapped into the lap.
pub trait Vehicle: Send {
    /// What the sensors say now. Noise is drawn anew with each call.
    fn measure(&mut self) -> State;

    /// The true state.
    fn truth(&self) -> State;

    /// Drives with a command for `dt` seconds; a `dt` that is not above 0 changes nothing.
    ///
    /// # Errors
    /// [`VehicleError`] if what computes the vehicle fails; its state is then not defined.
    fn apply(&mut self, u: Input, dt: f64) -> Result<(), VehicleError>;

    /// The input that really acted last.
    fn applied(&self) -> Input;

    /// What acts on it beside its inputs; none where that cannot be changed.
    fn disturbance(&self) -> Option<&Disturbance> {
        None
    }

    /// Changes what acts on it beside its inputs, from now on.
    ///
    /// # Errors
    /// [`VehicleError`] if that is out of range, or cannot be changed.
    fn disturb(&mut self, _disturbance: Disturbance) -> Result<(), VehicleError> {
        Err(VehicleError::Disturb("this vehicle's surroundings cannot be changed".to_owned()))
    }

    /// Way along the track since s = 0 of lap 0, growing over the laps. \[m\]
    fn progress(&self) -> f64;

    /// Number of times the line has been crossed; negative if it was crossed backwards. \[-\]
    #[expect(clippy::cast_possible_truncation, reason = "laps are few")]
    fn lap(&self) -> i64 {
        (self.progress() / self.track().length()).floor() as i64
    }

    /// The track it drives on.
    fn track(&self) -> &Arc<Track>;

    /// The car it stands for: its limits, and the tyres its slips are judged by. Where the
    /// vehicle's inside is unknown, this is the nominal car.
    fn car(&self) -> &CarParams;
}
