//! Lines of GeoJSON (RFC 7946): longitude, latitude and perhaps height of each point.

use super::globe::{self, Fix};
use crate::{ImportOptions, Imported, TrackError, TrackPoint, hills, survey};
use serde_json::Value;

/// A line with the properties of its feature.
struct Line<'v> {
    coordinates: &'v [Value],
    width: Option<f64>,
    name: Option<&'v str>,
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
    let mut lines = Vec::new();
    collect(&value, None, &mut lines);
    let [line] = &lines[..] else {
        return Err(wrong(1, 1, format!("{} lines", lines.len())));
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

/// Every line in a value, with the properties of the feature it is in.
fn collect<'v>(value: &'v Value, properties: Option<&'v Value>, lines: &mut Vec<Line<'v>>) {
    let list = |key: &str| value.get(key).and_then(Value::as_array).map_or(&[][..], Vec::as_slice);
    let mut push = |coordinates: &'v [Value]| {
        let width = properties.and_then(|p| p.get("width"));
        let number = |v: &Value| v.as_f64().or_else(|| v.as_str()?.trim().parse().ok());
        let name = properties.and_then(|p| p.get("name")).and_then(Value::as_str);
        lines.push(Line { coordinates, width: width.and_then(number), name });
    };
    match value.get("type").and_then(Value::as_str) {
        Some("FeatureCollection") => {
            list("features").iter().for_each(|feature| collect(feature, None, lines));
        }
        Some("Feature") => {
            if let Some(geometry) = value.get("geometry") {
                collect(geometry, value.get("properties"), lines);
            }
        }
        Some("GeometryCollection") => {
            list("geometries").iter().for_each(|part| collect(part, properties, lines));
        }
        Some("LineString") => push(list("coordinates")),
        Some("MultiLineString" | "Polygon") => {
            for line in list("coordinates").iter().filter_map(Value::as_array) {
                push(line);
            }
        }
        _ => {}
    }
}
