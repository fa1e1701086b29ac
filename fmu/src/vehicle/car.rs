//! The car's parameters as FMU variables.
//!
//! A value left at its start value follows the chosen car; any other value overrides it.

use vehicle_model::{CAR_KEYS, CarDefault, CarKey, CarParams, CarRange};

use crate::table::{Boolean, Real, VariableTable};
use crate::unit;
use crate::values::VariableValues;
use crate::variable::{Role, Variable};

/// Fields of [`CAR_KEYS`] in the order of their value references, which must not move: what is new
/// goes to [`LATER`].
#[rustfmt::skip]
const ORDER: [&str; 34] = [
    "mass", "inertia_z", "l_f", "l_r", "h_cg", "length", "width",
    "tyre_front.b", "tyre_front.c", "tyre_front.mu", "tyre_rear.b", "tyre_rear.c", "tyre_rear.mu",
    "cd", "cl_front", "cl_rear", "area", "rho", "rolling", "linear_drag", "drive_front", "brake_front",
    "power_max", "drive_force_max", "brake_force_max", "a_min", "a_max", "delta_max",
    "delta_rate_max", "a_rate_max", "actuator_lag", "actuator_delay", "blend_speed_low", "blend_speed_high",
];

/// Fields that became variables later; they stand behind all others.
const LATER: [&str; 1] = ["speed_max"];

/// The FMU writes a limit that is absent as 0.
fn value_of(key: &CarKey, car: &CarParams) -> f64 {
    (key.get)(car).unwrap_or_default()
}

fn give(key: &CarKey, car: &mut CarParams, value: f64) {
    let absent = key.default == CarDefault::NoLimit && value <= 0.0;
    (key.set)(car, (!absent).then_some(value));
}

/// The row of a field as an FMU variable.
fn variable(key: &CarKey, start: f64) -> Variable {
    let mut letters = key.meaning.chars();
    let first = letters.next().map(|c| c.to_uppercase().to_string()).unwrap_or_default();
    let absent = if key.default == CarDefault::NoLimit { "; 0: none" } else { "" };
    let text = format!("{first}{}{absent}", letters.as_str());
    let unit = unit::of_symbol(key.unit);
    let variable = Variable::real(&format!("car.{}", key.field), Role::Fixed, unit, &text);
    let variable = variable.start(start);
    match key.range {
        CarRange::Positive | CarRange::NotNegative | CarRange::Steering => variable.at_least(0.0),
        CarRange::Share => variable.range(0.0, 1.0),
        CarRange::Negative => variable,
    }
}

/// Where the car's parameters are in the table.
#[derive(Debug)]
pub(crate) struct CarSlots {
    /// With their start values.
    numbers: Vec<(&'static CarKey, Real, f64)>,
    front_force_yaw: (Boolean, bool),
    combined_slip: (Boolean, bool),
}

impl CarSlots {
    /// Appends `car.*` with the numbers of `start`.
    pub(crate) fn new(table: &mut VariableTable, start: Option<&CarParams>) -> Self {
        let numbers = numbers(table, &ORDER, start);
        let mut switch = |name: &str, on: bool, text: &str| {
            let variable = Variable::boolean(name, Role::Fixed, text);
            (table.add_boolean(variable.start(f64::from(u8::from(on)))), on)
        };
        let front_force_yaw = switch(
            "car.front_force_yaw",
            start.is_some_and(|c| c.front_force_yaw),
            "Whether the longitudinal force of steered front wheels turns the car",
        );
        let combined_slip = switch(
            "car.combined_slip",
            start.is_some_and(|c| c.combined_slip),
            "Whether longitudinal force takes from the lateral force",
        );
        Self { numbers, front_force_yaw, combined_slip }
    }

    /// Appends what became a variable later.
    pub(crate) fn add_later(&mut self, table: &mut VariableTable, start: Option<&CarParams>) {
        self.numbers.extend(numbers(table, &LATER, start));
    }

    /// The chosen car with every value that is not at its start value.
    pub(crate) fn read(&self, values: &VariableValues, chosen: &CarParams) -> CarParams {
        let mut car = chosen.clone();
        for (key, slot, start) in &self.numbers {
            let value = values.real(*slot);
            if value.to_bits() != start.to_bits() {
                give(key, &mut car, value);
            }
        }
        let switched = |(slot, start): (Boolean, bool), chosen: bool| {
            let value = values.boolean(slot);
            if value == start { chosen } else { value }
        };
        car.front_force_yaw = switched(self.front_force_yaw, car.front_force_yaw);
        car.combined_slip = switched(self.combined_slip, car.combined_slip);
        car
    }

    /// Writes the car into the values.
    pub(crate) fn write(&self, car: &CarParams, values: &mut VariableValues) {
        for (key, slot, _) in &self.numbers {
            values.set_real(*slot, value_of(key, car));
        }
        values.set_boolean(self.front_force_yaw.0, car.front_force_yaw);
        values.set_boolean(self.combined_slip.0, car.combined_slip);
    }
}

/// Appends these fields with the numbers of `start`.
fn numbers(
    table: &mut VariableTable,
    fields: &[&str],
    start: Option<&CarParams>,
) -> Vec<(&'static CarKey, Real, f64)> {
    let rows = fields.iter().filter_map(|field| CAR_KEYS.iter().find(|key| key.field == *field));
    rows.map(|key| {
        let start = start.map_or(0.0, |car| value_of(key, car));
        (key, table.add_real(variable(key, start)), start)
    })
    .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_parameter_of_a_car_is_a_variable_with_its_unit() {
        let mut table = VariableTable::new();
        let mut slots = CarSlots::new(&mut table, None);
        slots.add_later(&mut table, None);
        assert_eq!(slots.numbers.len(), CAR_KEYS.len());
        for key in CAR_KEYS {
            let unit = unit::of_symbol(key.unit);
            let plain = key.unit.replace('^', "").replace(' ', ".");
            assert_eq!(unit.name, if plain == "-" { "1" } else { plain.as_str() }, "{}", key.key);
        }
    }

    #[test]
    fn every_shipped_car_survives_the_way_through_the_table() {
        for name in CarParams::builtin_names() {
            let car = CarParams::builtin(name).unwrap();
            let barc = CarParams::builtin("barc").unwrap();
            let mut table = VariableTable::new();
            let mut slots = CarSlots::new(&mut table, Some(&barc));
            slots.add_later(&mut table, Some(&barc));
            let mut values = VariableValues::start(&table);
            slots.write(&car, &mut values);
            for chosen in [&barc, &car] {
                let read = slots.read(&values, chosen);
                // The name is no number.
                let read = CarParams { name: car.name.clone(), ..read };
                assert_eq!(read.fingerprint(), car.fingerprint(), "{name}");
            }
        }
    }
}
