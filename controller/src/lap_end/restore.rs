//! What follows from the laps, made again from a state that was read from bytes.

use std::sync::Arc;

use super::{Derived, LapEnd, Stage};
use crate::controller::Controller;
use crate::learning::regression::RegressionData;

impl Controller {
    /// Makes regression data and envelope in force, and data in the making as far as they were.
    pub(crate) fn restore_derived(&mut self) {
        self.memory.derived = Derived { made: true, ..Derived::default() };
        let learned = self.memory.lap_end.learned;
        let first = self.setup.first_lap(learned);
        let mut data = RegressionData::new(&self.setup.config.regression);
        self.refill(&mut data, first..learned, 0, self.memory.grip, None);
        self.memory.derived.regression = Arc::new(data);
        if learned > 0 {
            self.make_envelope();
        }
        let LapEnd { stage, lap, at, grip, share, .. } = self.memory.lap_end;
        if !matches!(stage, Stage::Data | Stage::Envelope) {
            return;
        }
        self.begin_data();
        let work = &mut self.memory.lap_end;
        let begun = work.lap;
        (work.stage, work.lap, work.at) = (stage, lap, at);
        let mut growing = self.memory.lap_end.data.take();
        let data = growing.as_mut().unwrap_or(&mut self.memory.derived.regression);
        let mut data = std::mem::take(data);
        self.refill(Arc::make_mut(&mut data), begun..lap, at, grip, share);
        match &mut growing {
            Some(growing) => *growing = data,
            None => self.memory.derived.regression = data,
        }
        self.memory.lap_end.data = growing;
    }

    /// Adds whole laps, and so many samples of the next.
    fn refill(
        &self,
        data: &mut RegressionData,
        laps: std::ops::Range<usize>,
        at: usize,
        grip: [f64; 2],
        revised: Option<f64>,
    ) {
        let (mut points, mut targets) = (Vec::new(), Vec::new());
        let mut add = |data: &mut RegressionData, index: usize, count: Option<usize>| {
            let lap = &self.memory.dataset.laps[index];
            let share = |sample| self.memory.road.history.at_revised(index, sample, revised);
            let count = count.unwrap_or(lap.samples.len());
            self.setup.add(data, lap, 0..count, (grip, &share), (&mut points, &mut targets));
        };
        let next = laps.end;
        for lap in laps {
            add(data, lap, None);
        }
        if at > 0 {
            add(data, next, Some(at));
        }
    }
}
