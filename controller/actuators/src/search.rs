//! The most likely delay and lag: a coarse grid, then a pattern search, one pair at a time.

use serde::{Deserialize, Serialize};
use vehicle_model::CarParams;

use super::Response;
use super::trial::Trial;

/// Longest delay that is tried, in periods and in seconds, whichever is longer.
const LONGEST: (f64, f64) = (5.0, 0.25);
/// Time constants of the coarse grid besides that of the car's file \[s\].
const LAGS: [f64; 4] = [0.0, 0.05, 0.1, 0.2];
/// Greatest time constant \[s\].
const SLOWEST: f64 = 0.4;
/// Finest step of the search \[s\].
const FINEST: f64 = 4e-4;
/// Directions of delay and lag. Their sum is what is seen best.
const DIRECTIONS: [(f64, f64); 6] =
    [(1.0, -1.0), (-1.0, 1.0), (1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)];

/// A search in progress.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(super) struct Search {
    /// Pairs of the coarse grid that are done, and all of it.
    grid: [usize; 2],
    /// Delays of a line of the grid.
    line: usize,
    /// Lag of the car's file \[s\].
    lag: f64,
    /// Whether the lag stays as it is.
    known_lag: bool,
    /// Step of the pattern \[s\], the direction that is next, and directions in a row without gain.
    step: f64,
    direction: usize,
    failed: usize,
    pub(super) best: Response,
    pub(super) likelihood: f64,
}

impl Search {
    /// For a car whose lag is said to be `lag`; `known_lag` searches the delay alone.
    pub(super) fn new(lag: f64, known_lag: bool, dt: f64) -> Self {
        let line = 1 + (longest(dt) / (0.5 * dt)).round() as usize;
        let lines = if known_lag { 1 } else { 1 + LAGS.len() };
        Self {
            grid: [0, line * lines],
            line,
            lag,
            known_lag,
            step: 0.25 * dt,
            direction: 0,
            failed: 0,
            best: Response { delay: 0.0, lag },
            likelihood: f64::NEG_INFINITY,
        }
    }

    /// From a pair that is about right.
    pub(super) fn near(best: Response, dt: f64) -> Self {
        Self { grid: [0, 0], step: 0.125 * dt, best, ..Self::new(best.lag, false, dt) }
    }

    /// Whether the best is found.
    pub(super) fn done(&self) -> bool {
        self.step < FINEST
    }

    /// Tries so many pairs more.
    pub(super) fn advance(&mut self, trial: &Trial, car: &CarParams, dt: f64, count: usize) {
        for _ in 0..count {
            if self.done() {
                return;
            }
            self.try_next(trial, car, dt);
        }
    }

    fn try_next(&mut self, trial: &Trial, car: &CarParams, dt: f64) {
        let [done, all] = self.grid;
        if done < all {
            self.grid[0] += 1;
            let lag = (done / self.line).checked_sub(1).map_or(self.lag, |i| LAGS[i]);
            let delay = (done % self.line) as f64 * 0.5 * dt;
            self.compare(trial, car, dt, Response { delay, lag });
            return;
        }
        if self.likelihood == f64::NEG_INFINITY {
            self.likelihood = trial.likelihood(self.best, car, dt);
            return;
        }
        let (delay, lag) = DIRECTIONS[self.direction];
        // A step past the least ends there.
        let moved = |from: f64, way: f64| if way == 0.0 { from } else { (from + way).max(0.0) };
        let response = Response {
            delay: moved(self.best.delay, self.step * delay),
            lag: moved(self.best.lag, self.step * lag),
        };
        let allowed = response.delay <= longest(dt)
            && response.lag <= SLOWEST
            && (lag == 0.0 || !self.known_lag)
            && response != self.best;
        if allowed && self.compare(trial, car, dt, response) {
            self.failed = 0;
            return;
        }
        self.direction = (self.direction + 1) % DIRECTIONS.len();
        self.failed += 1;
        if self.failed == DIRECTIONS.len() {
            (self.step, self.failed) = (0.5 * self.step, 0);
        }
    }

    /// Whether a pair is better than the best so far, which it then is.
    fn compare(&mut self, trial: &Trial, car: &CarParams, dt: f64, response: Response) -> bool {
        let likelihood = trial.likelihood(response, car, dt);
        let better = likelihood > self.likelihood;
        if better {
            (self.best, self.likelihood) = (response, likelihood);
        }
        better
    }
}

fn longest(dt: f64) -> f64 {
    (LONGEST.0 * dt).max(LONGEST.1)
}
