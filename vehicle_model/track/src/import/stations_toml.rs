//! What our own track format has along s: `[[station]]`.

use super::segments_toml::Reader;
use crate::along::{MOST_FRICTION, STEEPEST};
use crate::{Imported, Station, TrackError};
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// Keys of a station.
const KEYS: [&str; 5] = ["s_m", "bank_deg", "slope_deg", "friction", "speed_limit_mps"];

/// A station with its line.
pub(super) type Line = (usize, Station);

/// The stations of a file.
pub(super) fn read(reader: &mut Reader<'_>, table: &DeTable<'_>) -> Vec<Line> {
    let Some(value) = table.get("station") else { return Vec::new() };
    let Some(entries) = value.get_ref().as_array() else {
        reader.wrong(value.span(), "station is no list", "[[station]] for each place");
        return Vec::new();
    };
    entries.iter().filter_map(|entry| station(reader, entry)).collect()
}

fn station(reader: &mut Reader<'_>, entry: &Spanned<DeValue<'_>>) -> Option<Line> {
    let Some(table) = entry.get_ref().as_table() else {
        reader.wrong(entry.span(), "a station that is no table", "a table");
        return None;
    };
    reader.known_keys(table, &KEYS);
    if !table.contains_key("s_m") {
        reader.wrong(entry.span(), "a station without s_m", "its place along the centre line [m]");
    }
    let s = reader.number(table, "s_m", "a number of at least 0", |v| v >= 0.0);
    let angle = |v: f64| v.to_radians().abs() <= STEEPEST;
    let expected = "an angle between -60 and 60";
    let bank = reader.number(table, "bank_deg", expected, angle).map(f64::to_radians);
    let slope = reader.number(table, "slope_deg", expected, angle).map(f64::to_radians);
    let factor = |v: f64| v > 0.0 && v <= MOST_FRICTION;
    let friction = reader.number(table, "friction", "a factor above 0, at most 3", factor);
    let key = "speed_limit_mps";
    let none = table.get(key).and_then(|v| v.get_ref().as_str()) == Some("none");
    let speed_limit = match none {
        true => Some(f64::INFINITY),
        false => reader.number(table, key, "a speed above 0, or \"none\"", |v| v > 0.0),
    };
    let line = reader.line_and_column(entry.span().start).0;
    Some((line, Station { s: s?, bank, slope, friction, speed_limit }))
}

/// The imported track with the stations of its file.
pub(super) fn with(imported: Imported, lines: &[Line]) -> Result<Imported, Vec<TrackError>> {
    let length = imported.track.length();
    let problems: Vec<TrackError> = lines
        .iter()
        .enumerate()
        .filter_map(|(i, (line, station))| {
            let (key, found, expected) = station.wrong(length)?;
            let item = format!("line {line}: station {}", i + 1);
            Some(TrackError::Value { item, key, found, expected })
        })
        .collect();
    if !problems.is_empty() {
        return Err(problems);
    }
    let stations: Vec<Station> = lines.iter().map(|(_, station)| *station).collect();
    match imported.track.clone().with_stations(&stations) {
        Ok(track) => Ok(Imported { track, ..imported }),
        Err(problem) => Err(vec![problem]),
    }
}
