//! Learned data from one day to the next.

use std::sync::Arc;

use crate::controller::Controller;
use crate::error::DataError;
use crate::learning::dataset::Lap;
use crate::memory::{Inherited, Memory};
use crate::status::LapKind;
use crate::store::{self, Identity, Learned};

impl Controller {
    /// Everything learned, with the fingerprint of car, track and configuration; cheap to take, and
    /// good to be written by another thread while the controller drives on.
    #[must_use]
    pub fn learned_data(&self) -> Learned {
        Learned {
            identity: self.identity(),
            grip: self.memory.grip,
            delay: self.delay(),
            ridge: self.memory.ridge,
            laps: self.memory.dataset.laps.clone(),
        }
    }

    /// What [`Learned::write`] writes, as bytes.
    #[must_use]
    pub fn save(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        let Ok(()) = self.learned_data().write(|piece| {
            bytes.extend_from_slice(piece);
            Ok::<_, std::convert::Infallible>(())
        });
        bytes
    }

    /// Takes over what [`Controller::save`] wrote, in place of what was learned so far.
    ///
    /// # Errors
    /// [`DataError`] for damaged data or those of another car, track or configuration; nothing
    /// is changed then.
    pub fn load(&mut self, bytes: &[u8]) -> Result<(), DataError> {
        let learned: Learned = store::open(bytes)?;
        self.identity().accept(&learned.identity)?;
        let mut memory = Memory::new(&self.setup.config);
        memory.grip = learned.grip;
        memory.inherited = Inherited { laps: learned.laps.len(), ridge: learned.ridge };
        memory.dataset.laps = learned.laps;
        let learning = |lap: &&Arc<Lap>| lap.result.valid && lap.result.kind == LapKind::Learning;
        memory.learned_laps = memory.dataset.laps.iter().filter(learning).count() as u32;
        memory.learning = memory.initial_laps_done(self.setup.config.warm_up.laps);
        memory.learned = memory.learning;
        self.memory = memory;
        self.adopt_delay(learned.delay);
        self.learn_with(learned.grip);
        self.prepared = false;
        Ok(())
    }

    fn identity(&self) -> Identity {
        Identity::new(
            self.setup.car.fingerprint(),
            self.setup.track.fingerprint(),
            &self.setup.config,
        )
    }
}
