//! A change of the delay while the car races, in whole periods.
//!
//! Each period the nominal model drives with the input that acted by what is known, and with those of
//! some periods before and of the one after. With normal residuals the log-likelihood of a shift
//! is `-n/2 sum_rows ln S_row`, S_row a mean of squares that forgets.

use serde::{Deserialize, Serialize};
use vehicle_model::{Discretized, Input, State, Track};

use crate::controller::Controller;
use crate::learning::dataset::Sample;

/// Shifts in periods: later, and one earlier.
const SHIFTS: [isize; 5] = [0, 1, 2, 3, -1];
/// Periods remembered.
const MEMORY: f64 = 80.0;
/// Gain of the log-likelihood that makes a change clear.
const CLEAR: f64 = 40.0;

/// Evidence for a change.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub(crate) struct Drift {
    squares: [[f64; 3]; SHIFTS.len()],
    count: f64,
    /// Periods that commands act later than is known; below 0 for sooner.
    periods: isize,
}

impl Drift {
    /// Takes in a period that began with the last but one of `samples`; `next` is the first input that
    /// does not act yet.
    fn add(
        &mut self,
        model: &Discretized,
        track: &Track,
        samples: &[Sample],
        (from, to): (&State, &State),
        next: Option<Input>,
    ) {
        let Some(i) = samples.len().checked_sub(2).filter(|i| *i >= 3) else { return };
        self.count = (self.count + 1.0).min(MEMORY);
        let acting = SHIFTS.map(|shift| {
            let u = match shift {
                -1 => next,
                _ => i.checked_add_signed(-shift).map(|i| samples[i].u),
            };
            // What cannot be known is no better than what is.
            (*from, u.unwrap_or(samples[i].u))
        });
        let (squares, count) = (&mut self.squares, self.count);
        model.velocities_all(&acting, &track.road(), &mut |shift, expected| {
            let residual = [to.v_x - expected[0], to.v_y - expected[1], to.omega_z - expected[2]];
            for (mean, r) in squares[shift].iter_mut().zip(residual) {
                *mean += (r * r - *mean) / count;
            }
        });
        if self.count < MEMORY {
            return;
        }
        let likelihood = self.squares.map(|squares| {
            let logs = squares.iter().map(|square| libm::log(square.max(1e-300)));
            -0.5 * MEMORY * logs.sum::<f64>()
        });
        let better = |best, h| if likelihood[h] > likelihood[best] { h } else { best };
        let best = (1..SHIFTS.len()).fold(0, better);
        let clear = likelihood[best] - likelihood[0] > CLEAR;
        self.periods = if clear { SHIFTS[best] } else { 0 };
    }
}

impl Controller {
    /// Takes in how the car went on from `from` to `to` while it races.
    pub(crate) fn observe_drift(&mut self, from: &State, to: &State) {
        let (setup, memory) = (&self.setup, &mut self.memory);
        let samples = &memory.dataset.current.samples;
        // The front of the queue acts from now on.
        let next = memory.queue.front().copied();
        let drift = &mut memory.drift;
        drift.add(&setup.model, &setup.track, samples, (from, to), next);
    }

    /// How much later commands act than [`Controller::response`] says, in whole periods; below 0 for
    /// sooner, 0 while no change is clear \[s\].
    #[must_use]
    pub fn delay_change(&self) -> f64 {
        self.memory.drift.periods as f64 * self.setup.config.horizon.period
    }
}
