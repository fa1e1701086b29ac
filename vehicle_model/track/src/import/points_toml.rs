//! Our own track format with points of the centre line in place of segments.

use super::segments_toml::{POSITIVE, Reader, positive};
use super::stations_toml;
use crate::{ImportOptions, Imported, Origin, TrackError, TrackPoint, survey};
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// Keys of the file.
const KEYS: [&str; 7] = ["name", "smooth_m", "point", "station", ORIGIN[0], ORIGIN[1], ORIGIN[2]];
/// Keys of the place on the globe of x = y = 0.
const ORIGIN: [&str; 3] = ["origin_lat_deg", "origin_lon_deg", "origin_height_m"];
/// Keys of a point.
const POINT_KEYS: [&str; 4] = ["x_m", "y_m", "width_left_m", "width_right_m"];

/// The track, or everything wrong with the text.
pub(super) fn read(
    mut reader: Reader<'_>,
    table: &DeTable<'_>,
    options: &ImportOptions,
) -> Result<Imported, Vec<TrackError>> {
    reader.known_keys(table, &KEYS);
    let name = reader.name(table);
    let not_negative = |v: f64| v >= 0.0;
    let smooth = reader.number(table, "smooth_m", "a number of at least 0", not_negative);
    let [latitude, longitude, height] =
        ORIGIN.map(|key| reader.number(table, key, "a finite number", |_| true));
    let origin = latitude.zip(longitude).map(|(latitude, longitude)| Origin {
        latitude,
        longitude,
        height: height.unwrap_or(0.0),
    });
    let entries = table.get("point").and_then(|value| value.get_ref().as_array());
    if entries.is_none() {
        reader.wrong(0..0, "point is no list", "point = [ { x_m = .., y_m = .., .. }, .. ]");
    }
    let (lines, points): (Vec<usize>, Vec<TrackPoint>) = entries
        .into_iter()
        .flat_map(|entries| entries.iter())
        .filter_map(|entry| point(&mut reader, entry))
        .unzip();
    let stations = stations_toml::read(&mut reader, table);
    reader.done()?;
    let item = |i: usize| match lines.get(i) {
        Some(line) => format!("line {line}: point {}", i + 1),
        None => format!("point {}", i + 1),
    };
    let options = ImportOptions { smooth: options.smooth.or(smooth), ..*options };
    let imported = survey::build(&name, &points, &options, &item)?;
    stations_toml::with(Imported { origin, ..imported }, &stations)
}

/// A point with its line.
fn point(reader: &mut Reader<'_>, entry: &Spanned<DeValue<'_>>) -> Option<(usize, TrackPoint)> {
    let Some(table) = entry.get_ref().as_table() else {
        let found = format!("a point of type {}", entry.get_ref().type_str());
        reader.wrong(entry.span(), &found, "a table");
        return None;
    };
    reader.known_keys(table, &POINT_KEYS);
    for key in POINT_KEYS.iter().filter(|key| !table.contains_key(**key)) {
        reader.wrong(entry.span(), &format!("a point without {key}"), "a number of metres");
    }
    let any = "a finite number";
    let x = reader.number(table, "x_m", any, |_| true);
    let y = reader.number(table, "y_m", any, |_| true);
    let width_left = reader.number(table, "width_left_m", POSITIVE, positive);
    let width_right = reader.number(table, "width_right_m", POSITIVE, positive);
    let line = reader.line_and_column(entry.span().start).0;
    let (x, y, width_left, width_right) = (x?, y?, width_left?, width_right?);
    Some((line, TrackPoint { x, y, width_left, width_right }))
}
