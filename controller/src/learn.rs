//! Lap-end learning, and learned data from one day to the next.

use std::sync::Arc;

use vehicle_model::Outline;

use crate::config::{NominalModel, RegressionMode, Selection};
use crate::controller::{Controller, Setup};
use crate::error::DataError;
use crate::learning::dataset::Lap;
use crate::learning::envelope::{Envelope, NearMiss, REMEMBERED};
use crate::learning::grip;
use crate::learning::regression::{RegressionData, Targets};
use crate::memory::Memory;
use crate::status::LapKind;
use crate::store::{self, Identity, Learned};

impl Controller {
    /// Lap-end work: grip, safe-set laps, regression targets and tree.
    pub(crate) fn learn(&mut self) {
        self.memory.lap_due = false;
        let delay = &self.setup.config.delay;
        if delay.estimate && delay.steps == 0 && !self.memory.learned && self.memory.learning {
            self.settle_delay();
        }
        self.memory.learned = self.memory.learning;
        self.weigh_ridge();
        let nominal = &self.setup.config.nominal;
        if nominal.adapt_grip && nominal.model == NominalModel::Dynamic {
            // A driver's laps are too slow and their noise is unknown: they say little of grip.
            let own = |lap: &&Arc<Lap>| lap.result.kind != LapKind::Driven;
            let laps = self.memory.dataset.laps.iter().rev().filter(own);
            let recent = laps.flat_map(|lap| lap.samples.iter().rev()).take(grip::SAMPLES);
            let fitted = {
                let (filter, estimate) = (&self.setup.filter, &self.memory.estimate);
                let noise = filter.as_ref().map(|filter| filter.velocity_noise(estimate));
                let noise = noise.unwrap_or_default();
                grip::fit(&self.setup.model, &self.setup.track, recent, noise)
            };
            // A new grip invalidates all residuals, so changes too small to matter are ignored.
            if grip::differ(fitted, self.memory.grip) {
                self.memory.grip = fitted;
                self.setup.model.model.grip = fitted;
            }
        }
        self.derive();
    }

    /// The ridge weight that the noise of the data asks for, at least the configured one.
    pub(crate) fn weigh_ridge(&mut self) {
        let asked = self.setup.filter.as_ref().map(|filter| filter.ridge(&self.memory.estimate));
        self.setup.regression.ridge =
            self.setup.config.regression.ridge.max(asked.unwrap_or_default());
    }

    /// Brings what follows from laps and grip up to date: the residuals of the new laps, or of all
    /// if the grip changed.
    pub(crate) fn derive(&mut self) {
        let (config, laps) = (&self.setup.config, &self.memory.dataset.laps);
        let fastest = config.safe_set.selection == Selection::Fastest;
        let selected = self.memory.dataset.select(config.safe_set.laps, fastest);
        let used = match config.regression.laps {
            0 => laps.len(),
            count => count.min(laps.len()),
        };
        let first = laps.len() - used;
        // A snapshot that shares them keeps its own.
        let mut derived = Arc::unwrap_or_clone(std::mem::take(&mut self.memory.derived));
        if derived.grip != self.memory.grip {
            derived.regression = RegressionData::new(&config.regression);
            derived.grip = self.memory.grip;
        }
        let chosen = selected.iter().map(|&i| &*laps[i]);
        let (car, track) = (&self.setup.car, &self.setup.track);
        let remembered = laps.len().saturating_sub(REMEMBERED);
        for lap in derived.searched.max(remembered)..laps.len() {
            self.find_near_misses(&mut derived.near_misses, lap);
        }
        derived.searched = laps.len();
        derived.near_misses.retain(|miss| miss.lap >= remembered);
        let misses = (&derived.near_misses[..], laps.len());
        derived.envelope =
            Envelope::new(&config.envelope, car, self.memory.grip, track, chosen, misses);
        derived.selected = selected;
        derived.regression.forget_before(first);
        for lap in derived.regression.next_lap(first)..laps.len() {
            derived.regression.add(lap, &self.targets(lap));
        }
        self.memory.derived = Arc::new(derived);
    }

    /// Where a learned lap used up the reserve beside the body.
    fn find_near_misses(&self, list: &mut Vec<NearMiss>, lap: usize) {
        let Setup { car, config, .. } = &self.setup;
        let limits = &config.limits;
        let reserve = limits.lane_margin - 0.5 * car.width;
        let of = &self.memory.dataset.laps[lap];
        // After an incident the car is slow: its speeds there are no measure.
        let raced = of.result.valid && of.result.kind == LapKind::Learning;
        if !config.envelope.active || !limits.body || reserve <= 0.0 || !raced {
            return;
        }
        let (outline, track) = (Outline::new(car), &self.setup.track);
        NearMiss::find(list, lap, of, |x| 1.0 + outline.overhang(track, x) / reserve);
    }

    /// What the regression learns from a lap.
    fn targets(&self, lap: usize) -> Targets {
        let (model, track) = (&self.setup.model, &self.setup.track);
        let error = self.setup.config.regression.mode == RegressionMode::Error;
        Targets::new(&self.memory.dataset.laps[lap], |x, u, next| {
            if !error {
                return next;
            }
            let f = model.next(x, u, track.road());
            [next[0] - f.v_x, next[1] - f.v_y, next[2] - f.omega_z]
        })
    }

    /// Everything learned, with the fingerprint of car, track and configuration; cheap to take, and
    /// good to be written by another thread while the controller drives on.
    #[must_use]
    pub fn learned_data(&self) -> Learned {
        Learned {
            identity: self.identity(),
            grip: self.memory.grip,
            delay: self.delay(),
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
        memory.dataset.laps = learned.laps;
        let learning = |lap: &&Arc<Lap>| lap.result.valid && lap.result.kind == LapKind::Learning;
        memory.learned_laps = memory.dataset.laps.iter().filter(learning).count() as u32;
        memory.learning = memory.initial_laps_done(self.setup.config.warm_up.laps);
        memory.learned = memory.learning;
        self.memory = memory;
        self.adopt_delay(learned.delay);
        self.setup.model.model.grip = learned.grip;
        self.derive();
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
