//! Delay and lag of the actuators that nobody configured, estimated from the excited initial laps.
//!
//! [`trial`] collects what the laps say, [`search`] finds the most likely pair. Where delay and lag
//! cannot be told apart, the lag is that of the car's file and the delay takes the rest: links and
//! computers are late in ways that no car's file knows.

mod actuators;
mod drift;
mod search;
mod trial;

use std::sync::Arc;

use serde::{Deserialize, Serialize};
use vehicle_model::{Input, State};

use crate::controller::{Controller, Setup};
use crate::lap_end::Derived;

pub(crate) use actuators::Actuators;
use drift::Drift;
use search::Search;
pub use trial::Response;
use trial::{Commanded, Trial};

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

/// Estimation of the actuators' response.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Actuation {
    trial: Trial,
    searches: Option<Searches>,
    /// The decision was made.
    settled: bool,
    /// The car reports what acts.
    reported: bool,
    /// What is in force in place of the car's file.
    found: Option<Response>,
    /// A change of the delay since.
    drift: Drift,
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

impl Actuation {
    /// An input is commanded in the period that begins with this lap's sample.
    pub(crate) fn commanded(&mut self, u: Input, at: Option<(usize, usize)>) {
        if !self.settled {
            self.trial.commands.push(Commanded { u, at });
        }
    }

    /// The car reports the inputs that act.
    pub(crate) fn reported(&mut self) {
        self.reported = true;
    }

    /// What was found in the initial laps, if it is not what the car's file says.
    pub(crate) fn found(&self) -> Option<Response> {
        self.found
    }
}

/// Whether a response differs enough to matter.
fn later(response: Response, given: Response, dt: f64) -> bool {
    let later = response.delay + response.lag - given.delay - given.lag;
    later.abs() > NEGLIGIBLE * dt
}

impl Controller {
    /// Takes in how the car went on from `last` to `now`, one period later.
    pub(crate) fn observe_response(&mut self, last: &State, now: &State) {
        self.memory.actuation.trial.add(&self.setup.model, &self.setup.track, last, now);
    }

    /// A piece of the search for delay and lag while the last initial lap is driven.
    pub(crate) fn seek_response(&mut self) {
        let needed = self.setup.config.warm_up.laps;
        let memory = &mut self.memory;
        let soon = !memory.learning && memory.valid_laps() + 1 >= needed;
        if self.setup.config.delay.estimates() && soon && memory.actuation.trial.count() >= LEAST {
            self.seek_rough();
        }
    }

    /// A piece of the first search, of all that is known so far; whether it is done.
    fn seek_rough(&mut self) -> bool {
        let (dt, lag) = (self.setup.config.horizon.period, self.setup.car.actuator_lag);
        let Actuation { trial, searches, .. } = &mut self.memory.actuation;
        let begin = || Searches {
            rough: Search::new(lag, false, dt),
            passes: 1,
            linearized: 0,
            fine: None,
        };
        let rough = &mut searches.get_or_insert_with(begin).rough;
        rough.advance(trial, &self.setup.car, dt, trial.affordable());
        rough.done()
    }

    /// A piece of the decision on delay and lag; whether it is made.
    pub(crate) fn settle_response(&mut self) -> bool {
        let (dt, lag) = (self.setup.config.horizon.period, self.setup.car.actuator_lag);
        let given = Response { delay: 0.0, lag };
        if self.memory.actuation.settled {
            return true;
        }
        if self.memory.actuation.trial.count() < LEAST {
            self.use_response(None);
            return true;
        }
        if !self.seek_rough() {
            return false;
        }
        let Actuation { trial, searches: Some(searches), .. } = &mut self.memory.actuation else {
            return true;
        };
        let Searches { rough, passes, linearized, fine } = searches;
        if !later(rough.best, given, dt) {
            self.use_response(None);
            return true;
        }
        // Once more, along what acted.
        if *linearized < trial.count() {
            let Setup { model, track, .. } = &self.setup;
            let piece = trial.linearizable(self.setup.piece(), dt);
            trial.linearize(model, track, rough.best, (*linearized, piece));
            *linearized += piece;
            return false;
        }
        let near = || [Search::near(rough.best, dt), Search::new(lag, true, dt)];
        let [both, delay] = fine.get_or_insert_with(near);
        if let Some(search) = [&mut *both, &mut *delay].into_iter().find(|search| !search.done()) {
            search.advance(trial, &self.setup.car, dt, trial.affordable());
            return false;
        }
        if *passes < PASSES {
            let better = if both.likelihood > delay.likelihood { both } else { delay };
            rough.best = better.best;
            (*passes, *linearized, *fine) = (*passes + 1, 0, None);
            return false;
        }
        let best = if both.likelihood > delay.likelihood + APART { *both } else { *delay };
        let gain = best.likelihood - trial.likelihood(given, &self.setup.car, dt);
        let found = (gain > GAIN && later(best.best, given, dt)).then_some(best.best);
        self.use_response(found);
        true
    }

    /// Uses what was found: the recorded inputs become what acted, those under way are queued.
    fn use_response(&mut self, found: Option<Response>) {
        let actuation = &mut self.memory.actuation;
        actuation.found = found;
        actuation.settled = true;
        actuation.searches = None;
        let commands = std::mem::take(&mut actuation.trial).commands;
        let (Some(found), reported) = (actuation.found, actuation.reported) else { return };
        self.apply_learned();
        let dt = self.setup.config.horizon.period;
        let positions = trial::positions(&commands, found.lag, dt);
        let actuators = &self.setup.actuators;
        let late = actuators.periods();
        // What the command of this index makes act, once it does.
        let mean = |i: Option<usize>| match i {
            Some(i) => actuators.mean(positions[i], positions[i + 1]),
            None => Input::default(),
        };
        if !reported {
            let dataset = &mut self.memory.dataset;
            let mut laps: Vec<_> = dataset.laps.iter().map(|lap| (**lap).clone()).collect();
            for (i, command) in commands.iter().enumerate() {
                let Some((lap, sample)) = command.at else { continue };
                let samples = match laps.get_mut(lap) {
                    Some(lap) => &mut lap.samples,
                    None => &mut dataset.current.samples,
                };
                if let Some(sample) = samples.get_mut(sample) {
                    sample.u = mean(i.checked_sub(late));
                }
            }
            dataset.laps = laps.into_iter().map(Arc::new).collect();
        }
        let memory = &mut self.memory;
        memory.queue.clear();
        for i in 0..late {
            memory.queue.push_back(mean((commands.len() + i).checked_sub(late)));
        }
        memory.u_prev = positions.last().copied().unwrap_or_default();
        // All residuals are those of other inputs now.
        memory.grip = [1.0; 2];
        memory.grip_sums = Default::default();
        self.setup.model.model.grip = memory.grip;
        memory.derived = Derived { made: true, ..Derived::default() };
        memory.lap_end.learned = 0;
        memory.selected.clear();
    }

    /// Delay and lag in force: those of configuration and car's file, or those found in the initial laps.
    #[must_use]
    pub fn response(&self) -> Response {
        let Self { setup, memory, .. } = self;
        memory.actuation.found.unwrap_or(Response {
            delay: setup.config.delay.steps as f64 * setup.config.horizon.period,
            lag: setup.car.actuator_lag,
        })
    }

    /// Whether the response was found in the initial laps, or loaded with what was learned in them.
    #[must_use]
    pub fn response_found(&self) -> bool {
        self.memory.actuation.found.is_some()
    }

    /// Takes over a response that was found on another day.
    pub(crate) fn adopt_response(&mut self, found: Option<Response>) {
        self.memory.actuation.found = found;
        self.memory.actuation.settled = found.is_some();
        self.apply_learned();
        self.memory.queue.clear();
        self.memory.queue.resize(self.setup.actuators.periods(), Input::default());
    }
}
