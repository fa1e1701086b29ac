//! The grip of the road now, as a share of that which was fitted: seen within a few samples.
//!
//! For each hypothesis h of a bank the model drives one period with h times the fitted grip, with what
//! the regression knows of its error. Evidence against the share in force is summed up as in Page's
//! test (1954), which does not weigh what was before the fall against it:
//!
//! ```text
//! c_h = min over w in {0, 1} of sum_rows min((r_h + w e)^2 / sigma^2, MOST)      rows v_y and omega_z
//! g_h = c_in_force - c_h
//! G_h <- max(0, FORGET G_h + g_h)
//! ```
//!
//! sigma is what the residuals of the share in force were before, but no less than the filter's covariance
//! explains: an uncertain yaw rate moves v_y the more, the faster the car is. e is the learned error of the model:
//! where data are few it is wrong, and a motion that the model alone explains is no sign of another
//! grip. Where measurements are noisy, nor is one residual alone: of g_h no more than ALONE counts at
//! once, and the rest in the next period, as far as that period says the same.
//!
//! A lower share comes into force as soon as G_h is clear; a higher one a little with each period in
//! which it is. A lap that was driven wholly since the last fall corrects the share
//! ([`lap_end`](crate::lap_end)): the learned error of its data explains away what the bank would see.
//!
//! While the whole grip is in force and explains the motion (c_in_force and all G_h below QUIET) no other
//! hypothesis is driven: it would gain less than QUIET of the evidence that is CLEAR.

mod history;

use serde::{Deserialize, Serialize};
use vehicle_model::{Discretized, GRAVITY, Input, State};

use history::ShareHistory;

use crate::config::{NominalModel, RegressionMode};
use crate::controller::Controller;
use crate::filter::Filter;
use crate::learned_model;
use crate::learning::grip::SCALES;
use crate::learning::grip_sums::GripSums;

/// Share of the fitted grip above which a road counts as having all of it.
pub(crate) const DRY: f64 = 0.97;
/// Hypotheses: factors on the share in force.
const FACTORS: [f64; 9] = [1.0, 1.08, 0.96, 0.91, 0.84, 0.77, 0.68, 0.58, 0.46];
/// What a period's evidence is worth one period later.
const FORGET: f64 = 0.85;
/// Most evidence of one row in one period.
const MOST: f64 = 36.0;
/// Evidence that brings a lower share into force, and a higher one.
const CLEAR: f64 = 25.0;
/// The same for a share with which the tyres could not have held what they held before.
const SURE: f64 = 120.0;
/// Most of a noisy period's evidence that counts at once.
const ALONE: f64 = 12.0;
/// Evidence that needs no other hypothesis to explain it.
const QUIET: f64 = 1.0;
/// Steps for which a fall is fresh.
const FRESH: u32 = 6;
/// The same for a lower share where one is in force already.
const CLEAR_AGAIN: f64 = 10.0;
/// Lower by less than this share is not told from the error of the model.
const LEAST: f64 = 0.05;
/// The same where a lower share is in force already.
const LEAST_AGAIN: f64 = 0.02;
/// Of the lateral grip, what the car must use for its motion to tell the grip.
const USED: f64 = 0.35;
/// Share given back in one period.
const RISE: f64 = 0.01;
/// Periods for which the residuals are remembered, and before anything is decided.
const MEMORY: f64 = 150.0;
const KNOWN: f64 = 30.0;
/// A residual counts up to so many standard deviations for them.
const CLIP: f64 = 3.0;
/// Periods before a fall was seen that it is taken to have lasted for.
const BEFORE: usize = 2;

/// What is known of the road.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct Road {
    /// Share of the fitted grip in force.
    pub(crate) share: f64,
    /// What noisy measurements of the lap in progress say of the grip in force, while that is a share of the fitted.
    pub(crate) of_lap: GripSums,
    /// What it rises to, where the laps since the last fall say a higher one.
    goal: Option<f64>,
    /// G_h.
    sums: [f64; FACTORS.len()],
    /// What of g_h in the last period has not counted yet.
    uncounted: [f64; FACTORS.len()],
    /// Variances of the residuals of v_y and omega_z with the share in force.
    variance: [f64; 2],
    count: f64,
    /// Greatest use of the fitted grip since the last fall.
    proved: f64,
    /// Steps for which a fall is fresh.
    pub(crate) fresh: u32,
    /// Where in the data another share began.
    pub(crate) history: ShareHistory,
}

impl Default for Road {
    fn default() -> Self {
        Self {
            share: 1.0,
            of_lap: GripSums::default(),
            goal: None,
            sums: [0.0; FACTORS.len()],
            uncounted: [0.0; FACTORS.len()],
            variance: [0.0; 2],
            count: 0.0,
            proved: 0.0,
            fresh: 0,
            history: ShareHistory::default(),
        }
    }
}

impl Road {
    /// Another share from this sample on.
    fn change(&mut self, share: f64, lap: usize, sample: usize) {
        if share < self.share {
            (self.fresh, self.proved, self.count) = (FRESH, 0.0, KNOWN);
            (self.goal, self.of_lap) = (None, GripSums::default());
        }
        self.share = share;
        self.history.change(share, (lap, sample));
        self.forget_evidence();
    }

    /// The share since the last fall is another: a lower one comes into force at once, a higher one is
    /// given back a little in each period.
    pub(crate) fn revise(&mut self, share: f64) {
        self.history.revise(share);
        self.goal = Some(share).filter(|share| *share > self.share);
        self.share = self.share.min(share);
        self.forget_evidence();
    }

    /// Evidence against another share than that in force says nothing.
    fn forget_evidence(&mut self) {
        (self.sums, self.uncounted) = ([0.0; FACTORS.len()], [0.0; FACTORS.len()]);
    }

    /// Gives back what one period may; false if there is nothing to give back.
    fn rise(&mut self) -> bool {
        let Some(goal) = self.goal else { return false };
        self.share = (self.share + RISE).min(goal);
        self.goal = Some(goal).filter(|goal| *goal > self.share);
        true
    }

    /// Variances of the residuals of the share in force, none below that of `floor`.
    fn variances(&self, floor: [f64; 2]) -> [f64; 2] {
        std::array::from_fn(|i| self.variance[i].max(floor[i] * floor[i]))
    }

    /// Whether the share in force, with its residuals [v_y, omega_z], leaves nothing to explain.
    fn explains(&self, residual: &[f64; 2], floor: [f64; 2]) -> bool {
        self.share == 1.0
            && cost(residual, &self.variances(floor)) < QUIET
            && self.sums.iter().all(|sum| *sum < QUIET)
    }

    /// Takes in the residuals [v_y, omega_z] of the share in force where they leave nothing to explain.
    fn rest(&mut self, residual: &[f64; 2], floor: [f64; 2]) {
        let variance = self.variances(floor);
        self.sums = self.sums.map(|sum| FORGET * sum);
        self.uncounted = [0.0; FACTORS.len()];
        self.remember(residual, &variance);
    }

    /// Takes in the residuals [v_y, omega_z] of each hypothesis, and the learned error that is in them; gives
    /// the share they ask for.
    fn weigh(
        &mut self,
        residuals: &[[f64; 2]; FACTORS.len()],
        error: [f64; 2],
        floor: [f64; 2],
        noisy: bool,
    ) -> Option<f64> {
        let variance = self.variances(floor);
        let cost = |residual: &[f64; 2]| {
            let without = [residual[0] + error[0], residual[1] + error[1]];
            cost(residual, &variance).min(cost(&without, &variance))
        };
        let own = cost(&residuals[0]);
        let alone = if noisy { ALONE } else { f64::INFINITY };
        for ((sum, rest), residual) in self.sums.iter_mut().zip(&mut self.uncounted).zip(residuals)
        {
            let gain = own - cost(residual);
            let late = FORGET * rest.min(gain.max(0.0));
            *sum = (FORGET * *sum + gain.min(alone) + late).max(0.0);
            *rest = (gain - alone).max(0.0);
        }
        let best = (0..FACTORS.len())
            .fold(0, |best, h| if self.sums[h] > self.sums[best] { h } else { best });
        self.remember(&residuals[0], &variance);
        let lower = FACTORS[best] < 1.0;
        let slippery = self.share < 1.0;
        let clear = if lower && slippery { CLEAR_AGAIN } else { CLEAR };
        if self.count < KNOWN || self.sums[best] < clear {
            return None;
        }
        let (mut sum, mut weights) = (0.0, 0.0);
        for (h, factor) in FACTORS.iter().enumerate().skip(1) {
            if (*factor < 1.0) == lower {
                let weight = libm::exp(0.5 * (self.sums[h] - self.sums[best]));
                sum += weight * factor;
                weights += weight;
            }
        }
        let wanted = self.share * (sum / weights);
        if lower {
            let least = if slippery { LEAST_AGAIN } else { LEAST };
            // What the tyres have held since the last fall they still hold, but for strong evidence.
            let held = wanted > self.proved || self.sums[best] > SURE;
            return (held && wanted < self.share * (1.0 - least)).then_some(wanted);
        }
        (slippery && self.goal.is_none()).then(|| wanted.min(self.share + RISE).min(1.0))
    }

    /// Takes residuals of the share in force into their variances, which were `variance`.
    fn remember(&mut self, own: &[f64; 2], variance: &[f64; 2]) {
        self.count = (self.count + 1.0).min(MEMORY);
        for i in 0..2 {
            let most = CLIP * CLIP * variance[i];
            let square = own[i] * own[i];
            let square = if self.count > KNOWN { square.min(most) } else { square };
            self.variance[i] += (square - self.variance[i]) / self.count;
        }
    }
}

/// c of a hypothesis.
fn cost(residual: &[f64; 2], variance: &[f64; 2]) -> f64 {
    let cost = |i: usize| (residual[i] * residual[i] / variance[i]).min(MOST);
    cost(0) + cost(1)
}

impl Controller {
    /// Whether the grip is fitted, and that of the road watched.
    pub(crate) fn fits_grip(&self) -> bool {
        let config = &self.setup.config;
        config.nominal.adapt_grip
            && config.nominal.model == NominalModel::Dynamic
            && config.regression.mode == RegressionMode::Error
            && !self.setup.filter.as_ref().is_some_and(Filter::blind)
    }

    /// Takes in what a noisy measurement, one period after a filtered state, says of the grip.
    pub(crate) fn observe_grip(&mut self, last: &State, now: &State, u: &Input) {
        let (setup, memory) = (&self.setup, &mut self.memory);
        let Some(filter) = setup.filter.as_ref().filter(|_| memory.estimate.filters()) else {
            return;
        };
        let noise = filter.velocity_noise(&memory.estimate);
        // The filtered state has a part of the noise too.
        let variance = [0, 1, 2].map(|row| SCALES[row] * SCALES[row] + 4.0 * noise[row]);
        let share = memory.road.share;
        let in_force = memory.grip.map(|grip| share * grip);
        // A road without its share of the grip says nothing of what it has with it.
        let slippery = share < DRY;
        let sums = if slippery { &mut memory.road.of_lap } else { &mut memory.grip_sums };
        let model = &setup.model;
        model.grip_jacobians(&[(*last, *u)], &setup.track.road(), &mut |_, next, by_grip| {
            let residual = [now.v_x - next[0], now.v_y - next[1], now.omega_z - next[2]];
            sums.add(in_force, residual, by_grip, variance);
        });
    }

    /// Takes in how the car went on from `last` to `now` with an input, one period later. After a change
    /// the problem is to be prepared anew.
    pub(crate) fn observe_road(&mut self, last: &State, now: &State, u: &Input) {
        if self.memory.road.rise() {
            self.apply_road();
        }
        let setup = &self.setup;
        let road = setup.track.friction(last.s);
        let scales = crate::derive::Scales::new(&setup.car);
        let share = self.memory.road.share;
        let available = self.memory.grip[0].min(self.memory.grip[1])
            * setup.car.tyre_front.mu.min(setup.car.tyre_rear.mu)
            * GRAVITY
            * road;
        self.memory.road.fresh = self.memory.road.fresh.saturating_sub(1);
        let used = (last.v_x * last.omega_z).abs() / available;
        if used < USED {
            return;
        }
        if self.memory.road.fresh == 0 && share < 1.0 {
            self.memory.road.proved = self.memory.road.proved.max(used);
        }
        let data = &self.memory.derived.regression;
        let scratch = &mut self.work.scratch;
        let (error, _) = learned_model::error(data, &setup.regression, 0, (last, u), scratch);
        let wrong = error.apply(&last.to_vector(), &u.to_vector());
        let probe: &mut Discretized = &mut self.work.probe;
        let grip = self.memory.grip;
        let mut residual = |factor: f64| {
            probe.model.grip = grip.map(|grip| share * factor * grip);
            let mut residual = [0.0; 2];
            probe.velocities_all(&[(*last, *u)], &setup.track.road(), &mut |_, next| {
                residual = [now.v_y - next[1] - wrong[1], now.omega_z - next[2] - wrong[2]];
            });
            residual
        };
        let model_error = 0.5 * setup.config.filter.model_error;
        let v =
            model_error * scales.speed * scales.speed / scales.length * setup.config.horizon.period;
        let expected = self.memory.estimate.expected;
        let floor = [v.max(expected[0].sqrt()), (v / scales.length).max(expected[1].sqrt())];
        let own = residual(FACTORS[0]);
        if self.memory.road.explains(&own, floor) {
            self.memory.road.rest(&own, floor);
            return;
        }
        let residuals = FACTORS.map(&mut residual);
        if !residuals.iter().flatten().all(|r| r.is_finite()) {
            return;
        }
        let noisy = self.memory.estimate.filters();
        let Some(wanted) = self.memory.road.weigh(&residuals, [wrong[1], wrong[2]], floor, noisy)
        else {
            return;
        };
        let (lap, sample) =
            (self.memory.dataset.laps.len(), self.memory.dataset.current.samples.len());
        let began = if wanted < share { BEFORE } else { 1 };
        self.memory.road.change(wanted, lap, sample.saturating_sub(began));
        if wanted < share {
            self.forget_share();
        }
        self.apply_road();
    }

    fn apply_road(&mut self) {
        self.apply_learned();
        self.make_road_speed();
        self.prepared = false;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FLOOR: [f64; 2] = [1.0; 2];

    /// Known for long, and residuals that 0.77 of the grip alone explains.
    fn fallen() -> (Road, [[f64; 2]; FACTORS.len()]) {
        let residuals = FACTORS.map(|factor| if factor == 0.77 { [0.0; 2] } else { [5.0; 2] });
        (Road { count: KNOWN, variance: FLOOR, ..Road::default() }, residuals)
    }

    #[test]
    fn a_fall_is_believed_at_once_and_among_noise_when_it_stays() {
        let near = |share: Option<f64>| share.is_some_and(|share| (share - 0.77).abs() < 1e-3);
        let (mut exact, residuals) = fallen();
        assert!(near(exact.weigh(&residuals, [0.0; 2], FLOOR, false)));
        let (mut noisy, _) = fallen();
        assert_eq!(noisy.weigh(&residuals, [0.0; 2], FLOOR, true), None);
        assert!(near(noisy.weigh(&residuals, [0.0; 2], FLOOR, true)));
        // A residual that does not come again is forgotten.
        let (mut once, _) = fallen();
        assert_eq!(once.weigh(&residuals, [0.0; 2], FLOOR, true), None);
        for _ in 0..20 {
            assert_eq!(once.weigh(&[[0.5; 2]; FACTORS.len()], [0.0; 2], FLOOR, true), None);
        }
    }

    #[test]
    fn what_the_model_explains_without_its_learned_error_is_no_fall() {
        let (mut road, residuals) = fallen();
        for _ in 0..20 {
            assert_eq!(road.weigh(&residuals, [-5.0; 2], FLOOR, false), None);
        }
    }
}
