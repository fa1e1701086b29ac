//! Grip of the laps, or, on a road that has become slippery, the share of it that the last lap had.

use super::Stage;
use crate::config::NominalModel;
use crate::controller::Controller;
use crate::learning::grip;
use crate::road::DRY;
use crate::status::LapKind;

/// Share given back after a lap at most.
const MOST_RISE: f64 = 0.1;
/// Shares that differ by less than this are the same.
const SAME: f64 = 0.01;

impl Controller {
    /// Begins the fit of the grip, if it is wanted.
    pub(super) fn choose_samples(&mut self) {
        let nominal = &self.setup.config.nominal;
        let slippery = self.slippery_lap();
        let work = &mut self.memory.lap_end;
        work.grip = self.memory.grip;
        if work.fitted || !nominal.adapt_grip || nominal.model != NominalModel::Dynamic {
            return self.begin_data();
        }
        if self.memory.estimate.filters() {
            if let Some(fitted) = self.memory.grip_sums.grip([1.0; 2])
                && grip::differ(fitted, self.memory.grip)
            {
                work.grip = fitted;
            }
            let share = self.memory.road.share;
            let in_force = self.memory.grip.map(|grip| share * grip);
            // Of each lap anew: the first ones since the fall may have had another share.
            let lap = std::mem::take(&mut self.memory.road.of_lap);
            if let Some(fitted) = lap.grip(in_force) {
                self.propose_share(fitted);
            }
            return self.begin_data();
        }
        let (filter, estimate) = (&self.setup.filter, &self.memory.estimate);
        let noise =
            filter.as_ref().map(|filter| filter.velocity_noise(estimate)).unwrap_or_default();
        let share = self.memory.road.share;
        if share < DRY {
            let Some(lap) = slippery else { return self.begin_data() };
            let samples = self.memory.dataset.laps[lap].samples.iter().rev();
            let grip = work.grip.map(|grip| share * grip);
            work.fit.begin(grip, grip, samples, noise);
            work.stage = Stage::FitShare;
            return;
        }
        // A driver's laps are too slow and their noise is unknown: they say little of grip.
        let laps = self.memory.dataset.laps[..work.laps].iter().enumerate().rev();
        let own = laps.filter(|(_, lap)| lap.result.kind != LapKind::Driven);
        // What a slippery road did says nothing of the grip without it.
        let road = &self.memory.road;
        let samples = own.flat_map(|(i, lap)| {
            let samples = lap.samples.iter().enumerate().rev();
            samples.filter(move |(k, _)| road.history.at(i, *k) > DRY).map(|(_, sample)| sample)
        });
        work.fit.begin(work.grip, [1.0; 2], samples, noise);
        work.stage = Stage::Fit;
    }

    /// A piece of the fit; its result after the last.
    fn advance_fit(&mut self, piece: usize) -> Option<[f64; 2]> {
        let work = &mut self.memory.lap_end;
        let (done, fitted) = work.fit.advance(&self.setup.model, &self.setup.track, piece);
        work.done += done;
        fitted
    }

    pub(super) fn fit_grip(&mut self, piece: usize) {
        let Some(fitted) = self.advance_fit(piece) else { return };
        // A new grip invalidates all residuals, so changes too small to matter are ignored.
        if grip::differ(fitted, self.memory.grip) {
            self.memory.lap_end.grip = fitted;
        }
        self.begin_data();
    }

    /// Fits the grip that a lap on a slippery road had: the share in force comes from a few samples.
    pub(super) fn fit_share(&mut self, piece: usize) {
        let Some(fitted) = self.advance_fit(piece) else { return };
        self.propose_share(fitted);
        self.begin_data();
    }

    /// The share in force becomes what the factors [front, rear] since the last fall are of the dry road's.
    fn propose_share(&mut self, fitted: [f64; 2]) {
        let grip = self.memory.lap_end.grip;
        let share = 0.5 * (fitted[0] / grip[0] + fitted[1] / grip[1]);
        let in_force = self.memory.road.share;
        if in_force < DRY && self.slippery_lap().is_some() {
            let share = share.min(in_force + MOST_RISE);
            let share = if share < DRY { share } else { 1.0 };
            self.memory.lap_end.share = Some(share).filter(|share| (share - in_force).abs() > SAME);
        }
    }

    /// The grip fell anew: the share that a lap before the fall had no longer counts, and the data that are being
    /// made with it are begun again.
    pub(crate) fn forget_share(&mut self) {
        if self.memory.lap_end.share.take().is_some() {
            self.begin_data();
        }
    }

    /// The last closed lap, if all of it was driven since the last fall of the grip.
    fn slippery_lap(&self) -> Option<usize> {
        let lap = self.memory.lap_end.laps.checked_sub(1)?;
        let first = self.memory.road.history.first_lap_since_fall()?;
        let own = self.memory.dataset.laps[lap].result.kind != LapKind::Driven;
        (own && first <= lap).then_some(lap)
    }
}
