//! The parameters of a car: one table of key, symbol, unit, range, default and meaning.
//!
//! Checks, fingerprint, written car files, the FMU's `car.*` variables and the reference page come from
//! it. Its order is that of the fingerprint: a new parameter goes to the end of its group's rows in
//! [`CarParams`], and joins the fingerprint only where it is not at its default.

use std::fmt::Write as _;

use super::CarParams;

/// What a number must satisfy.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CarRange {
    /// Above 0.
    Positive,
    /// 0 or above.
    NotNegative,
    /// Below 0.
    Negative,
    /// From 0 to 1.
    Share,
    /// Above 0 and at most [`CarRange::MOST_STEERING`].
    Steering,
}

impl CarRange {
    /// Largest steering stop: the wheels of real cars turn by up to 1.07, and the model's forces grow
    /// without bound towards pi/2 \[rad\].
    pub const MOST_STEERING: f64 = 1.2;

    /// Whether a finite value lies inside.
    #[must_use]
    pub fn holds(self, value: f64) -> bool {
        value.is_finite()
            && match self {
                Self::Positive => value > 0.0,
                Self::NotNegative => value >= 0.0,
                Self::Negative => value < 0.0,
                Self::Share => (0.0..=1.0).contains(&value),
                Self::Steering => value > 0.0 && value <= Self::MOST_STEERING,
            }
    }

    /// The range in words.
    #[must_use]
    pub const fn text(self) -> &'static str {
        match self {
            Self::Positive => "a number above 0",
            Self::NotNegative => "a number of 0 or above",
            Self::Negative => "a number below 0",
            Self::Share => "a share between 0 and 1",
            Self::Steering => "an angle of the wheels above 0 and at most 1.2 rad (69 degrees)",
        }
    }

    /// The range as an interval.
    #[must_use]
    pub const fn interval(self) -> &'static str {
        match self {
            Self::Positive => "(0, inf)",
            Self::NotNegative => "[0, inf)",
            Self::Negative => "(-inf, 0)",
            Self::Share => "[0, 1]",
            Self::Steering => "(0, 1.2]",
        }
    }
}

/// What a car file without the key gets.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum CarDefault {
    /// Nothing: the key must be there.
    Required,
    /// 0: the effect is off.
    Off,
    /// No limit.
    NoLimit,
    /// What follows from other keys, in words.
    Derived(&'static str),
}

impl CarDefault {
    /// The default in words.
    #[must_use]
    pub const fn text(self) -> &'static str {
        match self {
            Self::Required => "required",
            Self::Off => "0",
            Self::NoLimit => "no limit",
            Self::Derived(text) => text,
        }
    }
}

/// A group of parameters in car files.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CarGroup {
    /// Masses and lengths.
    Body,
    /// Drag, downforce and rolling resistance.
    Resistance,
    /// Engine and brakes.
    Drive,
    /// Limits of commands.
    Command,
    /// Lag and delay.
    Actuators,
    /// Speeds between rolling wheels and tyre model.
    Blend,
    /// The front tyre.
    FrontTyre,
    /// The rear tyre.
    RearTyre,
}

impl CarGroup {
    /// All groups, in the order of car files.
    pub const ALL: [Self; 8] = [
        Self::Body,
        Self::Resistance,
        Self::Drive,
        Self::Command,
        Self::Actuators,
        Self::Blend,
        Self::FrontTyre,
        Self::RearTyre,
    ];

    /// Section of the car file; empty for the top level.
    #[must_use]
    pub const fn section(self) -> &'static str {
        match self {
            Self::FrontTyre => "tyre_front",
            Self::RearTyre => "tyre_rear",
            _ => "",
        }
    }

    /// What its parameters are about.
    #[must_use]
    pub const fn heading(self) -> &'static str {
        match self {
            Self::Body => "Body.",
            Self::Resistance => "What resists and what presses down; 0 switches each off.",
            Self::Drive => "Engine and brakes.",
            Self::Command => "What the controller may ask of the car.",
            Self::Actuators => "Actuators; 0 switches each off.",
            Self::Blend => {
                "Between these speeds rolling wheels give way to the tyre model; both 0: never."
            }
            Self::FrontTyre => "Lateral tyre of the front axle.",
            Self::RearTyre => "Lateral tyre of the rear axle.",
        }
    }

    /// Its rows of [`CAR_KEYS`], in their order.
    pub fn keys(self) -> impl Iterator<Item = &'static CarKey> {
        CAR_KEYS.iter().filter(move |key| key.group == self)
    }
}

/// One parameter of a car.
#[derive(Debug, Clone, Copy)]
pub struct CarKey {
    /// Group, and with it the section of the car file.
    pub group: CarGroup,
    /// Key in the car file, with the unit at its end.
    pub key: &'static str,
    /// Field of [`CarParams`], as in FMU variables: `tyre_front.b`.
    pub field: &'static str,
    /// Symbol in the equations.
    pub symbol: &'static str,
    /// Unit.
    pub unit: &'static str,
    /// Range.
    pub range: CarRange,
    /// What its absence means.
    pub default: CarDefault,
    /// What it is.
    pub meaning: &'static str,
    /// The value of a car; none for a limit that it does not have.
    pub get: fn(&CarParams) -> Option<f64>,
    /// Gives a car the value; none takes a limit away, and changes nothing else.
    pub set: fn(&mut CarParams, Option<f64>),
}

/// A row: group, key, symbol, unit, range, default, meaning, field.
macro_rules! number {
    ($group:ident, $key:literal, $symbol:literal, $unit:literal, $range:ident, $default:expr,
     $meaning:literal, $name:literal = $($field:ident).+) => {
        CarKey {
            group: CarGroup::$group,
            key: $key,
            field: $name,
            symbol: $symbol,
            unit: $unit,
            range: CarRange::$range,
            default: $default,
            meaning: $meaning,
            get: |car| Some(car.$($field).+),
            set: |car, value| car.$($field).+ = value.unwrap_or(car.$($field).+),
        }
    };
}

/// A row of a limit that a car need not have.
macro_rules! limit {
    ($group:ident, $key:literal, $symbol:literal, $unit:literal, $meaning:literal,
     $name:literal = $field:ident) => {
        CarKey {
            group: CarGroup::$group,
            key: $key,
            field: $name,
            symbol: $symbol,
            unit: $unit,
            range: CarRange::Positive,
            default: NoLimit,
            meaning: $meaning,
            get: |car| car.$field,
            set: |car, value| car.$field = value,
        }
    };
}

use CarDefault::{Derived, NoLimit, Off, Required};

const STIFFNESS: CarDefault = Derived("from cornering_stiffness_*");
const SHAPE: CarDefault = Derived("1.3 with cornering_stiffness_*");
const PEAK: CarDefault = Derived("from peak_n");

/// All parameters of a car but its name and its switches.
#[rustfmt::skip]
pub const CAR_KEYS: &[CarKey] = &[
    number!(Body, "mass_kg", "m", "kg", Positive, Required, "mass with driver and fuel", "mass" = mass),
    number!(Body, "inertia_z_kgm2", "I_z", "kg m^2", Positive, Required, "yaw inertia", "inertia_z" = inertia_z),
    number!(Body, "l_f_m", "l_f", "m", Positive, Required, "centre of gravity to front axle", "l_f" = l_f),
    number!(Body, "l_r_m", "l_r", "m", Positive, Required, "centre of gravity to rear axle", "l_r" = l_r),
    number!(FrontTyre, "b", "B_f", "-", Positive, STIFFNESS, "stiffness factor B of the front tyre", "tyre_front.b" = tyre_front.b),
    number!(FrontTyre, "c", "C_f", "-", Positive, SHAPE, "shape factor C of the front tyre", "tyre_front.c" = tyre_front.c),
    number!(FrontTyre, "mu", "mu_f", "-", Positive, PEAK, "peak friction coefficient of the front tyre", "tyre_front.mu" = tyre_front.mu),
    number!(RearTyre, "b", "B_r", "-", Positive, STIFFNESS, "stiffness factor B of the rear tyre", "tyre_rear.b" = tyre_rear.b),
    number!(RearTyre, "c", "C_r", "-", Positive, SHAPE, "shape factor C of the rear tyre", "tyre_rear.c" = tyre_rear.c),
    number!(RearTyre, "mu", "mu_r", "-", Positive, PEAK, "peak friction coefficient of the rear tyre", "tyre_rear.mu" = tyre_rear.mu),
    number!(Body, "h_cg_m", "h", "m", NotNegative, Off, "height of the centre of gravity; 0: no load transfer", "h_cg" = h_cg),
    number!(Resistance, "cd", "c_d", "-", NotNegative, Off, "drag coefficient", "cd" = cd),
    number!(Resistance, "cl_front", "c_lf", "-", NotNegative, Off, "downforce coefficient of the front axle", "cl_front" = cl_front),
    number!(Resistance, "cl_rear", "c_lr", "-", NotNegative, Off, "downforce coefficient of the rear axle", "cl_rear" = cl_rear),
    number!(Resistance, "area_m2", "A", "m^2", NotNegative, Off, "reference area of drag and downforce", "area" = area),
    number!(Resistance, "rho_kgpm3", "rho", "kg/m^3", NotNegative, Off, "density of air; 1.2 at sea level", "rho" = rho),
    number!(Resistance, "rolling", "c_r", "-", Share, Off, "rolling resistance coefficient", "rolling" = rolling),
    number!(Resistance, "linear_drag_per_s", "d", "1/s", NotNegative, Off, "deceleration per speed, for studies", "linear_drag" = linear_drag),
    number!(Drive, "drive_front", "gamma_d", "-", Share, Off, "share of driving force on the front axle", "drive_front" = drive_front),
    number!(Drive, "brake_front", "gamma_b", "-", Share, Off, "brake balance: share of braking force on the front axle", "brake_front" = brake_front),
    limit!(Drive, "power_max_w", "P_max", "W", "limit of the power at the wheels", "power_max" = power_max),
    limit!(Drive, "drive_force_max_n", "F_d,max", "N", "limit of the driving force", "drive_force_max" = drive_force_max),
    limit!(Drive, "brake_force_max_n", "F_b,max", "N", "limit of the braking force", "brake_force_max" = brake_force_max),
    limit!(Drive, "speed_max_mps", "v_max", "m/s", "top speed of gearing or governor", "speed_max" = speed_max),
    number!(Body, "length_m", "L", "m", Positive, Required, "body length", "length" = length),
    number!(Body, "width_m", "W", "m", Positive, Required, "body width", "width" = width),
    number!(Command, "a_min_mps2", "a_min", "m/s^2", Negative, Required, "strongest braking command", "a_min" = a_min),
    number!(Command, "a_max_mps2", "a_max", "m/s^2", Positive, Required, "strongest driving command", "a_max" = a_max),
    number!(Command, "delta_max_rad", "delta_max", "rad", Steering, Required, "steering stop on each side, at the wheels", "delta_max" = delta_max),
    limit!(Command, "delta_rate_max_radps", "delta'_max", "rad/s", "limit of the steering rate", "delta_rate_max" = delta_rate_max),
    limit!(Command, "a_rate_max_mps3", "a'_max", "m/s^3", "limit of the rate of the acceleration", "a_rate_max" = a_rate_max),
    number!(Actuators, "actuator_lag_s", "tau", "s", NotNegative, Off, "first-order time constant of both inputs", "actuator_lag" = actuator_lag),
    number!(Actuators, "actuator_delay_s", "T_d", "s", NotNegative, Off, "transport delay of both inputs", "actuator_delay" = actuator_delay),
    number!(Blend, "blend_speed_low_mps", "v_low", "m/s", NotNegative, Derived("0.2 sqrt(g l)"), "wheels roll at and below", "blend_speed_low" = blend_speed_low),
    number!(Blend, "blend_speed_high_mps", "v_high", "m/s", NotNegative, Derived("0.5 sqrt(g l)"), "tyres alone at and above", "blend_speed_high" = blend_speed_high),
];

const TYRES: &str = "
# Lateral force of an axle: F_y = D sin(C atan(B alpha)), D = mu F_z. In place of mu: peak_n, the peak
# force of the axle at its static load [N]. In place of b, with c = 1.3 if it is absent, either of
#   cornering_stiffness_n_per_rad     slope C_alpha of F_y at alpha = 0, both wheels of the axle at
#                                     static load F_z0 [N/rad]: B = C_alpha / (C mu F_z0)
#   cornering_stiffness_norm_per_rad  C_S = C_alpha / (mu F_z0) [1/rad]: B = C_S / C
";

impl CarParams {
    /// The text of a car file with every key, each with unit, range and meaning. Reading it gives the
    /// same numbers again.
    #[must_use]
    pub fn to_toml(&self) -> String {
        let name = self.name.replace('\\', "\\\\").replace('"', "\\\"");
        let mut out =
            "# Every key carries its unit; angles are positive to the left.\n\n".to_owned();
        let _ = writeln!(out, "name = \"{name}\"");
        for group in CarGroup::ALL {
            match group {
                CarGroup::FrontTyre => {
                    self.switches(&mut out);
                    let _ = writeln!(out, "{TYRES}[{}]", group.section());
                }
                CarGroup::RearTyre => {
                    let _ = writeln!(out, "\n[{}]", group.section());
                }
                _ => {
                    let _ = writeln!(out, "\n# {}", group.heading());
                }
            }
            for key in group.keys() {
                let CarKey { unit, meaning, range, .. } = key;
                let words = format!("{meaning} [{unit}], {}", range.interval());
                match (key.get)(self) {
                    // A float, whatever its value.
                    Some(value) => line(&mut out, &format!("{} = {value:?}", key.key), &words),
                    None => line(
                        &mut out,
                        &format!("# {} =", key.key),
                        &format!("{words}; absent: none"),
                    ),
                }
            }
        }
        out
    }

    fn switches(&self, out: &mut String) {
        *out += "\n# Equations.\n";
        let on = "the force of steered front wheels along them turns the car";
        line(out, &format!("front_force_yaw = {}", self.front_force_yaw), on);
        let on = "longitudinal force takes from the lateral one (friction ellipse)";
        line(out, &format!("combined_slip = {}", self.combined_slip), on);
    }
}

fn line(out: &mut String, assignment: &str, meaning: &str) {
    let _ = writeln!(out, "{assignment:<32} # {meaning}");
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_key_is_written_and_reads_back() {
        for name in CarParams::builtin_names() {
            let mut car = CarParams::builtin(name).unwrap();
            let text = car.to_toml();
            let read = CarParams::from_toml(&text).unwrap();
            assert_eq!(read, car, "{text}");
            assert_eq!(read.fingerprint(), car.fingerprint());
            // Every field of the struct stands in the file, one way or the other.
            car.speed_max = Some(12.5);
            car.power_max = Some(1e3);
            let read = CarParams::from_toml(&car.to_toml()).unwrap();
            assert_eq!(read, car);
        }
    }

    /// Fields of the struct by serde against the rows: neither has one that the other lacks.
    #[test]
    fn the_table_has_every_field_and_reaches_it() {
        let mut car = CarParams::builtin("barc").unwrap();
        for (i, key) in CAR_KEYS.iter().enumerate() {
            (key.set)(&mut car, Some(1000.0 + i as f64));
        }
        let fields = toml::Table::try_from(&car).unwrap();
        let mut found = 0;
        for (field, value) in &fields {
            let numbers: Vec<(String, f64)> = match value {
                toml::Value::Float(number) => vec![(field.clone(), *number)],
                toml::Value::Table(tyre) => tyre
                    .iter()
                    .map(|(part, number)| (format!("{field}.{part}"), number.as_float().unwrap()))
                    .collect(),
                toml::Value::Boolean(_) | toml::Value::String(_) => continue,
                other => unreachable!("{field} = {other}"),
            };
            for (name, number) in numbers {
                let place = CAR_KEYS.iter().position(|key| key.field == name).unwrap();
                assert_eq!(number, 1000.0 + place as f64, "{name}");
                assert_eq!((CAR_KEYS[place].get)(&car), Some(number), "{name}");
                found += 1;
            }
        }
        assert_eq!(found, CAR_KEYS.len());
    }
}
