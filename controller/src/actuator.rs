//! First-order actuators seen from the controller: it decides on the mean input of a period and
//! commands what makes the lagging actuator deliver that mean.
//!
//! With time constant T, position p at the start of a period of length dt and command c,
//!
//! ```text
//! p(t)  = c + (p - c) exp(-t/T)
//! mean  = p + m (c - p),   m = 1 - T/dt (1 - exp(-dt/T))
//! ```
//!
//! so that c = p + (mean - p) / m. The command stays in the input box; what then acts is known.

use vehicle_model::{CarParams, Input};

/// Actuators of a car over one period.
#[derive(Debug, Clone)]
pub(crate) struct Actuators {
    /// m: share of a command's step that acts on average in its first period.
    mean_share: f64,
    /// 1 - exp(-dt/T): share of the way covered at the end of the period.
    end_share: f64,
    least: Input,
    most: Input,
}

/// Outcome of a command.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Driven {
    /// What to command.
    pub(crate) command: Input,
    /// Mean input that then acts.
    pub(crate) mean: Input,
    /// Position at the end of the period.
    pub(crate) position: Input,
}

impl Actuators {
    pub(crate) fn new(car: &CarParams, dt: f64) -> Self {
        let lag = car.actuator_lag;
        let end_share = if lag > 0.0 { -(-dt / lag).exp_m1() } else { 1.0 };
        Self {
            mean_share: 1.0 - lag / dt * end_share,
            end_share,
            least: Input { a: car.a_min, delta: -car.delta_max },
            most: Input { a: car.a_max, delta: car.delta_max },
        }
    }

    /// The command for a wanted mean input, from a position.
    pub(crate) fn drive(&self, position: Input, wanted: Input) -> Driven {
        let axis = |position: f64, wanted: f64, least: f64, most: f64| {
            if self.end_share >= 1.0 {
                return (wanted, wanted, wanted);
            }
            let command = (position + (wanted - position) / self.mean_share).clamp(least, most);
            let way = command - position;
            (command, position + self.mean_share * way, position + self.end_share * way)
        };
        let a = axis(position.a, wanted.a, self.least.a, self.most.a);
        let delta = axis(position.delta, wanted.delta, self.least.delta, self.most.delta);
        Driven {
            command: Input { a: a.0, delta: delta.0 },
            mean: Input { a: a.1, delta: delta.1 },
            position: Input { a: a.2, delta: delta.2 },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mean_and_end_agree_with_integration() {
        let car = CarParams { actuator_lag: 0.07, ..CarParams::builtin("iac").unwrap() };
        let (dt, steps) = (0.1, 100_000);
        let from = Input { a: -1.0, delta: 0.05 };
        let driven = Actuators::new(&car, dt).drive(from, Input { a: 0.5, delta: 0.07 });
        let (mut p, mut sum, h) = (from.a, 0.0, dt / f64::from(steps));
        for _ in 0..steps {
            let next = p + h / car.actuator_lag * (driven.command.a - p);
            sum += 0.5 * (p + next);
            p = next;
        }
        assert!((sum / f64::from(steps) - 0.5).abs() < 1e-5);
        assert!((driven.mean.a - 0.5).abs() < 1e-12);
        assert!((driven.position.a - p).abs() < 1e-5);
    }

    #[test]
    fn without_lag_the_command_is_what_is_wanted() {
        let car = CarParams { actuator_lag: 0.0, ..CarParams::builtin("barc").unwrap() };
        let wanted = Input { a: 0.3, delta: -0.2 };
        let driven = Actuators::new(&car, 0.1).drive(Input::default(), wanted);
        assert_eq!(driven, Driven { command: wanted, mean: wanted, position: wanted });
    }
}
