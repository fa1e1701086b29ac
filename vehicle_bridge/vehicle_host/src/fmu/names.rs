//! What the quantities of a car are called, and what a name says beside that.

use fmu_core::VariableRow;

use super::units;

/// Names a quantity goes by, words joined; the better first.
pub(super) const NAMES: [(&str, &[&str]); 13] = [
    ("speed", &["speedoverground", "sog", "groundspeed", "speed", "velocity", "vground"]),
    ("side_slip", &["sideslip", "sideslipangle", "beta", "slipangle", "driftangle", "bodyslip"]),
    ("a", &["a", "acceleration", "accel", "acc", "ax", "acceleratordemand", "longacc"]),
    ("delta", &["delta", "steer", "steering", "steeringangle", "roadwheelangle", "wheelangle"]),
    ("v_x", &["vx", "velocityx", "longitudinalvelocity", "vlong", "speed", "velocity", "v"]),
    ("v_y", &["vy", "velocityy", "lateralvelocity", "vlat", "lateralspeed", "slipspeed"]),
    (
        "omega_z",
        &[
            "omegaz",
            "yawrate",
            "psidot",
            "yawvelocity",
            "wz",
            "omega",
            "r",
            "angularvelocityz",
            "ratesz",
            "gyroz",
        ],
    ),
    ("x", &["x", "posx", "positionx", "east", "xpos", "px"]),
    ("y", &["y", "posy", "positiony", "north", "ypos", "py"]),
    (
        "psi",
        &[
            "psi",
            "yaw",
            "heading",
            "yawangle",
            "theta",
            "anglesz",
            "eulerz",
            "attitudez",
            "orientationz",
        ],
    ),
    ("e_psi", &["epsi", "headingerror", "epsilonpsi", "relativeheading"]),
    ("s", &["s", "arclength", "station", "distance"]),
    ("e_y", &["ey", "lateralerror", "crosstrackerror", "lateraldeviation", "d"]),
];
/// Words that say no more than that it is the car's, or in which unit.
const NOISE: [&str; 16] = [
    "vehicle", "car", "ego", "chassis", "body", "cmd", "command", "demand", "request", "target",
    "actual", "measured", "out", "in", "output", "input",
];
/// Words of a quantity at the start.
const START: [&str; 5] = ["initial", "init", "start", "0", "begin"];

/// The words of a name, the unit and side in it taken out.
pub(super) struct Words {
    pub(super) joined: String,
    pub(super) unit: Option<String>,
    pub(super) start: bool,
}

pub(super) fn words(name: &str) -> Words {
    let mut split = String::new();
    let mut lower_before = false;
    for c in name.chars() {
        if c.is_uppercase() && lower_before {
            split.push(' ');
        }
        lower_before = c.is_lowercase();
        split.extend(if c.is_alphanumeric() { c.to_lowercase().next() } else { Some(' ') });
    }
    let mut all: Vec<&str> = split.split_whitespace().collect();
    let mut found = Words { joined: String::new(), unit: None, start: false };
    // `m` and `g` alone are names too.
    if all.len() > 1 {
        found.unit = all.last().filter(|w| units::unit(w).is_some()).map(|w| (*w).to_owned());
        all.truncate(all.len() - usize::from(found.unit.is_some()));
    }
    found.start = all.iter().any(|w| START.contains(w)) || name.ends_with('0');
    all.retain(|w| !START.contains(w));
    // `north` alone is a coordinate.
    if all.iter().any(|w| !super::sense::WORDS.contains(w)) {
        all.retain(|w| !super::sense::WORDS.contains(w));
    }
    if all.iter().any(|w| !NOISE.contains(w)) {
        all.retain(|w| !NOISE.contains(w));
    }
    found.joined = all.concat().trim_end_matches('0').to_owned();
    found
}

/// What a variable is called; the elements of an array of two or three are its x, y and z.
pub(super) fn called(row: &VariableRow) -> String {
    let element = row.name.rsplit_once('[').filter(|_| matches!(row.dimensions[..], [2 | 3]));
    match element {
        Some((array, index)) => {
            let axis = ["x", "y", "z"].into_iter().zip(["0]", "1]", "2]"]).find(|a| a.1 == index);
            format!("{array} {}", axis.map_or("", |a| a.0))
        }
        None => row.name.clone(),
    }
}

/// The unit in brackets at the end of a description: `speed over ground [km/h]`.
pub(super) fn bracketed(description: &str) -> Option<String> {
    let (_, unit) = description.trim().strip_suffix(']')?.rsplit_once('[')?;
    units::unit(unit).map(|_| unit.to_owned())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "code of tests")]
    use super::*;

    #[test]
    fn a_name_gives_quantity_and_unit() {
        for (name, joined, unit, start) in [
            ("Vehicle.speed_kmh", "speed", Some("kmh"), false),
            ("north_m", "north", Some("m"), false),
            ("accel_g", "accel", Some("g"), false),
            ("m", "m", None, false),
            ("acceleration_request", "acceleration", None, false),
            ("init_speed_kmh", "speed", Some("kmh"), true),
            ("steering_right_deg", "steering", Some("deg"), false),
        ] {
            let found = words(name);
            assert_eq!(
                (found.joined.as_str(), found.unit.as_deref(), found.start),
                (joined, unit, start),
                "{name}"
            );
        }
    }

    #[test]
    fn elements_of_small_arrays_are_axes() {
        let row = |name: &str, dimensions: &[usize]| VariableRow {
            name: name.to_owned(),
            dimensions: dimensions.to_vec(),
            ..VariableRow::default()
        };
        assert_eq!(words(&called(&row("velocity[1]", &[3]))).joined, "velocityy");
        assert_eq!(words(&called(&row("angular_velocity[2]", &[3]))).joined, "angularvelocityz");
        assert_eq!(called(&row("state[1]", &[6])), "state[1]");
        assert_eq!(bracketed("speed [km/h]").unwrap(), "km/h");
        assert_eq!(bracketed("both [m/s, rad]"), None);
    }
}
