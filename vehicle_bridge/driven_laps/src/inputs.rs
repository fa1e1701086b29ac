//! The inputs a car had in each period: recorded ones, averaged, or reckoned from its states.

use vehicle_model::{CarParams, Input};

/// Inputs in force from their times on, averaged over periods.
#[derive(Debug, Clone)]
pub(super) struct Held {
    /// Start of each \[s\].
    times: Vec<f64>,
    inputs: Vec<Input>,
}

impl Held {
    /// What acted, from what was commanded: `delay` \[s\] later, through the car's first-order
    /// actuators, inside its limits. A command that acts at once and without lag is kept.
    pub(super) fn acting(commands: &[(f64, Input)], delay: f64, car: &CarParams) -> Self {
        let limited = |u: &Input| Input {
            a: u.a.clamp(car.a_min, car.a_max),
            delta: u.delta.clamp(-car.delta_max, car.delta_max),
        };
        let lag = car.actuator_lag;
        let mut held = Self { times: Vec::new(), inputs: Vec::new() };
        let Some((_, first)) = commands.first() else { return held };
        let mut position = limited(first);
        for (i, (time, command)) in commands.iter().enumerate() {
            let start = time + delay;
            let command = limited(command);
            if lag <= 0.0 {
                held.push(start, command);
                continue;
            }
            // Steps short against the lag, each with the mean of the way it covers.
            let length = commands.get(i + 1).map_or(lag, |next| next.0 - time);
            let steps = (4.0 * length / lag).ceil().clamp(1.0, 1000.0);
            let h = length / steps;
            let share = -(-h / lag).exp_m1();
            for step in 0..steps as usize {
                let blend = |p: f64, c: f64, share: f64| p + share * (c - p);
                let mean = 1.0 - lag / h * share;
                let acting = Input {
                    a: blend(position.a, command.a, mean),
                    delta: blend(position.delta, command.delta, mean),
                };
                held.push(start + step as f64 * h, acting);
                position = Input {
                    a: blend(position.a, command.a, share),
                    delta: blend(position.delta, command.delta, share),
                };
            }
        }
        held
    }

    /// What acted, as reported.
    pub(super) fn reported(inputs: &[(f64, Input)]) -> Self {
        let (times, inputs) = inputs.iter().copied().unzip();
        Self { times, inputs }
    }

    fn push(&mut self, time: f64, input: Input) {
        self.times.push(time);
        self.inputs.push(input);
    }

    /// Mean over [`from`, `to`]; none where nothing was known for `patience` \[s\] or more.
    pub(super) fn mean(&self, from: f64, to: f64, patience: f64) -> Option<Input> {
        let rounding = 1e-6 * (to - from);
        let first = self.times.partition_point(|&t| t <= from + rounding).checked_sub(1)?;
        let (mut sum, mut at, mut i) = (Input { a: 0.0, delta: 0.0 }, from, first);
        while at < to - rounding {
            if at - self.times[i] > patience {
                return None;
            }
            let end = self.times.get(i + 1).map_or(to, |next| next.min(to));
            // The whole period by one input: its own bits.
            if at <= from && end >= to - rounding {
                return Some(self.inputs[i]);
            }
            sum.a += self.inputs[i].a * (end - at);
            sum.delta += self.inputs[i].delta * (end - at);
            (at, i) = (end, i + 1);
        }
        Some(Input { a: sum.a / (to - from), delta: sum.delta / (to - from) })
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "code of tests")]

    use super::*;

    fn commands() -> Vec<(f64, Input)> {
        let at = |i: i32| (0.1 * f64::from(i), Input { a: f64::from(i % 3), delta: 0.0 });
        (0..40).map(at).collect()
    }

    #[test]
    fn a_period_of_one_input_has_its_bits_and_others_the_mean() {
        let car = CarParams { actuator_lag: 0.0, ..CarParams::builtin("barc").unwrap() };
        let held = Held::acting(&commands(), 0.0, &car);
        assert_eq!(held.mean(0.2, 0.1 * 3.0, 1.0).unwrap().a.to_bits(), 2.0_f64.to_bits());
        let mean = held.mean(0.15, 0.25, 1.0).unwrap();
        assert!((mean.a - 1.5).abs() < 1e-9);
        assert!(held.mean(9.0, 9.1, 1.0).is_none(), "nothing is known of that");
    }

    #[test]
    fn lag_gives_what_fine_integration_gives() {
        let car = CarParams { actuator_lag: 0.07, ..CarParams::builtin("barc").unwrap() };
        let held = Held::acting(&commands(), 0.05, &car);
        let (mut p, h) = (0.0, 1e-5);
        let (mut sum, mut count) = (0.0, 0);
        let mut t = 0.05;
        while t < 2.1 {
            let command = ((((t - 0.05) / 0.1 + 1e-9) as i32) % 3) as f64;
            p += h / car.actuator_lag * (command.min(car.a_max) - p);
            if t >= 2.0 {
                sum += p;
                count += 1;
            }
            t += h;
        }
        let mean = held.mean(2.0, 2.1, 1.0).unwrap().a;
        assert!((mean - sum / f64::from(count)).abs() < 2e-3, "{mean} {}", sum / f64::from(count));
    }
}
