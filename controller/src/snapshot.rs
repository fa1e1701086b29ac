//! Everything that changes while the controller runs: to roll back, or to resume another day.

use fhocp::SolverSeed;
use serde::{Deserialize, Serialize};

use crate::controller::Controller;
use crate::memory::Memory;

/// State of a [`Controller`]: all it learned, its plan, the lap in progress. Cloning it is cheap
/// however much was learned, as closed laps are shared.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct ControllerState {
    memory: Memory,
    solver: Option<SolverSeed>,
}

impl Controller {
    /// The state now.
    #[must_use]
    pub fn state(&self) -> ControllerState {
        ControllerState { memory: self.memory.clone(), solver: self.work.solver.seed() }
    }

    /// Goes on from a state of a controller with the same configuration, car and track, bit for
    /// bit. The caller sees to it that they are the same.
    pub fn resume(&mut self, state: &ControllerState) {
        self.memory = state.memory.clone();
        self.apply_learned();
        // What follows from the laps is not written with the state.
        if !self.memory.derived.made {
            self.restore_derived();
        }
        self.work.solver.restore(state.solver.as_ref());
        self.prepared = false;
    }
}
