//! Late actuators of a car: what to command so that they are where they should be, and how late they are
//! where nobody configured it, estimated from the excited initial laps.
//!
//! [`Actuators`] is the actuators over one period. [`Estimation`] collects what the laps say and finds the
//! most likely pair of delay and lag. Where the two cannot be told apart, the lag is that of the car's
//! file and the delay takes the rest: links and computers are late in ways that no car's file knows.
#![forbid(unsafe_code)]
// The same bits on every machine: no function of the platform's mathematical library.
#![cfg_attr(not(test), deny(clippy::disallowed_methods))]

mod actuators;
mod search;
mod trial;

use serde::{Deserialize, Serialize};
use vehicle_model::{CarParams, Discretized, Input, State, Track};

pub use actuators::Actuators;
use search::Search;
use trial::Trial;
pub use trial::positions;

/// Gain of the log-likelihood that makes an estimate believable.
const GAIN: f64 = 20.0;
/// Gain that makes a lag believable beside a delay.
const APART: f64 = 3.0;
/// Periods before anything is decided.
const LEAST: usize = 50;
/// Linearisations along what was found.
const PASSES: usize = 2;
/// Later by less than this share of the sampling period is not worth an estimate.
const NEGLIGIBLE: f64 = 0.1;

/// How late and how slowly a command acts.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Response {
    /// Time from a command to the beginning of its effect \[s\].
    pub delay: f64,
    /// Time constant of the actuators, 0 for none \[s\].
    pub lag: f64,
}

/// A command of the initial laps.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Commanded {
    /// The input decided on.
    pub u: Input,
    /// Lap, and sample in it, whose period the command began with.
    pub at: Option<(usize, usize)>,
}

/// Estimation of the actuators' response.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Estimation {
    trial: Trial,
    searches: Option<Searches>,
    /// The decision was made.
    settled: bool,
    /// The car reports what acts.
    reported: bool,
    /// What is in force in place of the car's file.
    found: Option<Response>,
}

/// The decision in the making.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
struct Searches {
    /// Over delays and lags, along what the motion tells of the inputs.
    rough: Search,
    /// Linearisations along what was found, with the one in work.
    passes: usize,
    /// Periods of it that are done.
    linearized: usize,
    /// Over both once more, and with the lag of the car's file.
    fine: Option<[Search; 2]>,
}

/// Whether a response differs enough to matter.
fn later(response: Response, given: Response, dt: f64) -> bool {
    let later = response.delay + response.lag - given.delay - given.lag;
    later.abs() > NEGLIGIBLE * dt
}

/// How far the decision on the response is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Decision {
    /// There is more to do.
    Pending,
    /// Delay and lag; none where they are those of the car's file.
    Made(Option<Response>),
}

impl Estimation {
    /// An input is commanded in the period that begins with this lap's sample.
    pub fn commanded(&mut self, u: Input, at: Option<(usize, usize)>) {
        if !self.settled {
            self.trial.commands.push(Commanded { u, at });
        }
    }

    /// The car reports the inputs that act.
    pub fn reported(&mut self) {
        self.reported = true;
    }

    /// Whether the car reports them.
    #[must_use]
    pub fn is_reported(&self) -> bool {
        self.reported
    }

    /// What was found in the initial laps, if it is not what the car's file says.
    #[must_use]
    pub fn found(&self) -> Option<Response> {
        self.found
    }

    /// Whether the decision was concluded.
    #[must_use]
    pub fn is_settled(&self) -> bool {
        self.settled
    }

    /// Takes in how the car went on from `last` to `now` in the period of the last command.
    pub fn add(&mut self, model: &Discretized, track: &Track, last: &State, now: &State) {
        self.trial.add(model, track, last, now);
    }

    /// Whether there is enough to decide on.
    #[must_use]
    pub fn is_enough(&self) -> bool {
        self.trial.count() >= LEAST
    }

    /// A piece of the first search, of all that is known so far, with commands held for `dt`; whether it
    /// is done.
    pub fn seek(&mut self, car: &CarParams, dt: f64) -> bool {
        let Self { trial, searches, .. } = self;
        let begin = || Searches {
            rough: Search::new(car.actuator_lag, false, dt),
            passes: 1,
            linearized: 0,
            fine: None,
        };
        let rough = &mut searches.get_or_insert_with(begin).rough;
        rough.advance(trial, car, dt, trial.affordable());
        rough.done()
    }

    /// A piece of the decision on delay and lag: what costs about as much as `samples` linearisations.
    pub fn decide(
        &mut self,
        (car, dt): (&CarParams, f64),
        model: &Discretized,
        track: &Track,
        samples: usize,
    ) -> Decision {
        let lag = car.actuator_lag;
        let given = Response { delay: 0.0, lag };
        if !self.is_enough() {
            return Decision::Made(None);
        }
        if !self.seek(car, dt) {
            return Decision::Pending;
        }
        let Self { trial, searches: Some(searches), .. } = self else {
            return Decision::Made(None);
        };
        let Searches { rough, passes, linearized, fine } = searches;
        if !later(rough.best, given, dt) {
            return Decision::Made(None);
        }
        // Once more, along what acted.
        if *linearized < trial.count() {
            let piece = trial.linearizable(samples, dt);
            trial.linearize(model, track, rough.best, (*linearized, piece));
            *linearized += piece;
            return Decision::Pending;
        }
        let near = || [Search::near(rough.best, dt), Search::new(lag, true, dt)];
        let [both, delay] = fine.get_or_insert_with(near);
        if let Some(search) = [&mut *both, &mut *delay].into_iter().find(|search| !search.done()) {
            search.advance(trial, car, dt, trial.affordable());
            return Decision::Pending;
        }
        if *passes < PASSES {
            let better = if both.likelihood > delay.likelihood { both } else { delay };
            rough.best = better.best;
            (*passes, *linearized, *fine) = (*passes + 1, 0, None);
            return Decision::Pending;
        }
        let best = if both.likelihood > delay.likelihood + APART { *both } else { *delay };
        let gain = best.likelihood - trial.likelihood(given, car, dt);
        let found = (gain > GAIN && later(best.best, given, dt)).then_some(best.best);
        Decision::Made(found)
    }

    /// Ends the estimation with this; gives the commands of the initial laps.
    pub fn conclude(&mut self, found: Option<Response>) -> Vec<Commanded> {
        self.found = found;
        self.settled = true;
        self.searches = None;
        std::mem::take(&mut self.trial).commands
    }

    /// Takes over what was found on another day; none leaves it to be estimated.
    pub fn adopt(&mut self, found: Option<Response>) {
        self.found = found;
        self.settled = found.is_some();
    }
}
