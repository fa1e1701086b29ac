//! Whole periods of delay that nobody configured, estimated from the excited initial laps.
//!
//! For each candidate d the nominal model drives one period with the input of d periods ago. With
//! normal residuals of unknown variance in each velocity row, the log-likelihood of d is
//! `-n/2 sum_rows ln SSE_row(d)`; the greatest wins if it beats no delay clearly.

use std::collections::VecDeque;
use std::sync::Arc;

use serde::{Deserialize, Serialize};
use vehicle_model::{Input, State};

use crate::controller::Controller;
use crate::lap_end::Derived;

/// Candidates: delays of 0 to this many periods less one.
const CANDIDATES: usize = 6;
/// Gain of the log-likelihood that makes a delay believable.
const GAIN: f64 = 20.0;
/// Steps before anything is decided.
const LEAST: f64 = 50.0;

/// Evidence collected in the initial laps.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct DelayTrial {
    /// Latest inputs, as they act after the actuators' lag but without delay, the newest last.
    inputs: VecDeque<Input>,
    /// Sums of squared residuals of the velocity rows of each candidate.
    squares: [[f64; 3]; CANDIDATES],
    count: f64,
    /// Periods found beyond the configured ones.
    found: usize,
    /// The decision was made.
    settled: bool,
}

impl DelayTrial {
    /// An input is commanded.
    pub(crate) fn commanded(&mut self, u: Input) {
        if self.inputs.len() == CANDIDATES {
            self.inputs.pop_front();
        }
        self.inputs.push_back(u);
    }

    /// The most likely number of periods.
    fn decide(&self) -> usize {
        let likelihood = |d: usize| {
            let logs = self.squares[d].iter().map(|sum| libm::log(sum.max(1e-300)));
            -0.5 * self.count * logs.sum::<f64>()
        };
        let best = (0..CANDIDATES).fold(
            0,
            |best, d| {
                if likelihood(d) > likelihood(best) { d } else { best }
            },
        );
        let clear = self.count >= LEAST && likelihood(best) - likelihood(0) > GAIN;
        if clear { best } else { 0 }
    }
}

impl Controller {
    /// Takes in how the car went on from `last` to `now`, one period later.
    pub(crate) fn try_delays(&mut self, last: &State, now: &State) {
        let (model, track) = (&self.setup.model, &self.setup.track);
        let trial = &mut self.memory.delay;
        if trial.inputs.len() < CANDIDATES {
            return;
        }
        trial.count += 1.0;
        for (u, squares) in trial.inputs.iter().rev().zip(&mut trial.squares) {
            let next = model.next(last, u, track.road());
            let residual = [now.v_x - next.v_x, now.v_y - next.v_y, now.omega_z - next.omega_z];
            for (sum, r) in squares.iter_mut().zip(residual) {
                *sum += r * r;
            }
        }
    }

    /// Uses the delay found: the recorded inputs move to where they acted, and the inputs under way
    /// are queued.
    pub(crate) fn settle_delay(&mut self) {
        if std::mem::replace(&mut self.memory.delay.settled, true) {
            return;
        }
        let found = self.memory.delay.decide();
        self.memory.delay.found = found;
        if found == 0 {
            return;
        }
        let dataset = &mut self.memory.dataset;
        let mut laps: Vec<_> = dataset.laps.iter().map(|lap| (**lap).clone()).collect();
        let all = laps.iter_mut().flat_map(|lap| &mut lap.samples);
        let mut inputs: Vec<&mut Input> =
            all.chain(&mut dataset.current.samples).map(|sample| &mut sample.u).collect();
        for i in (found..inputs.len()).rev() {
            *inputs[i] = *inputs[i - found];
        }
        for u in inputs.iter_mut().take(found) {
            **u = Input::default();
        }
        dataset.laps = laps.into_iter().map(Arc::new).collect();
        self.queue_under_way();
        // All residuals are those of other inputs now.
        self.memory.derived = Derived { made: true, ..Derived::default() };
        self.memory.lap_end.learned = 0;
        self.memory.selected.clear();
    }

    /// Fills the queue with the inputs that do not act yet.
    pub(crate) fn queue_under_way(&mut self) {
        let memory = &mut self.memory;
        let all = self.setup.config.delay.steps + memory.delay.found;
        memory.queue.clear();
        let known = memory.delay.inputs.len();
        for i in 0..all {
            let u = (known + i).checked_sub(all).and_then(|i| memory.delay.inputs.get(i));
            memory.queue.push_back(u.copied().unwrap_or_default());
        }
    }

    /// Whole periods between a command and its effect: those configured, and those found in the
    /// initial laps.
    #[must_use]
    pub fn delay(&self) -> usize {
        self.setup.config.delay.steps + self.memory.delay.found
    }

    /// Takes over a delay that was found on another day.
    pub(crate) fn adopt_delay(&mut self, steps: usize) {
        self.memory.delay.found = steps.saturating_sub(self.setup.config.delay.steps);
        self.queue_under_way();
    }
}
