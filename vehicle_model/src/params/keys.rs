//! The keys of a car file with unit and meaning, and cars written with all of them.

use std::fmt::Write as _;

use super::CarParams;

/// Value of a key of a car: none where an effect is switched off by the key's absence.
type Value = fn(&CarParams) -> Option<f64>;

/// A group of keys under a heading.
struct Group {
    heading: &'static str,
    keys: &'static [(&'static str, Value, &'static str)],
}

const GROUPS: &[Group] = &[
    Group {
        heading: "Body.",
        keys: &[
            ("mass_kg", |c| Some(c.mass), "mass with driver and fuel [kg], (0, inf)"),
            ("inertia_z_kgm2", |c| Some(c.inertia_z), "yaw inertia [kg m^2], (0, inf)"),
            ("l_f_m", |c| Some(c.l_f), "centre of gravity to front axle [m], (0, inf)"),
            ("l_r_m", |c| Some(c.l_r), "centre of gravity to rear axle [m], (0, inf)"),
            (
                "h_cg_m",
                |c| Some(c.h_cg),
                "height of the centre of gravity [m]; 0: no load transfer",
            ),
            ("length_m", |c| Some(c.length), "body length [m], (0, inf)"),
            ("width_m", |c| Some(c.width), "body width [m], (0, inf)"),
        ],
    },
    Group {
        heading: "What resists and what presses down; 0 switches each off.",
        keys: &[
            ("cd", |c| Some(c.cd), "drag coefficient [-]"),
            ("cl_front", |c| Some(c.cl_front), "downforce coefficient of the front axle [-]"),
            ("cl_rear", |c| Some(c.cl_rear), "downforce coefficient of the rear axle [-]"),
            ("area_m2", |c| Some(c.area), "reference area of cd and cl [m^2]"),
            ("rho_kgpm3", |c| Some(c.rho), "density of air [kg/m^3]; 1.2 at sea level"),
            ("rolling", |c| Some(c.rolling), "rolling resistance coefficient [-], [0, 1]"),
            ("linear_drag_per_s", |c| Some(c.linear_drag), "deceleration per speed [1/s]"),
        ],
    },
    Group {
        heading: "What the controller may ask of the car.",
        keys: &[
            ("a_min_mps2", |c| Some(c.a_min), "strongest braking command [m/s^2], (-inf, 0)"),
            ("a_max_mps2", |c| Some(c.a_max), "strongest driving command [m/s^2], (0, inf)"),
            (
                "delta_max_rad",
                |c| Some(c.delta_max),
                "steering stop on each side, at the wheels [rad]",
            ),
            (
                "delta_rate_max_radps",
                |c| c.delta_rate_max,
                "steering rate limit [rad/s]; absent: none",
            ),
            ("a_rate_max_mps3", |c| c.a_rate_max, "limit of the rate of a [m/s^3]; absent: none"),
        ],
    },
    Group {
        heading: "Engine and brakes.",
        keys: &[
            ("power_max_w", |c| c.power_max, "power at the wheels [W]; absent: no limit"),
            ("drive_force_max_n", |c| c.drive_force_max, "driving force [N]; absent: no limit"),
            ("brake_force_max_n", |c| c.brake_force_max, "braking force [N]; absent: no limit"),
            (
                "speed_max_mps",
                |c| c.speed_max,
                "top speed of gearing or governor [m/s]; absent: none",
            ),
            (
                "drive_front",
                |c| Some(c.drive_front),
                "share of driving force on the front axle, [0, 1]",
            ),
            (
                "brake_front",
                |c| Some(c.brake_front),
                "brake balance: share of braking force on the front axle, [0, 1]",
            ),
        ],
    },
    Group {
        heading: "Actuators; 0 switches each off.",
        keys: &[
            (
                "actuator_lag_s",
                |c| Some(c.actuator_lag),
                "first-order time constant of both inputs [s]",
            ),
            ("actuator_delay_s", |c| Some(c.actuator_delay), "transport delay of both inputs [s]"),
        ],
    },
    Group {
        heading: "Between these speeds rolling wheels give way to the tyre model; both 0: never, absent:\n\
                  # 0.2 and 0.5 times sqrt(g wheelbase).",
        keys: &[
            ("blend_speed_low_mps", |c| Some(c.blend_speed_low), "wheels roll at and below [m/s]"),
            (
                "blend_speed_high_mps",
                |c| Some(c.blend_speed_high),
                "tyres alone at and above [m/s]",
            ),
        ],
    },
];

const TYRES: &str = "
# Lateral force of an axle: F_y = D sin(C atan(B alpha)), D = mu F_z. In place of mu: peak_n, the peak
# force of the axle at its static load [N]. In place of b, with c = 1.3 if it is absent, either of
#   cornering_stiffness_n_per_rad     slope C_alpha of F_y at alpha = 0, both wheels of the axle at
#                                     static load F_z0 [N/rad]: B = C_alpha / (C mu F_z0)
#   cornering_stiffness_norm_per_rad  C_S = C_alpha / (mu F_z0) [1/rad]: B = C_S / C
";

/// A number as TOML has it: a float, whatever its value.
fn number(value: f64) -> String {
    format!("{value:?}")
}

impl CarParams {
    /// The text of a car file with every key, each with unit and meaning. Reading it gives the same
    /// numbers again.
    #[must_use]
    pub fn to_toml(&self) -> String {
        let name = self.name.replace('\\', "\\\\").replace('"', "\\\"");
        let mut out =
            "# Every key carries its unit; angles are positive to the left.\n\n".to_owned();
        let _ = writeln!(out, "name = \"{name}\"");
        for group in GROUPS {
            let _ = writeln!(out, "\n# {}", group.heading);
            for (key, value, meaning) in group.keys {
                match value(self) {
                    Some(value) => line(&mut out, &format!("{key} = {}", number(value)), meaning),
                    None => line(&mut out, &format!("# {key} ="), meaning),
                }
            }
        }
        out += "\n# Equations.\n";
        let on = "the force of steered front wheels along them turns the car";
        line(&mut out, &format!("front_force_yaw = {}", self.front_force_yaw), on);
        let on = "longitudinal force takes from the lateral one (friction ellipse)";
        line(&mut out, &format!("combined_slip = {}", self.combined_slip), on);
        out += TYRES;
        for (section, tyre) in [("tyre_front", self.tyre_front), ("tyre_rear", self.tyre_rear)] {
            let _ = writeln!(out, "[{section}]");
            line(&mut out, &format!("b = {}", number(tyre.b)), "stiffness factor B [-], (0, inf)");
            line(&mut out, &format!("c = {}", number(tyre.c)), "shape factor C [-], (0, inf)");
            line(&mut out, &format!("mu = {}", number(tyre.mu)), "peak friction [-], (0, inf)");
            if section == "tyre_front" {
                out.push('\n');
            }
        }
        out
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
}
