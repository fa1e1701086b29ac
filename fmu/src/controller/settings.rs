//! What a study varies about the controller, as FMU parameters.
//!
//! A number left at its start value follows the preset or the configuration file; any other
//! value overrides it. So a preset and one changed number need no third parameter. From the end of
//! initialisation on, every number is the one in force, and a tunable one acts as it is.

use controller::Config;

use crate::table::{Real, VariableTable};
use crate::unit::{self, Unit};
use crate::values::VariableValues;
use crate::variable::{Role, Variable};

type Get = fn(&Config) -> f64;
type Set = fn(&mut Config, f64);
type Row = (&'static str, Unit, &'static str, [f64; 2], Get, Set);

macro_rules! real {
    ($name:literal, $unit:expr, $text:literal, $range:expr, $($field:ident).+) => {
        ($name, $unit, $text, $range, |c| c.$($field).+, |c, x| c.$($field).+ = x)
    };
}

macro_rules! count {
    ($name:literal, $text:literal, $range:expr, $($field:ident).+) => {
        (
            $name,
            unit::ONE,
            $text,
            $range,
            |c| c.$($field).+ as f64,
            |c, x| c.$($field).+ = x.round() as _,
        )
    };
}

const ROWS: &[Row] = &[
    count!("horizon", "Steps of the horizon, N", [2.0, 200.0], horizon.steps),
    real!("period", unit::S, "Internal period", [1e-3, 1.0], horizon.period),
    count!(
        "substeps",
        "Integration steps of the nominal model per period",
        [1.0, 200.0],
        horizon.substeps
    ),
    count!(
        "safe_set.neighbors",
        "Samples from each lap in the safe set, K",
        [2.0, 200.0],
        safe_set.neighbors
    ),
    count!("safe_set.laps", "Laps in the safe set, P", [1.0, 20.0], safe_set.laps),
    count!(
        "regression.neighbors",
        "Nearest samples of each regression, M",
        [1.0, 500.0],
        regression.neighbors
    ),
    count!(
        "regression.laps",
        "Latest laps searched for neighbours; 0: all",
        [0.0, 1e5],
        regression.laps
    ),
    real!(
        "regression.bandwidth",
        unit::ONE,
        "Kernel bandwidth h",
        [1e-9, 1e9],
        regression.bandwidth
    ),
    real!("regression.ridge", unit::ONE, "Ridge weight", [1e-12, 1e6], regression.ridge),
    real!("cost.input", unit::ONE, "Weight of the squared input", [0.0, 1e6], cost.input),
    real!(
        "cost.control_rate",
        unit::ONE,
        "Weight of the squared input rates (control rate cost, CRC)",
        [0.0, 1e6],
        cost.control_rate
    ),
    real!(
        "cost.acceleration_rate",
        unit::ONE,
        "Factor of the acceleration rate",
        [0.0, 1e6],
        cost.acceleration_rate
    ),
    real!(
        "cost.steering_rate",
        unit::ONE,
        "Factor of the steering rate",
        [0.0, 1e6],
        cost.steering_rate
    ),
    real!(
        "cost.steering_rate_floor",
        unit::ONE,
        "Least weight of the steering rate",
        [0.0, 1e6],
        cost.steering_rate_floor
    ),
    real!(
        "cost.gentle_start",
        unit::ONE,
        "Factor of the acceleration rate in the first learned lap; 0: off",
        [0.0, 1e6],
        cost.gentle_start
    ),
    real!(
        "limits.lane_margin",
        unit::M,
        "Distance kept from either track edge",
        [0.0, 100.0],
        limits.lane_margin
    ),
    real!(
        "limits.front_slip",
        unit::RAD,
        "Guard on the front slip angle; 0: off",
        [0.0, 1.5],
        limits.front_slip
    ),
    real!(
        "limits.rear_slip",
        unit::RAD,
        "Guard on the rear slip angle; 0: off",
        [0.0, 1.5],
        limits.rear_slip
    ),
    real!("limits.speed_cap", unit::M_PER_S, "Speed cap; 0: off", [0.0, 1e3], limits.speed_cap),
    count!("warm_up.laps", "Number of initial laps", [1.0, 1000.0], warm_up.laps),
    real!("warm_up.speed", unit::M_PER_S, "Speed of the initial laps", [0.1, 100.0], warm_up.speed),
    real!(
        "warm_up.noise_a",
        unit::M_PER_S2,
        "Excitation of the acceleration in the initial laps",
        [0.0, 10.0],
        warm_up.noise_a
    ),
    real!(
        "warm_up.noise_delta",
        unit::RAD,
        "Excitation of the steering in the initial laps",
        [0.0, 0.5],
        warm_up.noise_delta
    ),
    count!("seed", "Seed of that excitation", [0.0, 9_007_199_254_740_991.0], warm_up.seed),
    count!("delay", "Whole periods between a command and its effect", [0.0, 20.0], delay.steps),
];

/// What may change while stepping; the controller keeps all it learned.
const TUNABLE: [&str; 2] = ["cost.control_rate", "limits.speed_cap"];

/// Values of the tunable numbers.
pub(crate) type Tuned = [f64; TUNABLE.len()];

/// Where the numbers are in the table.
#[derive(Debug)]
pub(crate) struct Settings {
    numbers: Vec<(Real, f64)>,
}

impl Settings {
    /// Appends `param.*` with the defaults.
    pub(crate) fn new(table: &mut VariableTable) -> Self {
        let config = Config::default();
        let numbers = ROWS.iter().map(|(name, unit, text, [min, max], get, _)| {
            let start = get(&config);
            let role = if TUNABLE.contains(name) { Role::Tunable } else { Role::Fixed };
            let variable = Variable::real(&format!("param.{name}"), role, *unit, text);
            (table.add_real(variable.start(start).range(*min, *max)), start)
        });
        Self { numbers: numbers.collect() }
    }

    /// Writes every fixed number that is not at its start value into the configuration.
    pub(crate) fn apply(&self, values: &VariableValues, config: &mut Config) {
        for ((slot, start), (name, .., set)) in self.numbers.iter().zip(ROWS) {
            let value = values.real(*slot);
            if value.to_bits() != start.to_bits() && !TUNABLE.contains(name) {
                set(config, value);
            }
        }
    }

    /// The tunable numbers at the start: those not at their start value, else the configuration's.
    pub(crate) fn start(&self, values: &VariableValues, config: &Config) -> Tuned {
        let mut tuned = self.tuned(values);
        for (tunable, value) in TUNABLE.iter().zip(&mut tuned) {
            let rows = self.numbers.iter().zip(ROWS).filter(|(_, row)| row.0 == *tunable);
            for ((_, start), (.., get, _)) in rows {
                if value.to_bits() == start.to_bits() {
                    *value = get(config);
                }
            }
        }
        tuned
    }

    /// Writes every number of the configuration into the values.
    pub(crate) fn write(&self, config: &Config, values: &mut VariableValues) {
        for ((slot, _), (.., get, _)) in self.numbers.iter().zip(ROWS) {
            values.set_real(*slot, get(config));
        }
    }

    /// The tunable numbers now, after initialisation.
    pub(crate) fn tuned(&self, values: &VariableValues) -> Tuned {
        TUNABLE.map(|tunable| {
            let place = ROWS.iter().position(|row| row.0 == tunable);
            place.map_or(0.0, |i| values.real(self.numbers[i].0))
        })
    }

    /// Writes every tunable number into the configuration.
    pub(crate) fn tune(&self, tuned: &Tuned, config: &mut Config) {
        for (tunable, value) in TUNABLE.iter().zip(tuned) {
            for (.., set) in ROWS.iter().filter(|row| row.0 == *tunable) {
                set(config, *value);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn start_values_leave_a_preset_alone_and_others_override_it() {
        let mut table = VariableTable::new();
        let settings = Settings::new(&mut table);
        let mut values = VariableValues::start(&table);
        let paper = Config::preset(controller::Preset::Paper);
        let mut config = paper.clone();
        settings.apply(&values, &mut config);
        settings.tune(&settings.start(&values, &paper), &mut config);
        assert_eq!(config, paper);
        for ((slot, start), (.., [_, max], get, _)) in settings.numbers.iter().zip(ROWS) {
            let value = if *start == 7.0 { 8.0 } else { max.min(7.0) };
            values.set_real(*slot, value);
            settings.apply(&values, &mut config);
            settings.tune(&settings.start(&values, &paper), &mut config);
            assert_eq!(get(&config), value);
        }
        let mut read_back = VariableValues::start(&table);
        settings.write(&config, &mut read_back);
        assert_eq!(read_back, values);
    }
}
