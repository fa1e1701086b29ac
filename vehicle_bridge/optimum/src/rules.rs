//! Limits of the actuators and the engine, as inequalities g >= 0 of an interval.

use vehicle_model::CarParams;

use crate::interval::{Block, Curvature, Derivatives, NZ, Node, Values};

/// Index of the first input among the variables of a node.
const INPUTS: usize = 5;

/// A limit that holds in every interval. The inputs are positions of the actuators, linear in s.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Rule {
    /// The position moves at most so fast: time * rate +- change >= 0.
    Rate { variable: usize, sign: f64, rate: f64 },
    /// The command that moves a lagging actuator stays below (sign -1) or above (sign 1) its
    /// stop: time/lag * distance of the mean position from the stop +- change >= 0.
    Lag { variable: usize, sign: f64, lag: f64, stop: f64 },
    /// Driving power at the beginning of the interval: 1 - a v_x/limit >= 0.
    Power { limit: f64 },
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
                if let Some(rate) = rate {
                    rules.push(Rule::Rate { variable, sign, rate });
                }
                if car.actuator_lag > 0.0 {
                    rules.push(Rule::Lag { variable, sign, lag: car.actuator_lag, stop });
                }
            }
        }
        if let Some(power) = car.power_max {
            rules.push(Rule::Power { limit: power / car.mass });
        }
        Self { rules }
    }

    /// Inequalities of one interval.
    pub(crate) fn len(&self) -> usize {
        self.rules.len()
    }

    /// Values of the inequalities of an interval that takes `time`.
    pub(crate) fn values<'a>(
        &'a self,
        z: [&'a Node; 2],
        values: &'a Values,
        scale: &'a Node,
    ) -> impl Iterator<Item = f64> + 'a {
        self.rules.iter().map(move |rule| match rule {
            Rule::Power { limit } => 1.0 - z[0][0] * z[0][INPUTS] / limit,
            Rule::Rate { variable, sign, .. } | Rule::Lag { variable, sign, .. } => {
                let change = z[1][*variable] - z[0][*variable];
                (values.time * rule.speed(z).0 + sign * change) / scale[*variable]
            }
        })
    }

    /// Slope of inequality `index` of an interval.
    pub(crate) fn slope(
        &self,
        index: usize,
        z: [&Node; 2],
        interval: &Derivatives,
        scale: &Node,
    ) -> [Node; 2] {
        let rule = &self.rules[index];
        let (variable, sign) = match *rule {
            Rule::Power { limit } => {
                let mut gradient = [Node::zeros(); 2];
                gradient[0][0] = -z[0][INPUTS] / limit;
                gradient[0][INPUTS] = -z[0][0] / limit;
                return gradient;
            }
            Rule::Rate { variable, sign, .. } | Rule::Lag { variable, sign, .. } => {
                (variable, sign)
            }
        };
        let (speed, by_position) = rule.speed(z);
        let time = interval.values.time;
        let mut gradient = interval.time.map(|slope| slope * speed);
        gradient[0][variable] += time * by_position - sign;
        gradient[1][variable] += time * by_position + sign;
        gradient.map(|slope| slope / scale[variable])
    }

    /// Weight that `multiplier` times inequality `index` puts on the interval's time, and what
    /// else its curvature has, which is added.
    pub(crate) fn curvature(
        &self,
        index: usize,
        multiplier: f64,
        z: [&Node; 2],
        interval: &Derivatives,
        scale: &Node,
        sum: &mut Curvature,
    ) -> f64 {
        let rule = &self.rules[index];
        let variable = match *rule {
            Rule::Power { limit } => {
                sum.begin[(0, INPUTS)] -= multiplier / limit;
                sum.begin[(INPUTS, 0)] -= multiplier / limit;
                return 0.0;
            }
            Rule::Rate { variable, .. } | Rule::Lag { variable, .. } => variable,
        };
        let (speed, by_position) = rule.speed(z);
        let weight = multiplier / scale[variable];
        if by_position != 0.0 {
            let [begin, end] = interval.time.map(|slope| slope * (weight * by_position));
            add_cross(&mut sum.begin, &begin, variable);
            add_cross(&mut sum.end, &end, variable);
            for i in 0..NZ {
                sum.mixed[(i, variable)] += begin[i];
                sum.mixed[(variable, i)] += end[i];
            }
        }
        weight * speed
    }
}

impl Rule {
    /// Allowed speed of the position, and its derivative by the position of either node.
    fn speed(&self, z: [&Node; 2]) -> (f64, f64) {
        match *self {
            Self::Rate { rate, .. } => (rate, 0.0),
            Self::Lag { variable, sign, lag, stop } => {
                let mean = f64::midpoint(z[0][variable], z[1][variable]);
                (sign * (mean - stop) / lag, 0.5 * sign / lag)
            }
            Self::Power { .. } => (0.0, 0.0),
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
