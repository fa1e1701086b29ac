//! The simulated car of `vehicle_model`.

use std::sync::Arc;

use vehicle_model::{CarParams, Disturbance, Input, Plant, State, Track};

use super::{Vehicle, VehicleError};

impl Vehicle for Plant {
    fn measure(&mut self) -> State {
        self.measure()
    }

    fn truth(&self) -> State {
        self.truth()
    }

    fn apply(&mut self, u: Input, dt: f64) -> Result<(), VehicleError> {
        self.apply(u, dt);
        Ok(())
    }

    fn applied(&self) -> Input {
        self.applied()
    }

    fn disturbance(&self) -> Option<&Disturbance> {
        Some(&self.params().disturbance)
    }

    fn disturb(&mut self, disturbance: Disturbance) -> Result<(), VehicleError> {
        self.set_disturbance(disturbance).map_err(|e| VehicleError::Disturb(e.to_string()))
    }

    fn progress(&self) -> f64 {
        self.progress()
    }

    fn lap(&self) -> i64 {
        self.lap()
    }

    fn track(&self) -> &Arc<Track> {
        self.track()
    }

    fn car(&self) -> &CarParams {
        &self.params().car
    }
}
