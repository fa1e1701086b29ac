//! Limits of the actuators and the engine, as inequalities g >= 0 of an interval.

use vehicle_model::CarParams;
use vehicle_model::params::GOVERNOR_GAIN;

use crate::interval::{Block, Curvature, Derivatives, NZ, Node, Values};

/// Index of the first input among the variables of a node.
const INPUTS: usize = 5;

/// Gain of the governor's limit: half of the car's own, which then does not act inside an interval,
/// where the speed is above the nodes' mean \[1/s\].
const GOVERNOR: f64 = 0.5 * GOVERNOR_GAIN;

/// A limit that holds in every interval, at its beginning (`end` 0) or its end (1). The inputs are
/// positions of the actuators, linear in s.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Rule {
    /// An actuator moves, down (sign 1) or up (sign -1), at most so fast as it does at the given
    /// end: length * pace * speed +- change >= 0.
    Moves { variable: usize, end: usize, sign: f64, speed: Speed },
    /// Driving power at the beginning of the interval, or in its middle, between the nodes' means:
    /// 1 - a v_x/limit >= 0.
    Power { limit: f64, share: [f64; 2] },
    /// The governor near the top speed, at the beginning: 1 - v_x/top - a/(GOVERNOR top) >= 0.
    Governor { top: f64 },
}

/// Largest speed of an actuator.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Speed {
    /// A limit of the rate.
    Rate(f64),
    /// Of an actuator that lags behind a command between its stops: the distance to the stop
    /// ahead divided by the lag.
    Lag { lag: f64, stop: f64 },
}

/// All limits of a car.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Rules {
    rules: Vec<Rule>,
}

impl Rules {
    /// The limits of a car whose inputs stay between `stops`.
    pub(crate) fn new(car: &CarParams, stops: &[[f64; 2]; 2]) -> Self {
        let mut rules = Vec::new();
        let rates = [car.a_rate_max, car.delta_rate_max];
        for (i, (stops, rate)) in stops.iter().zip(rates).enumerate() {
            let variable = INPUTS + i;
            for (sign, stop) in [(-1.0, stops[1]), (1.0, stops[0])] {
                let lag = car.actuator_lag;
                let by_lag = (lag > 0.0).then_some(Speed::Lag { lag, stop });
                for speed in rate.map(Speed::Rate).into_iter().chain(by_lag) {
                    for end in 0..2 {
                        rules.push(Rule::Moves { variable, end, sign, speed });
                    }
                }
            }
        }
        if let Some(power) = car.power_max {
            let limit = power / car.mass;
            rules.push(Rule::Power { limit, share: [1.0, 0.0] });
            rules.push(Rule::Power { limit, share: [0.5, 0.5] });
        }
        rules.extend(car.speed_max.map(|top| Rule::Governor { top }));
        Self { rules }
    }

    /// Inequalities of one interval.
    pub(crate) fn len(&self) -> usize {
        self.rules.len()
    }

    /// Values of the inequalities of an interval of this length.
    pub(crate) fn values<'a>(
        &'a self,
        z: [&'a Node; 2],
        length: f64,
        values: &'a Values,
        scale: &'a Node,
    ) -> impl Iterator<Item = f64> + 'a {
        self.rules.iter().map(move |rule| match *rule {
            Rule::Power { limit, share } => {
                let at = z[0] * share[0] + z[1] * share[1];
                1.0 - at[0] * at[INPUTS] / limit
            }
            Rule::Governor { top } => 1.0 - z[0][0] / top - z[0][INPUTS] / (GOVERNOR * top),
            Rule::Moves { variable, end, sign, speed } => {
                let (speed, _) = speed.at(z[end][variable], sign);
                let change = z[1][variable] - z[0][variable];
                (length * values.pace[end] * speed + sign * change) / scale[variable]
            }
        })
    }

    /// Slope of inequality `index` of an interval by both nodes.
    pub(crate) fn slope(
        &self,
        index: usize,
        z: [&Node; 2],
        interval: &Derivatives,
        scale: &Node,
    ) -> [Node; 2] {
        let mut slope = [Node::zeros(); 2];
        match self.rules[index] {
            Rule::Power { limit, share } => {
                let at = z[0] * share[0] + z[1] * share[1];
                for (slope, share) in slope.iter_mut().zip(share) {
                    slope[0] = -share * at[INPUTS] / limit;
                    slope[INPUTS] = -share * at[0] / limit;
                }
                slope
            }
            Rule::Governor { top } => {
                slope[0][0] = -1.0 / top;
                slope[0][INPUTS] = -1.0 / (GOVERNOR * top);
                slope
            }
            Rule::Moves { variable, end, sign, speed } => {
                let (speed, by_position) = speed.at(z[end][variable], sign);
                slope[end] = interval.pace_slope(end) * (interval.length * speed);
                slope[end][variable] += interval.length * interval.values.pace[end] * by_position;
                slope[0][variable] -= sign;
                slope[1][variable] += sign;
                slope.map(|slope| slope / scale[variable])
            }
        }
    }

    /// The end whose pace `multiplier` times inequality `index` puts a weight on, and that weight;
    /// what else its curvature has is added to `sum`.
    pub(crate) fn curvature(
        &self,
        index: usize,
        multiplier: f64,
        z: [&Node; 2],
        interval: &Derivatives,
        scale: &Node,
        sum: &mut Curvature,
    ) -> (usize, f64) {
        match self.rules[index] {
            Rule::Power { limit, share: [begin, end] } => {
                let blocks = [
                    (&mut sum.begin, begin * begin),
                    (&mut sum.mixed, begin * end),
                    (&mut sum.end, end * end),
                ];
                for (block, share) in blocks {
                    block[(0, INPUTS)] -= share * multiplier / limit;
                    block[(INPUTS, 0)] -= share * multiplier / limit;
                }
                (0, 0.0)
            }
            Rule::Governor { .. } => (0, 0.0),
            Rule::Moves { variable, end, sign, speed } => {
                let (speed, by_position) = speed.at(z[end][variable], sign);
                let weight = multiplier * interval.length / scale[variable];
                if by_position != 0.0 {
                    let slope = interval.pace_slope(end) * (weight * by_position);
                    let block = if end == 0 { &mut sum.begin } else { &mut sum.end };
                    add_cross(block, &slope, variable);
                }
                (end, weight * speed)
            }
        }
    }
}

impl Speed {
    /// The speed at a position, and its derivative by the position.
    fn at(self, position: f64, sign: f64) -> (f64, f64) {
        match self {
            Self::Rate(rate) => (rate, 0.0),
            Self::Lag { lag, stop } => (sign * (position - stop) / lag, sign / lag),
        }
    }
}

/// Adds the symmetric product of `slope` and the unit vector of `variable`.
fn add_cross(block: &mut Block, slope: &Node, variable: usize) {
    for i in 0..NZ {
        block[(i, variable)] += slope[i];
        block[(variable, i)] += slope[i];
    }
}
