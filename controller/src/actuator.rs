//! First-order actuators seen from the controller: it decides where the actuator stands at the
//! end of the period and commands what brings it there.
//!
//! With time constant T, position p at the start of a period of length dt and command c,
//!
//! ```text
//! p(dt) = p + e (c - p),   e = 1 - exp(-dt/T),   so that   c = p + (p(dt) - p) / e
//! ```
//!
//! Commanding what brings the *mean* of the period there would ring: p would overshoot by 72 %
//! where T = dt. What acts on the car is still the mean,
//!
//! ```text
//! mean = (1 - beta) p + beta p(dt),   beta = m / e,   m = 1 - T/dt e
//! ```
//!
//! so that stage t of the optimal control problem depends on u_{t-1} too.

use vehicle_model::{CarParams, Input};

/// Actuators of a car over one period.
#[derive(Debug, Clone)]
pub(crate) struct Actuators {
    /// e: share of the way to the command covered in one period.
    share: f64,
    /// beta: weight of the period's end in its mean.
    beta: f64,
    least: Input,
    most: Input,
}

impl Actuators {
    pub(crate) fn new(car: &CarParams, dt: f64) -> Self {
        let lag = car.actuator_lag;
        let share = if lag > 0.0 { -libm::expm1(-dt / lag) } else { 1.0 };
        Self {
            share,
            beta: (1.0 - lag / dt * share) / share,
            least: Input { a: car.a_min, delta: -car.delta_max },
            most: Input { a: car.a_max, delta: car.delta_max },
        }
    }

    /// The command that leads from a position to the wanted one, inside the input box, and the
    /// position it reaches.
    pub(crate) fn lead(&self, position: Input, wanted: Input) -> (Input, Input) {
        let axis = |position: f64, wanted: f64, least: f64, most: f64| {
            if self.share >= 1.0 {
                return (wanted, wanted);
            }
            let command = (position + (wanted - position) / self.share).clamp(least, most);
            (command, position + self.share * (command - position))
        };
        let a = axis(position.a, wanted.a, self.least.a, self.most.a);
        let delta = axis(position.delta, wanted.delta, self.least.delta, self.most.delta);
        (Input { a: a.0, delta: delta.0 }, Input { a: a.1, delta: delta.1 })
    }
}

impl Actuators {
    /// Mean input of a period that leads from one position to another.
    pub(crate) fn mean(&self, from: Input, to: Input) -> Input {
        let mean = |from: f64, to: f64| (1.0 - self.beta) * from + self.beta * to;
        Input { a: mean(from.a, to.a), delta: mean(from.delta, to.delta) }
    }

    /// Share of a period's mean that is the position it starts from.
    pub(crate) fn carried(&self) -> f64 {
        1.0 - self.beta
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_position_reached_agrees_with_integration() {
        let car = CarParams { actuator_lag: 0.07, ..CarParams::builtin("iac").unwrap() };
        let (dt, steps) = (0.1, 100_000);
        let (from, wanted) = (Input { a: -1.0, delta: 0.05 }, Input { a: 0.5, delta: 0.07 });
        let (command, reached) = Actuators::new(&car, dt).lead(from, wanted);
        let (mut p, mut sum, h) = (from.a, 0.0, dt / f64::from(steps));
        for _ in 0..steps {
            let next = p + h / car.actuator_lag * (command.a - p);
            sum += 0.5 * (p + next);
            p = next;
        }
        let mean = Actuators::new(&car, dt).mean(from, reached).a;
        assert!((sum / f64::from(steps) - mean).abs() < 1e-5, "{mean}");
        assert!((p - wanted.a).abs() < 1e-5, "{p}");
        assert!((reached.a - wanted.a).abs() < 1e-12);
    }

    #[test]
    fn without_lag_the_command_is_what_is_wanted() {
        let car = CarParams { actuator_lag: 0.0, ..CarParams::builtin("barc").unwrap() };
        let wanted = Input { a: 0.3, delta: -0.2 };
        assert_eq!(Actuators::new(&car, 0.1).lead(Input::default(), wanted), (wanted, wanted));
    }
}
