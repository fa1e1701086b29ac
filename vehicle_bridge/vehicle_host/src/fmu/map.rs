//! The table that tells which variable of an FMU is which of our quantities.

use std::collections::BTreeMap;

use serde::Deserialize;

use super::error::FmuError;
use super::units::{self, Dimension};

/// Frame in which an FMU tells where the car is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Frame {
    /// Along our track: e_psi, s, e_y.
    Track,
    /// In the world: x, y, psi.
    Global,
}

/// A map file.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Map {
    /// The FMU it is for, relative to the map; used by `lmpc check`.
    pub fmu: Option<String>,
    /// Frame of the pose.
    pub frame: Frame,
    /// Longest communication step; the control period if absent \[s\].
    pub step_s: Option<f64>,
    /// Our commands a and delta.
    pub input: BTreeMap<String, Entry>,
    /// What the sensors measure: v_x and v_y, or speed (over ground) and side_slip (positive to the
    /// left), omega_z and the pose.
    pub state: BTreeMap<String, Entry>,
    /// The true state, if the FMU tells it; else what is measured.
    #[serde(default)]
    pub truth: BTreeMap<String, Entry>,
    /// The a and delta that really act, if the FMU tells them; else what is commanded.
    #[serde(default)]
    pub applied: BTreeMap<String, Entry>,
    /// Parameters that take our initial state.
    #[serde(default)]
    pub initial: BTreeMap<String, Entry>,
    /// Values of other variables, by their own names and in their own units. `{track}`, `{car}`
    /// and `{seed}` stand for what the command line says.
    #[serde(default)]
    pub parameters: BTreeMap<String, toml::Value>,
}

/// One variable: ours = scale * unit * theirs + offset.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(untagged)]
pub enum Entry {
    /// A name alone: the FMU's own unit, or SI.
    Name(String),
    /// With its conversion.
    Full(Conversion),
}

/// A variable and how its value becomes ours.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Conversion {
    /// Name in the FMU.
    pub variable: String,
    /// Its unit, if the FMU does not say it or says it wrong.
    pub unit: Option<String>,
    /// Factor after the unit; -1 for a quantity positive to the right.
    pub scale: Option<f64>,
    /// Added last, in our unit.
    pub offset: Option<f64>,
}

/// Names and dimensions of what may be mapped.
const INPUT: [(&str, Dimension); 2] = [("a", Dimension::Acceleration), ("delta", Dimension::Angle)];
const VELOCITIES: [(&str, Dimension); 3] =
    [("v_x", Dimension::Speed), ("v_y", Dimension::Speed), ("omega_z", Dimension::AngularSpeed)];
const TRACK_POSE: [(&str, Dimension); 3] =
    [("e_psi", Dimension::Angle), ("s", Dimension::Length), ("e_y", Dimension::Length)];
const GLOBAL_POSE: [(&str, Dimension); 3] =
    [("x", Dimension::Length), ("y", Dimension::Length), ("psi", Dimension::Angle)];

/// In place of v_x and v_y: speed over ground and side slip, beta = atan2(v_y, v_x).
const POLAR: [(&str, Dimension); 2] =
    [("speed", Dimension::Speed), ("side_slip", Dimension::Angle)];

/// The six quantities of a table of states, in our order, and whether the first two are speed over
/// ground and side slip.
#[must_use]
pub fn quantities_of(
    frame: Frame,
    table: &BTreeMap<String, Entry>,
) -> ([(&'static str, Dimension); 6], bool) {
    let mut all = state_quantities(frame);
    let polar = POLAR.iter().any(|(name, _)| table.contains_key(*name));
    if polar {
        all[..2].copy_from_slice(&POLAR);
    }
    (all, polar)
}

/// The six quantities of a state in this frame, in our order.
#[must_use]
pub fn state_quantities(frame: Frame) -> [(&'static str, Dimension); 6] {
    let [a, b, c] = VELOCITIES;
    let [d, e, f] = match frame {
        Frame::Track => TRACK_POSE,
        Frame::Global => GLOBAL_POSE,
    };
    [a, b, c, d, e, f]
}

/// The two inputs, in our order.
#[must_use]
pub fn input_quantities() -> [(&'static str, Dimension); 2] {
    INPUT
}

impl Entry {
    /// Name in the FMU.
    #[must_use]
    pub fn variable(&self) -> &str {
        match self {
            Self::Name(name) => name,
            Self::Full(conversion) => &conversion.variable,
        }
    }

    /// Factor and offset from the FMU's value to ours; `own` is the unit the FMU gives itself.
    ///
    /// # Errors
    /// In words, if the unit is unknown or measures something else, or a number is useless.
    pub fn factor(&self, own: &str, wanted: Dimension) -> Result<(f64, f64), String> {
        let full = match self {
            Self::Name(_) => None,
            Self::Full(conversion) => Some(conversion),
        };
        let named = full.and_then(|c| c.unit.as_deref());
        let spelled = named.unwrap_or(own);
        let size = match units::unit(spelled) {
            Some((dimension, size)) if dimension == wanted => size,
            Some((dimension, _)) => {
                return Err(format!(
                    "unit `{spelled}` measures {dimension:?}, expected {wanted:?}"
                ));
            }
            // What the FMU says of itself and nobody knows counts as SI, as does nothing.
            None if named.is_none() => 1.0,
            None => {
                return Err(format!(
                    "found unit `{spelled}`, expected one of {}",
                    units::spellings()
                ));
            }
        };
        let scale = full.and_then(|c| c.scale).unwrap_or(1.0);
        let offset = full.and_then(|c| c.offset).unwrap_or(0.0);
        if !(scale.is_finite() && scale != 0.0 && offset.is_finite()) {
            return Err(format!("scale {scale}, offset {offset}: expected numbers, scale not 0"));
        }
        Ok((scale * size, offset))
    }
}

impl Map {
    /// Reads a map.
    ///
    /// # Errors
    /// [`FmuError::Map`] with every problem that needs no FMU to be seen.
    pub fn from_toml(text: &str) -> Result<Self, FmuError> {
        let map: Self = toml::from_str(text).map_err(|e| FmuError::Map(e.to_string()))?;
        let problems = map.problems();
        if problems.is_empty() {
            return Ok(map);
        }
        Err(FmuError::Map(
            problems
                .into_iter()
                .map(|(key, what)| format!("{key}: {what}"))
                .collect::<Vec<_>>()
                .join("; "),
        ))
    }

    /// Every problem that needs no FMU to be seen, each with its key.
    #[must_use]
    pub fn problems(&self) -> Vec<(String, String)> {
        let mut found = Vec::new();
        let [state, truth, initial] = [&self.state, &self.truth, &self.initial]
            .map(|table| quantities_of(self.frame, table).0);
        for (section, table, known, whole) in [
            ("input", &self.input, &INPUT[..], true),
            ("state", &self.state, &state[..], true),
            ("truth", &self.truth, &truth[..], !self.truth.is_empty()),
            ("applied", &self.applied, &INPUT[..], !self.applied.is_empty()),
            ("initial", &self.initial, &initial[..], false),
        ] {
            let names = known.iter().map(|(name, _)| *name).collect::<Vec<_>>().join(", ");
            for (key, entry) in table {
                let at = format!("{section}.{key}");
                match known.iter().find(|(name, _)| name == key) {
                    None => found.push((at, format!("found `{key}`, expected one of {names}"))),
                    Some((_, dimension)) => {
                        // Its own unit is only known with the FMU.
                        if let Err(what) = entry.factor("", *dimension) {
                            found.push((at, what));
                        }
                    }
                }
            }
            for (name, _) in known.iter().filter(|(name, _)| whole && !table.contains_key(*name)) {
                found.push((section.to_owned(), format!("`{name}` is missing")));
            }
        }
        if self.step_s.is_some_and(|step| !(step.is_finite() && step > 0.0)) {
            found.push(("step_s".to_owned(), "expected a number above 0".to_owned()));
        }
        found
    }

    /// Every named variable with its key and what it must measure; parameters measure nothing.
    pub fn entries(&self) -> impl Iterator<Item = (String, &Entry, Dimension)> {
        let known = |section: &str, key: &str| {
            let all = INPUT.into_iter().chain(POLAR).chain(state_quantities(self.frame));
            let found = all.into_iter().find(|(name, _)| *name == key)?;
            Some((format!("{section}.{key}"), found.1))
        };
        [
            ("input", &self.input),
            ("state", &self.state),
            ("truth", &self.truth),
            ("applied", &self.applied),
            ("initial", &self.initial),
        ]
        .into_iter()
        .flat_map(|(section, table)| table.iter().map(move |(key, entry)| (section, key, entry)))
        .filter_map(move |(section, key, entry)| {
            known(section, key).map(|(at, dimension)| (at, entry, dimension))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GOOD: &str = r#"
frame = "global"
[input]
a = "acc"
delta = { variable = "steering_right", unit = "deg", scale = -1.0 }
[state]
v_x = { variable = "speed", unit = "km/h" }
v_y = "vy"
omega_z = "r"
x = "x"
y = "y"
psi = { variable = "heading", unit = "deg", offset = 0.5 }
"#;

    #[test]
    fn conversions_have_the_sign_and_size_of_the_words() {
        let map = Map::from_toml(GOOD).unwrap();
        let (factor, offset) = map.input["delta"].factor("", Dimension::Angle).unwrap();
        assert!((factor * 90.0 + offset + std::f64::consts::FRAC_PI_2).abs() < 1e-12);
        let (factor, _) = map.state["v_x"].factor("m/s", Dimension::Speed).unwrap();
        assert!((factor * 36.0 - 10.0).abs() < 1e-12, "the map's unit wins");
        let (factor, _) = map.state["v_y"].factor("km/h", Dimension::Speed).unwrap();
        assert!((factor * 36.0 - 10.0).abs() < 1e-12, "the FMU's own unit else");
        assert_eq!(map.entries().count(), 8);
    }

    #[test]
    fn speed_over_ground_and_side_slip_stand_in_for_two_velocities() {
        let polar =
            GOOD.replace("v_x = ", "speed = ").replace("v_y = \"vy\"", "side_slip = \"beta\"");
        let map = Map::from_toml(&polar).unwrap();
        let (names, is_polar) = quantities_of(map.frame, &map.state);
        assert!(is_polar && map.entries().count() == 8);
        assert_eq!([names[0].0, names[1].0, names[2].0], ["speed", "side_slip", "omega_z"]);
        let half = GOOD.replace("v_x = ", "speed = ");
        let text = Map::from_toml(&half).unwrap_err().to_string();
        assert!(text.contains("`side_slip` is missing") && text.contains("found `v_y`"), "{text}");
    }

    #[test]
    fn every_mistake_is_told_with_its_key() {
        for (from, to, told) in [
            ("v_y = \"vy\"", "", "state: `v_y` is missing"),
            ("\"km/h\"", "\"parsec\"", "state.v_x: found unit `parsec`"),
            ("\"km/h\"", "\"deg\"", "measures Angle"),
            ("scale = -1.0", "scale = 0.0", "scale not 0"),
            ("x = \"x\"", "s = \"x\"", "found `s`"),
            ("unit = \"km/h\"", "units = \"km/h\"", "did not match"),
            ("frame = \"global\"", "frame = \"global\"\nstep_s = -1.0", "step_s"),
        ] {
            let text = Map::from_toml(&GOOD.replacen(from, to, 1)).unwrap_err().to_string();
            assert!(text.contains(told), "{to}: {text}");
        }
    }
}
