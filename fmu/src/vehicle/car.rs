//! The car's parameters as FMU variables: what is changed of them is changed of the chosen car, and
//! after initialisation they read as the car that drives.

use vehicle_model::CarParams;

use crate::table::{Boolean, Real, Table};
use crate::unit::{self, Unit};
use crate::values::Values;
use crate::variable::{Role, Variable};

type Get = fn(&CarParams) -> f64;
type Set = fn(&mut CarParams, f64);

/// How small and how large a number may be.
#[derive(Clone, Copy)]
enum Range {
    NotNegative,
    Share,
    Any,
}

/// Name, unit, meaning, range and access of one number.
type Row = (&'static str, Unit, &'static str, Range, Get, Set);

/// A field of `CarParams` that is a plain number.
macro_rules! number {
    ($name:literal, $unit:expr, $text:literal, $range:ident, $($field:ident).+) => {
        ($name, $unit, $text, Range::$range, |c| c.$($field).+, |c, x| c.$($field).+ = x)
    };
}

/// A limit that may be absent, which the FMU writes as 0.
macro_rules! limit {
    ($name:literal, $unit:expr, $text:literal, $field:ident) => {
        (
            $name,
            $unit,
            $text,
            Range::NotNegative,
            |c| c.$field.unwrap_or_default(),
            |c, x| c.$field = (x > 0.0).then_some(x),
        )
    };
}

const ROWS: &[Row] = &[
    number!("mass", unit::KG, "Mass", NotNegative, mass),
    number!("inertia_z", unit::KG_M2, "Yaw inertia", NotNegative, inertia_z),
    number!("l_f", unit::M, "Centre of gravity to front axle", NotNegative, l_f),
    number!("l_r", unit::M, "Centre of gravity to rear axle", NotNegative, l_r),
    number!(
        "h_cg",
        unit::M,
        "Height of the centre of gravity; 0: no load transfer",
        NotNegative,
        h_cg
    ),
    number!("length", unit::M, "Body length", NotNegative, length),
    number!("width", unit::M, "Body width", NotNegative, width),
    number!("tyre_front.b", unit::ONE, "Front tyre, stiffness factor B", NotNegative, tyre_front.b),
    number!("tyre_front.c", unit::ONE, "Front tyre, shape factor C", NotNegative, tyre_front.c),
    number!(
        "tyre_front.mu",
        unit::ONE,
        "Front tyre, peak friction coefficient",
        NotNegative,
        tyre_front.mu
    ),
    number!("tyre_rear.b", unit::ONE, "Rear tyre, stiffness factor B", NotNegative, tyre_rear.b),
    number!("tyre_rear.c", unit::ONE, "Rear tyre, shape factor C", NotNegative, tyre_rear.c),
    number!(
        "tyre_rear.mu",
        unit::ONE,
        "Rear tyre, peak friction coefficient",
        NotNegative,
        tyre_rear.mu
    ),
    number!("cd", unit::ONE, "Drag coefficient; 0: off", NotNegative, cd),
    number!(
        "cl_front",
        unit::ONE,
        "Downforce coefficient, front axle; 0: off",
        NotNegative,
        cl_front
    ),
    number!("cl_rear", unit::ONE, "Downforce coefficient, rear axle; 0: off", NotNegative, cl_rear),
    number!("area", unit::M2, "Reference area of drag and downforce", NotNegative, area),
    number!("rho", unit::KG_PER_M3, "Density of air", NotNegative, rho),
    number!("rolling", unit::ONE, "Rolling resistance coefficient; 0: off", Share, rolling),
    number!("linear_drag", unit::PER_S, "Deceleration per speed; 0: off", NotNegative, linear_drag),
    number!(
        "drive_front",
        unit::ONE,
        "Share of driving force on the front axle",
        Share,
        drive_front
    ),
    number!(
        "brake_front",
        unit::ONE,
        "Share of braking force on the front axle",
        Share,
        brake_front
    ),
    limit!("power_max", unit::W, "Limit of driving power; 0: none", power_max),
    limit!("drive_force_max", unit::N, "Limit of driving force; 0: none", drive_force_max),
    limit!("brake_force_max", unit::N, "Limit of braking force; 0: none", brake_force_max),
    number!("a_min", unit::M_PER_S2, "Strongest braking command, negative", Any, a_min),
    number!("a_max", unit::M_PER_S2, "Strongest driving command", NotNegative, a_max),
    number!("delta_max", unit::RAD, "Steering stop on each side", NotNegative, delta_max),
    limit!(
        "delta_rate_max",
        unit::RAD_PER_S,
        "Limit of the steering rate; 0: none",
        delta_rate_max
    ),
    limit!("a_rate_max", unit::M_PER_S3, "Limit of the rate of acceleration; 0: none", a_rate_max),
    number!(
        "actuator_lag",
        unit::S,
        "First-order time constant of the actuators; 0: off",
        NotNegative,
        actuator_lag
    ),
    number!(
        "actuator_delay",
        unit::S,
        "Transport delay of the inputs; 0: off",
        NotNegative,
        actuator_delay
    ),
    number!(
        "blend_speed_low",
        unit::M_PER_S,
        "At and below: kinematic lateral dynamics",
        NotNegative,
        blend_speed_low
    ),
    number!(
        "blend_speed_high",
        unit::M_PER_S,
        "At and above: tyre model alone",
        NotNegative,
        blend_speed_high
    ),
];

/// Where the car's parameters are in the table.
#[derive(Debug)]
pub(crate) struct CarSlots {
    /// Each with its start value.
    numbers: Vec<(Real, f64)>,
    front_force_yaw: (Boolean, bool),
    combined_slip: (Boolean, bool),
}

impl CarSlots {
    /// Appends `car.*` with the numbers of `start`.
    pub(crate) fn new(table: &mut Table, start: Option<&CarParams>) -> Self {
        let numbers = ROWS.iter().map(|(name, unit, text, range, get, _)| {
            let name = format!("car.{name}");
            let number = start.map_or(0.0, get);
            let variable = Variable::real(&name, Role::Fixed, *unit, text).start(number);
            let slot = table.add_real(match range {
                Range::NotNegative => variable.at_least(0.0),
                Range::Share => variable.range(0.0, 1.0),
                Range::Any => variable,
            });
            (slot, number)
        });
        let numbers = numbers.collect();
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

    /// A car with every parameter that is not at its start value; the start values are those of
    /// the car everything starts from.
    pub(crate) fn over(&self, values: &Values, mut car: CarParams) -> CarParams {
        for ((slot, start), (.., set)) in self.numbers.iter().zip(ROWS) {
            let value = values.real(*slot);
            if value.to_bits() != start.to_bits() {
                set(&mut car, value);
            }
        }
        let changed = |(slot, start): (Boolean, bool)| {
            let on = values.boolean(slot);
            (on != start).then_some(on)
        };
        car.front_force_yaw = changed(self.front_force_yaw).unwrap_or(car.front_force_yaw);
        car.combined_slip = changed(self.combined_slip).unwrap_or(car.combined_slip);
        car
    }

    /// Writes a car's numbers over the variables.
    pub(crate) fn publish(&self, car: &CarParams, values: &mut Values) {
        for ((slot, _), (.., get, _)) in self.numbers.iter().zip(ROWS) {
            values.set_real(*slot, get(car));
        }
        values.set_boolean(self.front_force_yaw.0, car.front_force_yaw);
        values.set_boolean(self.combined_slip.0, car.combined_slip);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_shipped_car_survives_the_way_through_the_table() {
        for name in CarParams::builtin_names() {
            let (car, barc) =
                (CarParams::builtin(name).unwrap(), CarParams::builtin("barc").unwrap());
            let mut table = Table::new();
            let slots = CarSlots::new(&mut table, Some(&barc));
            let mut values = Values::start(&table);
            let chosen = slots.over(&values, car.clone());
            assert_eq!(chosen.fingerprint(), car.fingerprint(), "{name}: start values override");
            slots.publish(&car, &mut values);
            let rebuilt = slots.over(&values, barc.clone());
            assert_eq!(rebuilt.fingerprint(), car.fingerprint(), "{name}");
            assert_eq!(slots.over(&values, car.clone()).fingerprint(), car.fingerprint());
        }
    }
}
