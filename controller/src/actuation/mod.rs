//! Delay and lag of the actuators that nobody configured: the pieces of their estimation, and what follows
//! from what was found.

mod drift;

use std::sync::Arc;

use actuators::{Decision, Response, positions};
use vehicle_model::{Input, State};

use crate::controller::Controller;
use crate::lap_end::Derived;

pub(crate) use drift::Drift;

impl Controller {
    /// Takes in how the car went on from `last` to `now`, one period later.
    pub(crate) fn observe_response(&mut self, last: &State, now: &State) {
        self.memory.actuation.add(&self.setup.model, &self.setup.track, last, now);
    }

    /// A piece of the search for delay and lag while the last initial lap is driven.
    pub(crate) fn seek_response(&mut self) {
        let needed = self.setup.config.warm_up.laps;
        let memory = &mut self.memory;
        let soon = !memory.learning && memory.valid_laps() + 1 >= needed;
        if self.setup.config.delay.estimates() && soon && memory.actuation.is_enough() {
            memory.actuation.seek(&self.setup.car, self.setup.config.horizon.period);
        }
    }

    /// A piece of the decision on delay and lag; whether it is made.
    pub(crate) fn settle_response(&mut self) -> bool {
        let (setup, actuation) = (&self.setup, &mut self.memory.actuation);
        if actuation.is_settled() {
            return true;
        }
        let car = (&setup.car, setup.config.horizon.period);
        match actuation.decide(car, &setup.model, &setup.track, setup.piece()) {
            Decision::Pending => false,
            Decision::Made(found) => {
                self.use_response(found);
                true
            }
        }
    }

    /// Uses what was found: the recorded inputs become what acted, those under way are queued.
    fn use_response(&mut self, found: Option<Response>) {
        let commands = self.memory.actuation.conclude(found);
        let Some(found) = found else { return };
        let reported = self.memory.actuation.is_reported();
        self.apply_learned();
        let dt = self.setup.config.horizon.period;
        let positions = positions(&commands, found.lag, dt);
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
        memory.actuation.found().unwrap_or(Response {
            delay: setup.config.delay.steps as f64 * setup.config.horizon.period,
            lag: setup.car.actuator_lag,
        })
    }

    /// Whether the response was found in the initial laps, or loaded with what was learned in them.
    #[must_use]
    pub fn response_found(&self) -> bool {
        self.memory.actuation.found().is_some()
    }

    /// Takes over a response that was found on another day.
    pub(crate) fn adopt_response(&mut self, found: Option<Response>) {
        self.memory.actuation.adopt(found);
        self.apply_learned();
        self.memory.queue.clear();
        self.memory.queue.resize(self.setup.actuators.periods(), Input::default());
    }
}
