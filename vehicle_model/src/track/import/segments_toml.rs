//! Our own track format: straights and arcs in TOML.

use crate::track::{Segment, Track, TrackError, segment};
use serde::Deserialize;
use std::f64::consts::PI;
use toml::Spanned;

/// A whole file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    name: String,
    width_left_m: f64,
    width_right_m: f64,
    segment: Vec<Spanned<Entry>>,
}

/// One `[[segment]]`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    length_m: Option<f64>,
    radius_m: Option<f64>,
    angle_deg: Option<f64>,
    width_left_m: Option<f64>,
    width_right_m: Option<f64>,
    width_left_end_m: Option<f64>,
    width_right_end_m: Option<f64>,
}

/// Line and column, from 1, of a byte of the text.
fn line_and_column(text: &str, byte: usize) -> (usize, usize) {
    let before = text.get(..byte).unwrap_or(text);
    let line = before.matches('\n').count() + 1;
    let column = before.rsplit('\n').next().unwrap_or("").chars().count() + 1;
    (line, column)
}

/// The track, or everything wrong with the text.
pub(super) fn read(text: &str) -> Result<Track, Vec<TrackError>> {
    let file: File = toml::from_str(text).map_err(|e| vec![syntax(text, &e)])?;
    let mut problems = Vec::new();
    let mut segments = Vec::new();
    let mut lines = Vec::new();
    for entry in &file.segment {
        let (line, column) = line_and_column(text, entry.span().start);
        lines.push(line);
        let widths = (file.width_left_m, file.width_right_m);
        match entry.get_ref().to_segment(widths) {
            Ok(segment) => segments.push(segment),
            Err(found) => problems.push(TrackError::Syntax {
                line,
                column,
                found: found.to_owned(),
                expected: "length_m alone, or radius_m with one of angle_deg and length_m".into(),
            }),
        }
    }
    if !problems.is_empty() {
        return Err(problems);
    }
    let item = |i: usize| match lines.get(i) {
        Some(line) => format!("line {line}: segment {}", i + 1),
        None => format!("segment {}", i + 1),
    };
    segment::build(&file.name, &segments, file.width_left_m, file.width_right_m, &item)
}

/// What the TOML reader says, with its place.
fn syntax(text: &str, error: &toml::de::Error) -> TrackError {
    let (line, column) = line_and_column(text, error.span().map_or(0, |span| span.start));
    TrackError::Syntax {
        line,
        column,
        found: error.message().to_owned(),
        expected: "a track of segments".into(),
    }
}

impl Entry {
    /// The segment, with the track's (left, right) widths where it has none of its own.
    fn to_segment(&self, (left, right): (f64, f64)) -> Result<Segment, &'static str> {
        let segment = match (self.radius_m, self.angle_deg, self.length_m) {
            (None, None, Some(length)) => Segment::straight(length),
            // Half and quarter turns are exact this way round.
            (Some(radius), Some(angle), None) => Segment::arc(radius, angle / 180.0 * PI),
            (Some(radius), None, Some(length)) => {
                Segment { kappa: 1.0 / radius, ..Segment::straight(length) }
            }
            (None, None, None) => return Err("a segment without a length"),
            (None, Some(_), _) => return Err("angle_deg without radius_m"),
            (Some(_), Some(_), Some(_)) => return Err("both angle_deg and length_m"),
            (Some(_), None, None) => return Err("radius_m without angle_deg or length_m"),
        };
        let start = (self.width_left_m.unwrap_or(left), self.width_right_m.unwrap_or(right));
        let end =
            (self.width_left_end_m.unwrap_or(start.0), self.width_right_end_m.unwrap_or(start.1));
        Ok(segment.with_taper(start, end))
    }
}
