//! What a closed lap requires, in pieces: one in each step that follows, until all is done.
//!
//! | stage | a piece | |
//! |---|---|---|
//! | smoothing | samples of the lap | [`smooth`](crate::filter) |
//! | near misses | samples of the lap | [`envelope`](crate::learning::envelope) |
//! | grip | samples of the fit | [`grip`](crate::learning::grip) |
//! | data | samples of the regression's laps | `targets.rs`, [`regression`](crate::learning::regression) |
//! | envelope | all of it | [`envelope`](crate::learning::envelope) |
//!
//! A piece is [`Setup::piece`] samples: a number, not a time, so that results do not depend on the
//! machine, and a multiple of the horizon, so that a piece costs about what linearising along the
//! horizon costs. Grip, regression data, envelope and safe set change together with the last piece:
//! a safe set that is faster than the envelope allows leads plans astray.

mod grip;
mod restore;
mod targets;
#[cfg(test)]
mod tests;

use std::sync::Arc;

use actuators::Actuators;
use serde::{Deserialize, Serialize};
use vehicle_model::{Input, Outline, State};

use crate::controller::{Controller, Setup};
use crate::learning::dataset::{Lap, select};
use crate::learning::envelope::{Driven, Envelope, NearMiss, REMEMBERED};
use crate::learning::grip::Fit;
use crate::learning::regression::RegressionData;
use crate::learning::road_speed::RoadSpeed;
use crate::memory::Inherited;
use crate::road::DRY;
use crate::status::LapKind;

/// Samples of a piece for each stage of the horizon.
const SHARE: usize = 6;

/// How far the work is.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub(crate) struct LapEnd {
    /// Number of laps that grip, regression data and envelope in force are made of.
    pub(crate) learned: usize,
    stage: Stage,
    /// Number of laps that those in the making are made of.
    laps: usize,
    /// Lap in work, and its samples that are done.
    lap: usize,
    at: usize,
    fit: Fit,
    /// Grip in the making.
    grip: [f64; 2],
    /// Share of it since the last fall, in the making.
    share: Option<f64>,
    /// Near misses of the latest laps.
    misses: Vec<NearMiss>,
    /// Regression data in the making, where those in force cannot grow.
    #[serde(skip)]
    data: Option<Arc<RegressionData>>,
    /// Memory of a piece.
    #[serde(skip)]
    points: Vec<(State, Input)>,
    #[serde(skip)]
    targets: Vec<[f64; 3]>,
    /// The grip is known already.
    #[serde(skip)]
    fitted: bool,
    /// Samples taken into work so far, for tests.
    #[serde(skip)]
    pub(crate) done: usize,
}

/// What is in work.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
enum Stage {
    #[default]
    Idle,
    Misses,
    Fit,
    FitShare,
    Data,
    Envelope,
}

/// What follows from the laps and the grip.
#[derive(Debug, Clone, Default)]
pub(crate) struct Derived {
    pub(crate) regression: Arc<RegressionData>,
    pub(crate) envelope: Arc<Envelope>,
    pub(crate) road_speed: Arc<RoadSpeed>,
    /// False after reading a state from bytes, which do not hold any of it.
    pub(crate) made: bool,
}

impl Setup {
    /// Samples of a piece.
    pub(crate) fn piece(&self) -> usize {
        SHARE * self.config.horizon.steps
    }

    /// The first of the laps whose data the regression uses, of `count`.
    fn first_lap(&self, count: usize) -> usize {
        match self.config.regression.laps {
            0 => 0,
            used => count.saturating_sub(used),
        }
    }
}

impl Controller {
    /// Whether a closed lap is still being learned from. What [`Controller::save`] gives then holds the
    /// lap, but as it was before smoothing, and the grip of the laps before.
    #[must_use]
    pub fn learning_pending(&self) -> bool {
        let memory = &self.memory;
        let LapEnd { learned, stage, .. } = memory.lap_end;
        memory.smoothing.is_some() || stage != Stage::Idle || learned < memory.dataset.laps.len()
    }

    /// Learns all that is left to be learned from closed laps at once, as hosts do that end and save,
    /// or have all the time there is.
    pub fn finish_learning(&mut self) {
        while self.learning_pending() {
            self.learn_piece();
            self.prepared = false;
        }
    }

    /// Learns from all laps at once, with a grip that is known.
    pub(crate) fn learn_with(&mut self, grip: [f64; 2]) {
        self.begin_learning();
        self.memory.grip = grip;
        self.memory.lap_end.fitted = true;
        self.finish_learning();
        self.memory.lap_end.fitted = false;
    }

    /// One piece of what closed laps still require.
    pub(crate) fn learn_piece(&mut self) {
        let piece = self.setup.piece();
        if self.memory.smoothing.is_some() {
            self.memory.lap_end.done += self.memory.smooth(piece, &self.setup.track);
            return;
        }
        match self.memory.lap_end.stage {
            Stage::Idle if self.memory.lap_end.learned == self.memory.dataset.laps.len() => {
                self.seek_response();
            }
            Stage::Idle => self.begin_learning(),
            Stage::Misses => self.search_misses(piece),
            Stage::Fit => self.fit_grip(piece),
            Stage::FitShare => self.fit_share(piece),
            Stage::Data => self.take_data(piece),
            Stage::Envelope => self.change_over(),
        }
    }

    /// Takes all closed laps into work.
    pub(crate) fn begin_learning(&mut self) {
        let now = !self.memory.learned && self.memory.learning;
        if self.setup.config.delay.estimates() && now && !self.settle_response() {
            return;
        }
        let work = &mut self.memory.lap_end;
        work.laps = self.memory.dataset.laps.len();
        let remembered = work.laps.saturating_sub(REMEMBERED);
        (work.lap, work.at) = (work.learned.max(remembered), 0);
        work.stage = Stage::Misses;
    }

    /// Where learned laps used up the reserve beside the body.
    fn search_misses(&mut self, piece: usize) {
        let Setup { car, config, track, .. } = &self.setup;
        let work = &mut self.memory.lap_end;
        let limits = &config.limits;
        let reserve = limits.lane_margin - 0.5 * car.width;
        let wanted = config.envelope.active && limits.body && reserve > 0.0;
        let raced = |lap: &Lap| lap.result.valid && lap.result.kind == LapKind::Learning;
        while work.lap < work.laps {
            let lap = &self.memory.dataset.laps[work.lap];
            // After an incident the car is slow: its speeds there are no measure.
            if wanted && raced(lap) && work.at < lap.samples.len() {
                let end = (work.at + piece).min(lap.samples.len());
                let samples = &lap.samples[work.at..(end + 1).min(lap.samples.len())];
                let outline = Outline::new(car);
                let used = |x: &State| 1.0 + outline.overhang(track, x) / reserve;
                NearMiss::find(&mut work.misses, work.lap, samples, used);
                work.done += end - work.at;
                work.at = end;
                return;
            }
            (work.lap, work.at) = (work.lap + 1, 0);
        }
        self.choose_samples();
    }

    /// Data in force that lack nothing but laps grow; others are made anew beside them.
    pub(crate) fn begin_data(&mut self) {
        let work = &mut self.memory.lap_end;
        let first = self.setup.first_lap(work.laps);
        let same = self.setup.first_lap(work.learned) == first && work.grip == self.memory.grip;
        let grows = same && work.learned > 0 && work.share.is_none();
        work.data = (!grows).then(|| Arc::new(RegressionData::new(&self.setup.config.regression)));
        (work.lap, work.at) = (if grows { work.learned } else { first }, 0);
        work.stage = Stage::Data;
    }

    /// Brings samples into the regression data.
    fn take_data(&mut self, mut piece: usize) {
        let laps = &self.memory.dataset.laps;
        let work = &mut self.memory.lap_end;
        while work.lap < work.laps {
            let lap = &laps[work.lap];
            if work.at < lap.samples.len() {
                let range = work.at..(work.at + piece).min(lap.samples.len());
                work.done += range.len();
                piece -= range.len();
                work.at = range.end;
                let data = work.data.as_mut().unwrap_or(&mut self.memory.derived.regression);
                // A snapshot that shares them keeps its own.
                let memory = (&mut work.points, &mut work.targets);
                let history = &self.memory.road.history;
                let share = |sample| history.at_revised(work.lap, sample, work.share);
                self.setup.add(Arc::make_mut(data), lap, range, (work.grip, &share), memory);
                if piece == 0 {
                    return;
                }
                continue;
            }
            (work.lap, work.at) = (work.lap + 1, 0);
        }
        work.stage = Stage::Envelope;
    }

    /// The last piece: what was made comes into force.
    fn change_over(&mut self) {
        let work = &mut self.memory.lap_end;
        let laps = &self.memory.dataset.laps;
        for lap in work.learned..work.laps {
            select(&mut self.memory.selected, laps, lap, &self.setup.config.safe_set);
        }
        (work.stage, work.learned) = (Stage::Idle, work.laps);
        let remembered = work.laps.saturating_sub(REMEMBERED);
        work.misses.retain(|miss| miss.lap >= remembered);
        self.memory.grip = work.grip;
        if let Some(share) = work.share.take() {
            self.memory.road.revise(share);
        }
        if let Some(data) = work.data.take() {
            self.memory.derived.regression = data;
        }
        self.memory.learned |= self.memory.learning && work.laps == self.memory.dataset.laps.len();
        let asked = self.setup.filter.as_ref().map(|filter| filter.ridge(&self.memory.estimate));
        let Inherited { laps, ridge } = self.memory.inherited;
        let used = self.setup.first_lap(self.memory.lap_end.laps) < laps;
        self.memory.ridge = asked.unwrap_or_default().max(if used { ridge } else { 0.0 });
        self.apply_learned();
        self.make_envelope();
    }

    /// Grip, ridge and actuators as they are in force.
    pub(crate) fn apply_learned(&mut self) {
        let dt = self.setup.config.horizon.period;
        self.setup.actuators = Actuators::new(&self.setup.car, dt, self.response());
        self.work.set_lag(self.setup.actuators.carried());
        let share = self.memory.road.share;
        self.setup.model.model.grip = self.memory.grip.map(|grip| share * grip);
        self.setup.regression.ridge = self.setup.config.regression.ridge.max(self.memory.ridge);
    }

    /// The envelope of the laps that are learned from.
    fn make_envelope(&mut self) {
        let Setup { car, config, track, bends, .. } = &self.setup;
        let work = &self.memory.lap_end;
        let laps = &self.memory.dataset.laps[..work.learned];
        // Of a state that was read in the midst of learning, those of later laps are not yet in force.
        let known = |miss: &&NearMiss| miss.lap < laps.len();
        let misses: Vec<NearMiss> = work.misses.iter().filter(known).copied().collect();
        let misses = (&misses[..], laps.len());
        let chosen = self.memory.selected.iter().map(|&i| {
            let (samples, length) = (&laps[i].samples[..], track.length());
            // At most the number of samples, which fits isize.
            let seen = |index| self.memory.dataset.seen_from(i, index, length);
            Driven { samples, before: seen(-1), behind: seen(samples.len() as isize) }
        });
        let grip = self.memory.grip;
        let envelope = Envelope::new(&config.envelope, car, grip, (track, bends), chosen, misses);
        self.memory.derived.envelope = Arc::new(envelope);
        self.make_road_speed();
    }

    /// What the road allows, if it has less grip than was fitted.
    pub(crate) fn make_road_speed(&mut self) {
        let (memory, Setup { car, track, bends, .. }) = (&self.memory, &self.setup);
        let best = memory.selected.first().filter(|_| memory.road.share < DRY);
        let bound = best.map(|&best| {
            let driven = |sample| memory.road.history.at(best, sample);
            let grip = (memory.grip, memory.road.share);
            RoadSpeed::new(car, (track, bends), grip, &memory.dataset.laps[best], driven)
        });
        self.memory.derived.road_speed = Arc::new(bound.unwrap_or_default());
    }
}
