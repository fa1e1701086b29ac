//! Recorded laps, D^j of the paper: every measured state with the input that acted until the next one.
//!
//! ```text
//! D^j = { (x_k^i, u_k^i) : laps i = 0..j, samples k = 0..T^i - 1 }
//! ```

use std::sync::Arc;

use serde::{Deserialize, Serialize};
use vehicle_model::{Input, State};

use crate::config::{SafeSetConfig, Selection};
use crate::lap_number::LapNumber;
use crate::status::{LapKind, LapResult};

/// One measured transition.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Sample {
    /// Time of the measurement \[s\].
    pub time: f64,
    /// Measured state, s in [0, L).
    pub x: State,
    /// Input applied from this measurement to the next.
    pub u: Input,
    /// Velocities [v_x, v_y, omega_z] measured one period later; none where the next
    /// measurement was missing or not one period away.
    pub next: Option<[f64; 3]>,
}

/// A closed lap. It does not change any more.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Lap {
    /// Number, kind, time, validity.
    pub result: LapResult,
    /// Samples from the first behind the line to the last before it.
    pub samples: Vec<Sample>,
    /// Interpolated crossing of the line at the start \[s\].
    pub start_time: f64,
    /// Interpolated crossing of the line at the end \[s\].
    pub end_time: f64,
    /// Whether the first sample is the direct successor of the previous lap's last.
    pub follows: bool,
}

/// The lap in progress.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub(crate) struct Current {
    pub(crate) samples: Vec<Sample>,
    pub(crate) start_time: f64,
    pub(crate) follows: bool,
    /// Began at the line, so that it will have a lap time.
    pub(crate) from_line: bool,
    /// Nothing has made it unfit for the safe set so far.
    pub(crate) clean: bool,
    /// An incident happened in it: nothing is learned from it.
    pub(crate) spoiled: bool,
}

/// All laps, closed and in progress, as one continuous trajectory.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub(crate) struct Dataset {
    pub(crate) laps: Vec<Arc<Lap>>,
    pub(crate) current: Current,
}

/// A sample seen from a lap that it may lie before or behind.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Seen<'a> {
    pub(crate) sample: &'a Sample,
    /// What to add to its s: -L before the lap, +L behind it.
    pub(crate) offset: f64,
}

impl Seen<'_> {
    /// The state, with s counted from the line of the lap it is seen from.
    pub(crate) fn place(&self) -> State {
        State { s: self.sample.x.s + self.offset, ..self.sample.x }
    }
}

impl Dataset {
    /// Samples of a lap, and whether the first is the direct successor of the previous lap's last. The lap
    /// behind the closed ones is the one in progress.
    pub(crate) fn driven(&self, lap: usize) -> (&[Sample], bool) {
        match self.laps.get(lap) {
            Some(lap) => (&lap.samples, lap.follows),
            None => (&self.current.samples, self.current.follows),
        }
    }

    /// When a lap passed `s`, for the lap in progress at most as far as it got \[s\].
    pub(crate) fn passing(&self, lap: usize, s: f64, length: f64) -> f64 {
        let (samples, _) = self.driven(lap);
        let (start, end) = match self.laps.get(lap) {
            Some(lap) => (lap.start_time, Some((length, lap.end_time))),
            None => (self.current.start_time, None),
        };
        let place = |sample: &Sample| (sample.x.s, sample.time);
        let above = samples.partition_point(|sample| sample.x.s < s);
        let from = above.checked_sub(1).map_or((0.0, start), |i| place(&samples[i]));
        let Some(to) = samples.get(above).map(place).or(end) else { return from.1 };
        let share = (s - from.0) / (to.0 - from.0).max(f64::EPSILON);
        from.1 + share * (to.1 - from.1)
    }

    /// Greatest speed with which the laps from `first` on that are fit passed `s`, the one in progress as far as
    /// it got; 0 where none did \[m/s\].
    pub(crate) fn speed_since(&self, first: usize, s: f64, length: f64) -> f64 {
        let at = |lap: usize| {
            let (samples, _) = self.driven(lap);
            // At most the number of samples, which fits isize.
            let above = samples.partition_point(|sample| sample.x.s < s) as isize;
            let place = |index| self.seen_from(lap, index, length).map(|seen| seen.place());
            let (before, behind) = (place(above - 1)?, place(above)?);
            let share = (s - before.s) / (behind.s - before.s).max(f64::EPSILON);
            Some(before.v_x + share * (behind.v_x - before.v_x))
        };
        let fit = (first..=self.laps.len()).filter(|lap| self.fit(*lap));
        fit.filter_map(at).fold(0.0, f64::max)
    }

    /// How long the car took for the round that it has just driven, from where it is in the lap in progress back
    /// to there in the last one; none where an interruption lies between \[s\].
    pub(crate) fn last_round(&self, length: f64) -> Option<f64> {
        let lap = self.laps.len();
        let last = lap.checked_sub(1).filter(|_| self.fit(lap))?;
        let begin = (0.0, self.current.start_time);
        let (s, time) = self.current.samples.last().map_or(begin, |x| (x.x.s, x.time));
        Some(time - self.passing(last, s, length))
    }

    /// Whether a lap is fit for the safe set, the one in progress as far as it got: one that began at a
    /// standstill is no measure.
    pub(crate) fn fit(&self, lap: usize) -> bool {
        let Current { from_line, clean, follows, .. } = self.current;
        self.laps.get(lap).map_or(from_line && clean && follows, |lap| lap.result.valid)
    }

    /// Sample `index` counted from the first of `lap`; negative ones lie in the lap before it,
    /// those past its end in the lap that followed, up to the first interruption.
    pub(crate) fn seen_from(&self, lap: usize, index: isize, length: f64) -> Option<Seen<'_>> {
        let (own, follows) = self.driven(lap);
        if index < 0 {
            if !follows || lap == 0 {
                return None;
            }
            let before = &self.laps[lap - 1].samples;
            let i = before.len().checked_sub(index.unsigned_abs())?;
            let sample = &before[i];
            return sample.next.map(|_| Seen { sample, offset: -length });
        }
        let i = index.unsigned_abs();
        if let Some(sample) = own.get(i) {
            return Some(Seen { sample, offset: 0.0 });
        }
        if lap == self.laps.len() {
            return None;
        }
        let (behind, follows) = self.driven(lap + 1);
        if !follows {
            return None;
        }
        // What comes behind an interruption is not what this lap led to.
        let j = i - own.len();
        let led_here = if j == 0 { own.last() } else { behind.get(j - 1) };
        led_here?.next?;
        behind.get(j).map(|sample| Seen { sample, offset: length })
    }

    /// Closes the lap in progress at `end_time`; the next begins there.
    pub(crate) fn close(
        &mut self,
        number: LapNumber,
        kind: LapKind,
        end_time: f64,
    ) -> Option<LapResult> {
        let Current { start_time, follows, from_line, clean, .. } = self.current;
        let lap_time = end_time - start_time;
        let result = LapResult { lap: number, kind, lap_time, valid: clean && from_line };
        if self.current.spoiled {
            self.spoil();
        }
        // A lap is kept for good: without the room it did not need, which the next one fills again.
        let samples = self.current.samples.clone();
        self.laps.push(Arc::new(Lap { result, samples, start_time, end_time, follows }));
        self.current.samples.clear();
        self.current.start_time = end_time;
        self.current.follows = true;
        self.current.from_line = true;
        self.current.clean = true;
        self.current.spoiled = false;
        from_line.then_some(result)
    }

    /// The lap in progress holds an incident: it is no lap of the safe set, and none of its
    /// transitions is learned from.
    pub(crate) fn spoil(&mut self) {
        self.current.clean = false;
        self.current.spoiled = true;
        for sample in &mut self.current.samples {
            sample.next = None;
        }
    }

    /// Drops the lap in progress after an interruption; what it holds stays in the data.
    pub(crate) fn interrupt(&mut self) {
        self.current.clean = false;
        if let Some(last) = self.current.samples.last_mut() {
            last.next = None;
        }
    }
}

/// Brings a lap into the list of the safe set's laps: valid ones, the fastest or the most recent, best
/// first. Laps come in the order they were driven; of equally fast ones the more recent is better.
pub(crate) fn select(
    selected: &mut Vec<usize>,
    laps: &[Arc<Lap>],
    lap: usize,
    config: &SafeSetConfig,
) {
    let new = &laps[lap].result;
    if !new.valid {
        return;
    }
    let place = match config.selection {
        Selection::Fastest => {
            let faster = |i: &usize| laps[*i].result.lap_time.total_cmp(&new.lap_time).is_lt();
            selected.partition_point(faster)
        }
        Selection::Recent => 0,
    };
    if place < config.laps {
        selected.insert(place, lap);
        selected.truncate(config.laps);
    }
}
