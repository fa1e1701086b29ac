//! Lines of GeoJSON (RFC 7946): longitude, latitude and perhaps height of each point.

use super::globe::{self, Fix};
use crate::{ImportOptions, Imported, TrackError, TrackPoint, hills, survey};
use serde_json::Value;

/// Names of the property that is the width of the track \[m\].
const WIDTHS: [&str; 2] = ["width", "width_m"];

/// A line with the properties of its feature.
struct Line<'v> {
    coordinates: Vec<&'v Value>,
    width: Option<f64>,
    name: Option<&'v str>,
}

/// What a file holds.
#[derive(Default)]
struct Content<'v> {
    lines: Vec<Line<'v>>,
    /// How many areas have a hole.
    holes: usize,
}

/// The track, or everything wrong with the text.
pub(super) fn read(
    name: &str,
    text: &str,
    options: &ImportOptions,
) -> Result<Imported, Vec<TrackError>> {
    let wrong = |line: usize, column: usize, found: String| {
        let expected = "GeoJSON with one LineString, or Polygon, as the centre line".to_owned();
        vec![TrackError::Syntax { line, column, found, expected }]
    };
    let value: Value = serde_json::from_str(text)
        .map_err(|error| wrong(error.line().max(1), error.column().max(1), error.to_string()))?;
    let mut content = Content::default();
    collect(&value, None, &mut content);
    if content.holes > 0 {
        return Err(wrong(1, 1, "a Polygon with a hole, which is no centre line".to_owned()));
    }
    let lines = joined(content.lines);
    let [line] = &lines[..] else {
        let apart = if lines.len() > 1 { " that do not begin where another ends" } else { "" };
        return Err(wrong(1, 1, format!("{} lines{apart}", lines.len())));
    };
    let (mut fixes, mut heights) = (Vec::with_capacity(line.coordinates.len()), Vec::new());
    for (i, position) in line.coordinates.iter().enumerate() {
        let number = |at: usize| position.get(at).and_then(Value::as_f64);
        let (Some(longitude), Some(latitude)) = (number(0), number(1)) else {
            return Err(wrong(1, 1, format!("point {}: {position}", i + 1)));
        };
        heights.extend(number(2));
        fixes.push(Fix { latitude, longitude, height: number(2).unwrap_or(0.0) });
    }
    let item = |i: usize| format!("point {}", i + 1);
    if fixes.is_empty() {
        return Err(wrong(1, 1, "a line without points".to_owned()));
    }
    let (places, origin) = globe::project(&fixes, &item)?;
    if let Some(found) = line.width.filter(|width| width.is_nan() || *width <= 0.0) {
        let (item, key, expected) = ("the feature".to_owned(), "width", "a width above 0 m");
        return Err(vec![TrackError::Value { item, key, found, expected }]);
    }
    let Some(half) = options.half_width.or(line.width.map(|width| 0.5 * width)) else {
        return Err(vec![TrackError::NoWidth { line: 1 }]);
    };
    let points: Vec<TrackPoint> = places
        .into_iter()
        .map(|(x, y)| TrackPoint { x, y, width_left: half, width_right: half })
        .collect();
    let imported = survey::build(line.name.unwrap_or(name), &points, options, &item)?;
    let heights = (heights.len() == points.len()).then_some(heights);
    hills::with_heights(Imported { origin: Some(origin), ..imported }, heights)
}

/// The lines, those made one that begin where another ends, as a circuit drawn in parts.
fn joined(mut lines: Vec<Line<'_>>) -> Vec<Line<'_>> {
    let mut i = 0;
    while i < lines.len() {
        let (first, last) = (lines[i].coordinates.first(), lines[i].coordinates.last());
        let next = lines.iter().enumerate().position(|(j, line)| {
            j != i && first != last && last.is_some() && line.coordinates.first() == last
        });
        let Some(j) = next else {
            i += 1;
            continue;
        };
        let part = lines.remove(j);
        i -= usize::from(j < i);
        let line = &mut lines[i];
        line.coordinates.extend(part.coordinates.into_iter().skip(1));
        line.width = line.width.or(part.width);
        line.name = line.name.or(part.name);
    }
    lines
}

/// Everything in a value, with the properties of the feature it is in.
fn collect<'v>(value: &'v Value, properties: Option<&'v Value>, content: &mut Content<'v>) {
    let list = |key: &str| value.get(key).and_then(Value::as_array).map_or(&[][..], Vec::as_slice);
    let push = |coordinates: &'v [Value], content: &mut Content<'v>| {
        let of = |key: &str| properties.and_then(|p| p.get(key));
        let metres = |v: &str| v.trim().trim_end_matches('m').trim_end().parse().ok();
        let number = |v: &Value| v.as_f64().or_else(|| metres(v.as_str()?));
        let width = WIDTHS.into_iter().find_map(of).and_then(number);
        let name = of("name").and_then(Value::as_str);
        content.lines.push(Line { coordinates: coordinates.iter().collect(), width, name });
    };
    match value.get("type").and_then(Value::as_str) {
        Some("FeatureCollection") => {
            list("features").iter().for_each(|feature| collect(feature, None, content));
        }
        Some("Feature") => {
            if let Some(geometry) = value.get("geometry") {
                collect(geometry, value.get("properties"), content);
            }
        }
        Some("GeometryCollection") => {
            list("geometries").iter().for_each(|part| collect(part, properties, content));
        }
        Some("LineString") => push(list("coordinates"), content),
        Some(kind @ ("MultiLineString" | "Polygon")) => {
            let lines = list("coordinates");
            content.holes += usize::from(kind == "Polygon" && lines.len() > 1);
            for line in lines.iter().filter_map(Value::as_array) {
                push(line, content);
            }
        }
        _ => {}
    }
}
