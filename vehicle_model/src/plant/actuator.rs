//! Actuators: limits, transport delay, rate limits and first-order lag, in this order.

use std::collections::VecDeque;

use serde::{Deserialize, Serialize};

use crate::params::CarParams;
use crate::state::Input;

/// Instants closer than this are one [s].
const SAME_INSTANT: f64 = 1e-9;

/// Commands under way and what acts now.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub(super) struct PlantActuators {
    /// Commands by the time they were given, oldest first; the first one in force is kept.
    queue: VecDeque<(f64, Input)>,
    /// Position of the actuators.
    position: Input,
    /// Mean input of the last sub-step.
    applied: Input,
}

impl PlantActuators {
    /// Actuators that stand here.
    pub(super) fn at(position: Input) -> Self {
        Self { queue: VecDeque::new(), position, applied: position }
    }

    /// Takes a command at a time, limited to what the car allows.
    pub(super) fn command(&mut self, car: &CarParams, time: f64, u: Input) {
        let last = self.queue.back().map_or(Input::default(), |(_, u)| *u);
        let or_last = |value: f64, last: f64| if value.is_finite() { value } else { last };
        let u = Input {
            a: or_last(u.a, last.a).clamp(car.a_min, car.a_max),
            delta: or_last(u.delta, last.delta).clamp(-car.delta_max, car.delta_max),
        };
        self.queue.push_back((time, u));
    }

    /// The next instant in (after, before) at which a delayed command takes over [s].
    pub(super) fn next_switch(&self, car: &CarParams, after: f64, before: f64) -> Option<f64> {
        self.queue
            .iter()
            .map(|(given, _)| given + car.actuator_delay)
            .find(|at| *at > after + SAME_INSTANT && *at < before - SAME_INSTANT)
    }

    /// Moves the actuators over a sub-step and returns the mean input that acts in it.
    pub(super) fn advance(&mut self, car: &CarParams, time: f64, h: f64) -> Input {
        let target = self.target(car, time);
        let (a, mean_a) = moved(self.position.a, target.a, car.actuator_lag, car.a_rate_max, h);
        let (delta, mean_delta) =
            moved(self.position.delta, target.delta, car.actuator_lag, car.delta_rate_max, h);
        self.position = Input { a, delta };
        self.applied = Input { a: mean_a, delta: mean_delta };
        self.applied
    }

    /// The command in force at a time; older ones are forgotten.
    fn target(&mut self, car: &CarParams, time: f64) -> Input {
        let due = |given: f64| given + car.actuator_delay <= time + SAME_INSTANT;
        while self.queue.get(1).is_some_and(|(given, _)| due(*given)) {
            self.queue.pop_front();
        }
        match self.queue.front() {
            Some((given, u)) if due(*given) => *u,
            _ => Input::default(),
        }
    }

    pub(super) fn applied(&self) -> Input {
        self.applied
    }
}

/// Position after a sub-step, and the mean position during it.
fn moved(from: f64, target: f64, lag: f64, rate: Option<f64>, h: f64) -> (f64, f64) {
    let wanted = if lag > 0.0 { target + (from - target) * libm::exp(-h / lag) } else { target };
    let most = rate.map_or(f64::INFINITY, |rate| rate * h);
    let reached = wanted.clamp(from - most, from + most);
    let way = reached - from;
    if lag > 0.0 {
        (reached, from + 0.5 * way)
    } else {
        // A ramp at full rate for |way|/most of the sub-step, then rest.
        (reached, reached - 0.5 * way * (way.abs() / most))
    }
}
