//! Late first-order actuators seen from the controller: it decides where the actuator stands at the
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
//!
//! Without lag, an actuator of limited rate r is on its way for |p(dt) - p| / r of the period, which takes
//!
//! ```text
//! (p(dt) - p) |p(dt) - p| / (2 r dt)
//! ```
//!
//! from its mean. The optimal control problem takes this from the plan it is linearised along.
//!
//! A delay of whole periods is a queue. With a fraction phi of a period more, the period of stage t
//! holds the end of the way to u_{t-1} and the beginning of that to u_t:
//!
//! ```text
//! mean = w_0 u_t + w_1 u_{t-1} + w_2 u_{t-2}
//! ```
//!
//! with w_2 = 0 without lag. Two weights take the place of the three, with the same mean delay
//! w_1 + 2 w_2; what is more than a period of it is queued.

use vehicle_model::{CarParams, Input};

use super::Response;

/// A mean delay up to this much before the end of a period counts as a whole one, with a weight of
/// u_{t-1} below 0: otherwise u_t had next to no effect on its own stage.
const NEARLY: f64 = 0.1;

/// Actuators of a car over one period.
#[derive(Debug, Clone)]
pub struct Actuators {
    /// e: share of the way to the command covered in one period.
    share: f64,
    /// beta: weight of the period's end in its mean.
    beta: f64,
    /// Whole periods that what is decided on waits in the queue.
    periods: usize,
    /// 1 / (2 r dt) of each input; 0 for a rate without limit or with lag.
    ramp: Input,
    least: Input,
    most: Input,
}

impl Actuators {
    /// Of a car whose actuators respond so.
    #[must_use]
    pub fn new(car: &CarParams, dt: f64, response: Response) -> Self {
        let Response { delay, lag } = response;
        let share = if lag > 0.0 { -libm::expm1(-dt / lag) } else { 1.0 };
        let whole = (delay / dt + 1e-9).floor();
        let fraction = (delay / dt - whole).max(0.0);
        let mut late = whole;
        let mut beta = (1.0 - lag / dt * share) / share;
        if fraction > 1e-9 {
            // Shares of the way covered on average in the first and the last part of it.
            let way = |from: f64, to: f64| {
                if lag <= 0.0 {
                    return 1.0;
                }
                let left = libm::exp(-from * dt / lag) - libm::exp(-to * dt / lag);
                (1.0 - lag / dt * left / (to - from)) / share
            };
            let (first, last) = (way(0.0, 1.0 - fraction), way(1.0 - fraction, 1.0));
            let mean = (1.0 - fraction) * (1.0 - first) + fraction * (2.0 - last);
            let more = (mean + NEARLY).floor();
            late += more;
            beta = 1.0 - (mean - more);
        }
        // A rate without limit is infinite: the compiler may divide both inputs' at once, whichever has one.
        let ramp = |rate: Option<f64>| match lag <= 0.0 {
            true => 0.5 / (rate.unwrap_or(f64::INFINITY) * dt),
            false => 0.0,
        };
        Self {
            share,
            beta,
            periods: late as usize,
            ramp: Input { a: ramp(car.a_rate_max), delta: ramp(car.delta_rate_max) },
            least: Input { a: car.a_min, delta: -car.delta_max },
            most: Input { a: car.a_max, delta: car.delta_max },
        }
    }

    /// The command that leads from a position to the wanted one, inside the input box, and the
    /// position it reaches.
    #[must_use]
    pub fn lead(&self, position: Input, wanted: Input) -> (Input, Input) {
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
    #[must_use]
    pub fn mean(&self, from: Input, to: Input) -> Input {
        let mean = |from: f64, to: f64| (1.0 - self.beta) * from + self.beta * to;
        let ramp = self.on_the_way(from, to);
        Input { a: mean(from.a, to.a) + ramp.a, delta: mean(from.delta, to.delta) + ramp.delta }
    }

    /// What a limited rate adds to the mean.
    #[must_use]
    pub fn on_the_way(&self, from: Input, to: Input) -> Input {
        let ramp = |from: f64, to: f64, ramp: f64| -ramp * (to - from) * (to - from).abs();
        Input {
            a: ramp(from.a, to.a, self.ramp.a),
            delta: ramp(from.delta, to.delta, self.ramp.delta),
        }
    }

    /// Whole periods of the queue.
    #[must_use]
    pub fn periods(&self) -> usize {
        self.periods
    }

    /// Share of a period's mean that is the position it starts from.
    #[must_use]
    pub fn carried(&self) -> f64 {
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
        let response = Response { delay: 0.0, lag: car.actuator_lag };
        let actuators = Actuators::new(&car, dt, response);
        let (command, reached) = actuators.lead(from, wanted);
        let (mut p, mut sum, h) = (from.a, 0.0, dt / f64::from(steps));
        for _ in 0..steps {
            let next = p + h / car.actuator_lag * (command.a - p);
            sum += 0.5 * (p + next);
            p = next;
        }
        let mean = actuators.mean(from, reached).a;
        assert!((sum / f64::from(steps) - mean).abs() < 1e-5, "{mean}");
        assert!((p - wanted.a).abs() < 1e-5, "{p}");
        assert!((reached.a - wanted.a).abs() < 1e-12);
    }

    /// Positions that rise by 1 in each period, delayed and lagging: the mean over a period, integrated,
    /// is that of the two positions which take the place of three.
    #[test]
    fn a_fraction_of_a_period_keeps_the_mean_delay() {
        let (dt, steps) = (0.1, 20_000);
        for (delay, lag) in [(0.13, 0.0), (0.04, 0.07), (0.06, 0.15), (0.18, 0.02)] {
            let car = CarParams::builtin("barc").unwrap();
            let actuators = Actuators::new(&car, dt, Response { delay, lag });
            let share = if lag > 0.0 { -(-dt / lag).exp_m1() } else { 1.0 };
            let position = |time: f64| {
                let (from, since) = ((time / dt).floor(), time - (time / dt).floor() * dt);
                let command = from + 1.0 / share;
                if lag > 0.0 { command - (-since / lag).exp() / share } else { command }
            };
            let h = dt / f64::from(steps);
            let period = 5.0 * dt;
            let at = |i: u32| position(period + (f64::from(i) + 0.5) * h - delay);
            let exact = (0..steps).map(at).sum::<f64>() / f64::from(steps);
            // What was decided on last before the period leads from 5 to 6.
            let late = actuators.periods() as f64;
            let (from, to) = (5.0 - late, 6.0 - late);
            let input = |a: f64| Input { a, delta: 0.0 };
            let mean = actuators.mean(input(from), input(to)).a;
            assert!((mean - exact).abs() < 1e-4, "{delay} {lag}: {mean} {exact}");
            assert!((-NEARLY..1.0 - NEARLY).contains(&actuators.carried()), "{delay} {lag}");
        }
    }

    #[test]
    fn the_mean_of_a_limited_rate_agrees_with_integration() {
        let (rate, dt, steps) = (1.5, 0.1, 20_000);
        let car = CarParams { delta_rate_max: Some(rate), ..CarParams::builtin("barc").unwrap() };
        let actuators = Actuators::new(&car, dt, Response::default());
        let h = dt / f64::from(steps);
        for (from, to) in [(0.02, 0.1), (0.1, -0.05), (-0.03, -0.03)] {
            let way: f64 = to - from;
            let at = |i: u32| from + way.signum() * way.abs().min(rate * (f64::from(i) + 0.5) * h);
            let exact = (0..steps).map(at).sum::<f64>() / f64::from(steps);
            let input = |delta: f64| Input { a: 0.0, delta };
            let mean = actuators.mean(input(from), input(to)).delta;
            assert!((mean - exact).abs() < 1e-6, "{from} {to}: {mean} {exact}");
        }
    }

    #[test]
    fn without_lag_the_command_is_what_is_wanted() {
        let car = CarParams { actuator_lag: 0.0, ..CarParams::builtin("barc").unwrap() };
        let wanted = Input { a: 0.3, delta: -0.2 };
        let actuators = Actuators::new(&car, 0.1, Response::default());
        assert_eq!(actuators.lead(Input::default(), wanted), (wanted, wanted));
    }
}
