//! A first map for an FMU, from names, units and causalities of its variables.

use std::fmt::Write as _;

use fmu_core::{Inspection, VariableRow};

use super::element::{expanded, find};
use super::map::{Frame, Map, input_quantities, state_quantities};
use super::names::{NAMES, bracketed, called, words};
use super::sense::{Sense, sense};
use super::slave::attribute;
use super::units::{self, Dimension};

/// Model name of our own vehicle FMU.
const OUR_NAME: &str = "LMPC vehicle";

const OURS: &str = r#"
frame = "track"
[input]
a = "cmd.a"
delta = "cmd.delta"
[state]
v_x = "vehicle.v_x"
v_y = "vehicle.v_y"
omega_z = "vehicle.omega_z"
e_psi = "vehicle.e_psi"
s = "vehicle.s"
e_y = "vehicle.e_y"
[truth]
v_x = "truth.v_x"
v_y = "truth.v_y"
omega_z = "truth.omega_z"
e_psi = "truth.e_psi"
s = "truth.s"
e_y = "truth.e_y"
[applied]
a = "applied.a"
delta = "applied.delta"
[initial]
v_x = "initial.v_x"
v_y = "initial.v_y"
omega_z = "initial.omega_z"
e_psi = "initial.e_psi"
s = "initial.s"
e_y = "initial.e_y"
[parameters]
"param.track" = "{track}"
"param.car" = "{car}"
"param.seed" = "{seed}"
"#;

/// Whether the FMU is our vehicle.
#[must_use]
pub fn is_ours(inspection: &Inspection) -> bool {
    attribute(inspection, "modelName") == OUR_NAME && find(inspection, "cmd.delta").is_ok()
}

/// The map of our own vehicle FMU, if this is it.
#[must_use]
pub fn map_of_ours(inspection: &Inspection) -> Option<Map> {
    is_ours(inspection).then(|| Map::from_toml(OURS).ok()).flatten()
}

/// One guess.
struct Guess<'a> {
    row: &'a VariableRow,
    unit: Option<String>,
    sense: Sense,
    doubts: Vec<String>,
}

fn guess<'a>(
    rows: &'a [VariableRow],
    wanted: (&str, Dimension),
    fits: impl Fn(&VariableRow) -> bool,
    at_start: bool,
) -> Option<Guess<'a>> {
    let names = NAMES.iter().find(|(name, _)| *name == wanted.0)?.1;
    let mut best: Option<(usize, Guess<'a>)> = None;
    for row in rows.iter().filter(|row| fits(row)) {
        let read = words(&called(row));
        if at_start && !read.start {
            continue;
        }
        let exact = names.iter().position(|name| *name == read.joined);
        let partial = names.iter().filter(|n| n.len() > 2).any(|n| read.joined.contains(n));
        let Some(mut cost) = exact.or(partial.then_some(20)) else { continue };
        let mut doubts = Vec::new();
        if !row.dimensions.is_empty() {
            doubts.push("elements taken for x, y, z".to_owned());
        }
        if exact.is_none() {
            doubts.push(format!("the name only resembles `{}`", wanted.0));
        }
        let mut unit = None;
        match units::unit(&row.unit) {
            Some((dimension, _)) if dimension == wanted.1 => {}
            Some(_) => continue,
            None => match read.unit.or_else(|| bracketed(&row.description)) {
                Some(named) if units::unit(&named).is_some_and(|(d, _)| d == wanted.1) => {
                    unit = Some(named);
                }
                Some(_) => continue,
                None => {
                    cost += 5;
                    doubts.push(if row.unit.is_empty() {
                        "no unit: taken for SI".to_owned()
                    } else {
                        format!("unit `{}` is not known: taken for SI", row.unit)
                    });
                }
            },
        }
        let sense = sense(wanted.0, &row.name, &row.description);
        doubts.extend(sense.doubt.clone());
        if best.as_ref().is_none_or(|(least, _)| cost < *least) {
            best = Some((cost, Guess { row, unit, sense, doubts }));
        }
    }
    best.map(|(_, guess)| guess)
}

/// A map as TOML; uncertain entries are commented.
#[must_use]
pub fn propose(inspection: &Inspection, file: &str) -> String {
    if is_ours(inspection) {
        return format!(
            "# Our own vehicle FMU: this is its map without a file, too.\nfmu = {file:?}\n{}",
            OURS.trim_start()
        );
    }
    let rows = &expanded(&inspection.variables);
    let output = |row: &VariableRow| row.causality == "output" || row.causality == "local";
    let count = |frame| {
        let all = state_quantities(frame);
        all.into_iter().filter(|w| guess(rows, *w, output, false).is_some()).count()
    };
    let frame =
        if count(Frame::Track) > count(Frame::Global) { Frame::Track } else { Frame::Global };
    let name = attribute(inspection, "modelName");
    let mut text = format!(
        "# Proposed for {name}: check every line, above all the signs (ours: x forward, y left,\n\
         # steering, yaw and yaw rate positive to the left); `lmpc vehicle try` measures them.\n\
         # ours = scale * unit * theirs + offset\nfmu = {file:?}\nframe = \"{}\"\n\
         # step_s = 0.01  # longest communication step; the control period if absent\n",
        if frame == Frame::Track { "track" } else { "global" }
    );
    let mut state = state_quantities(frame);
    let state_is = |name: &str, dimension| guess(rows, (name, dimension), output, false);
    // Speed and side slip stand in for a lateral velocity where the FMU gives none.
    let slip = state_is("side_slip", Dimension::Angle)
        .filter(|_| state_is("v_y", Dimension::Speed).is_none());
    if slip.is_some() && state_is("speed", Dimension::Speed).is_some() {
        (state[0], state[1]) = (("speed", Dimension::Speed), ("side_slip", Dimension::Angle));
    }
    let input = |row: &VariableRow| row.causality == "input";
    section(&mut text, "input", &input_quantities(), |w| guess(rows, w, input, false), true);
    section(&mut text, "state", &state, |w| guess(rows, w, output, false), true);
    let parameter = |row: &VariableRow| row.causality == "parameter";
    section(&mut text, "initial", &state, |w| guess(rows, w, parameter, true), false);
    text.push_str("\n[parameters]\n");
    for row in rows.iter().filter(|row| parameter(row) && !words(&row.name).start) {
        let unit = if row.unit.is_empty() { String::new() } else { format!(" [{}]", row.unit) };
        let start =
            if row.kind == "String" { format!("{:?}", row.start) } else { row.start.clone() };
        let _ = writeln!(text, "# {:?} = {start}  # {}{unit}", row.name, row.description);
    }
    text
}

fn section<'a>(
    text: &mut String,
    name: &str,
    quantities: &[(&'static str, Dimension)],
    find: impl Fn((&'static str, Dimension)) -> Option<Guess<'a>>,
    all: bool,
) {
    let _ = write!(text, "\n[{name}]\n");
    for (quantity, dimension) in quantities {
        let Some(found) = find((quantity, *dimension)) else {
            if all {
                let _ = writeln!(text, "# {quantity} = ?  # unsure: no variable matches");
            }
            continue;
        };
        let Guess { row, unit, sense, doubts } = found;
        let mut entry = format!("{{ variable = {:?}", row.name);
        if let Some(unit) = unit {
            let _ = write!(entry, ", unit = {unit:?}");
        }
        if sense.reversed {
            entry.push_str(", scale = -1.0");
        }
        if sense.offset != 0.0 {
            let _ = write!(entry, ", offset = {}", sense.offset);
        }
        entry.push_str(" }");
        let doubts = if doubts.is_empty() {
            String::new()
        } else {
            format!("  # unsure: {}", doubts.join("; "))
        };
        let _ = writeln!(text, "{quantity} = {entry}{doubts}");
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn variable(name: &str, causality: &str, unit: &str) -> VariableRow {
        VariableRow {
            name: name.to_owned(),
            causality: causality.to_owned(),
            unit: unit.to_owned(),
            kind: "Real".to_owned(),
            ..VariableRow::default()
        }
    }

    fn foreign() -> Inspection {
        Inspection {
            attributes: vec![("modelName".to_owned(), "theirs".to_owned())],
            files: Vec::new(),
            model_description: String::new(),
            variables: vec![
                variable("accel_cmd", "input", "m/s2"),
                variable("steering_right_deg", "input", ""),
                variable("Vehicle.speed_kmh", "output", ""),
                variable("lateral_velocity", "output", "m/s"),
                variable("yawRate", "output", "deg/s"),
                variable("pos_x", "output", "m"),
                variable("pos_y", "output", "m"),
                variable("heading", "output", "deg"),
                variable("wheel_speed", "output", "rad/s"),
                variable("init_speed_kmh", "parameter", ""),
            ],
        }
    }

    #[test]
    fn a_car_with_other_names_units_and_signs_is_understood() {
        let text = propose(&foreign(), "theirs.fmu");
        let map = Map::from_toml(&text).unwrap();
        let factor = |table: &std::collections::BTreeMap<_, super::super::map::Entry>,
                      key: &str,
                      own: &str,
                      dimension| table[key].factor(own, dimension).unwrap().0;
        assert_eq!(map.frame, Frame::Global);
        assert!((factor(&map.input, "delta", "", Dimension::Angle) + 0.017_453_292_5).abs() < 1e-9);
        assert!((factor(&map.state, "v_x", "", Dimension::Speed) * 3.6 - 1.0).abs() < 1e-12);
        assert_eq!(map.state["omega_z"].variable(), "yawRate");
        assert_eq!(map.initial["v_x"].variable(), "init_speed_kmh");
    }

    #[test]
    fn speed_and_side_slip_are_taken_where_there_is_no_lateral_velocity() {
        let mut theirs = foreign();
        theirs.variables.retain(|row| row.name != "lateral_velocity");
        theirs.variables.push(variable("side_slip_angle", "output", "rad"));
        let map = Map::from_toml(&propose(&theirs, "theirs.fmu")).unwrap();
        assert_eq!(map.state["speed"].variable(), "Vehicle.speed_kmh");
        assert_eq!(map.state["side_slip"].variable(), "side_slip_angle");
        assert!(!map.state.contains_key("v_x"));
    }

    #[test]
    fn senses_come_from_words_and_what_says_nothing_is_unsure() {
        let mut theirs = foreign();
        for row in &mut theirs.variables {
            row.description = match row.name.as_str() {
                "heading" => "compass heading, clockwise from north".to_owned(),
                "yawRate" => "positive counter-clockwise".to_owned(),
                _ => String::new(),
            };
        }
        let text = propose(&theirs, "theirs.fmu");
        let line = |start: &str| text.lines().find(|line| line.starts_with(start)).unwrap();
        let psi = line("psi = ");
        assert!(
            psi.contains("scale = -1.0, offset = 1.570796") && !psi.contains("unsure"),
            "{psi}"
        );
        assert!(!line("omega_z = ").contains("unsure"), "{text}");
        assert!(line("v_y = ").contains("unsure: its sense is not stated"), "{text}");
        let delta = line("delta = ");
        assert!(delta.contains("scale = -1.0") && !delta.contains("sense"), "{delta}");
    }

    #[test]
    fn what_is_not_found_is_said_and_refused() {
        let mut theirs = foreign();
        theirs.variables.retain(|row| row.name != "heading");
        let text = propose(&theirs, "theirs.fmu");
        assert!(text.contains("# psi = ?"), "{text}");
        assert!(Map::from_toml(&text).unwrap_err().to_string().contains("`psi` is missing"));
    }
}
