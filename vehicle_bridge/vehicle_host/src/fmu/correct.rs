//! A map with what a trial found put right, line by line: comments and order stay.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use super::map::{Conversion, Entry};
use super::trial::EntryFinding;

/// The map as TOML with the findings in it, and the quantities whose lines were not found.
#[must_use]
pub fn correct(text: &str, findings: &[EntryFinding]) -> (String, Vec<&'static str>) {
    let (mut out, mut section) = (String::new(), String::new());
    let mut left: Vec<&EntryFinding> =
        findings.iter().filter(|f| f.is_change() || !f.sure).collect();
    for line in text.lines() {
        let trimmed = line.trim();
        if let Some(name) = trimmed.strip_prefix('[').and_then(|rest| rest.split(']').next()) {
            section = name.trim().to_owned();
        }
        let key = trimmed.split('=').next().unwrap_or_default().trim();
        let place = left.iter().position(|f| f.section == section && f.keys().contains(&key));
        let entry = toml::from_str::<BTreeMap<String, Entry>>(trimmed).ok();
        if let (Some(place), Some(entry)) = (place, entry.and_then(|mut e| e.remove(key))) {
            let finding = left.remove(place);
            let unsure = if finding.sure { "" } else { "unsure: " };
            let _ = writeln!(
                out,
                "{key} = {}  # tried: {unsure}{}",
                changed(entry, finding),
                finding.note
            );
        } else {
            let _ = writeln!(out, "{line}");
        }
    }
    let missing = left.into_iter().filter(|f| f.is_change()).map(|f| f.quantity).collect();
    (out, missing)
}

/// The entry with a finding's factor and offset.
fn changed(entry: Entry, finding: &EntryFinding) -> String {
    let entry = match entry {
        Entry::Name(variable) => Conversion { variable, unit: None, scale: None, offset: None },
        Entry::Full(conversion) => conversion,
    };
    let scale = finding.factor * entry.scale.unwrap_or(1.0);
    let offset = finding.factor * entry.offset.unwrap_or(0.0) + finding.offset;
    let mut text = format!("{{ variable = {:?}", entry.variable);
    if let Some(unit) = &entry.unit {
        let _ = write!(text, ", unit = {unit:?}");
    }
    if scale != 1.0 {
        let _ = write!(text, ", scale = {scale:?}");
    }
    if offset != 0.0 {
        let _ = write!(text, ", offset = {offset:?}");
    }
    text + " }"
}

impl EntryFinding {
    /// Whether the map has to change.
    #[must_use]
    pub fn is_change(&self) -> bool {
        self.factor != 1.0 || self.offset != 0.0
    }

    /// What the quantity is called in maps; speed over ground and side slip stand for velocities.
    fn keys(&self) -> &'static [&'static str] {
        match self.quantity {
            "a" => &["a"],
            "delta" => &["delta"],
            "v_x" => &["v_x", "speed"],
            "v_y" => &["v_y", "side_slip"],
            "omega_z" => &["omega_z"],
            "psi" => &["psi", "e_psi"],
            _ => &[],
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "code of tests")]
    use super::super::map::Map;
    use super::*;

    #[test]
    fn lines_change_and_all_else_stays() {
        let text = "# a comment\nframe = \"global\"\n[input]\na = \"acc\"  # theirs\n\
                    delta = { variable = \"steer\", unit = \"deg\", scale = 2.0 }\n[state]\n\
                    speed = \"v\"\nside_slip = \"beta\"\nomega_z = \"r\"\nx = \"x\"\ny = \"y\"\n\
                    psi = { variable = \"hdg\", offset = 0.5 }\n";
        let finding = |section, quantity, factor, offset, sure| EntryFinding {
            section,
            quantity,
            factor,
            offset,
            note: "found".to_owned(),
            sure,
        };
        let findings = [
            finding("input", "a", 1.0, 0.0, true),
            finding("input", "delta", -1.0, 0.0, true),
            finding("state", "v_x", 0.5, 0.0, true),
            finding("state", "v_y", 1.0, 0.0, false),
            finding("state", "psi", -1.0, 1.5, true),
            finding("state", "omega_z", -1.0, 0.0, true),
        ];
        let (out, missing) = correct(text, &findings);
        assert_eq!(missing, Vec::<&str>::new());
        assert!(out.contains("# a comment\n") && out.contains("a = \"acc\"  # theirs\n"), "{out}");
        assert!(
            out.contains("side_slip = { variable = \"beta\" }  # tried: unsure: found"),
            "{out}"
        );
        let map = Map::from_toml(&out).unwrap();
        let of = |entry: &Entry| match entry {
            Entry::Full(c) => (c.scale.unwrap_or(1.0), c.offset.unwrap_or(0.0)),
            Entry::Name(_) => (1.0, 0.0),
        };
        assert_eq!(of(&map.input["delta"]), (-2.0, 0.0));
        assert_eq!(of(&map.state["speed"]), (0.5, 0.0));
        assert_eq!(of(&map.state["psi"]), (-1.0, 1.0));
        assert_eq!(of(&map.state["omega_z"]), (-1.0, 0.0));
        let (_, missing) = correct("[input]\n", &findings);
        assert_eq!(missing, ["delta", "v_x", "psi", "omega_z"]);
    }
}
