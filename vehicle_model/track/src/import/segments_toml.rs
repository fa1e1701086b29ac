//! Our own track format: straights and arcs in TOML. All problems of a file are reported at once.

use super::{points_toml, stations_toml};
use crate::{ImportOptions, Imported, Segment, TrackError, points, segment};
use std::f64::consts::PI;
use std::iter;
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// Keys of the file.
const KEYS: [&str; 5] = ["name", "width_left_m", "width_right_m", "segment", "station"];
/// Keys of a segment.
const SEGMENT_KEYS: [&str; 7] = [
    "length_m",
    "radius_m",
    "angle_deg",
    "width_left_m",
    "width_right_m",
    "width_left_end_m",
    "width_right_end_m",
];
/// What a length or width must be.
pub(super) const POSITIVE: &str = "a number above 0, at most 1e8";
/// Whether a length or width is that.
pub(super) fn positive(value: f64) -> bool {
    value > 0.0 && value <= points::FARTHEST
}

/// The text with everything found wrong with it so far.
pub(super) struct Reader<'t> {
    text: &'t str,
    /// Byte at which each line begins.
    starts: Vec<usize>,
    problems: Vec<TrackError>,
}

/// The track, or everything wrong with the text.
pub(super) fn read(text: &str, options: &ImportOptions) -> Result<Imported, Vec<TrackError>> {
    let (file, errors) = DeTable::parse_recoverable(text);
    let starts = iter::once(0).chain(text.match_indices('\n').map(|(at, _)| at + 1)).collect();
    let mut reader = Reader { text, starts, problems: Vec::new() };
    for error in errors {
        let place = error.span().unwrap_or(0..0);
        reader.wrong(place, error.message(), "a track of segments in TOML");
    }
    if !reader.problems.is_empty() {
        return Err(reader.problems);
    }
    let table = file.get_ref();
    if table.contains_key("point") {
        return points_toml::read(reader, table, options);
    }
    reader.known_keys(table, &KEYS);
    let name = reader.name(table);
    let left = reader.number(table, "width_left_m", POSITIVE, positive);
    let right = reader.number(table, "width_right_m", POSITIVE, positive);
    for (key, found) in [("width_left_m", left), ("width_right_m", right)] {
        if found.is_none() && !table.contains_key(key) {
            reader.wrong(0..0, &format!("no {key}"), "the distance from centre line to edge [m]");
        }
    }
    let widths = (left.unwrap_or(1.0), right.unwrap_or(1.0));
    let (lines, segments): (Vec<usize>, Vec<Segment>) =
        reader.segments(table, widths).into_iter().unzip();
    let stations = stations_toml::read(&mut reader, table);
    reader.done()?;
    let item = |i: usize| match lines.get(i) {
        Some(line) => format!("line {line}: segment {}", i + 1),
        None => format!("segment {}", i + 1),
    };
    let track = segment::build(&name, &segments, widths.0, widths.1, &item)?;
    stations_toml::with(Imported::exact(track), &stations)
}

impl Reader<'_> {
    /// Everything noted, in the order of the text; nothing if all is well.
    pub(super) fn done(mut self) -> Result<(), Vec<TrackError>> {
        self.problems.sort_by_key(TrackError::line_and_column);
        if self.problems.is_empty() { Ok(()) } else { Err(self.problems) }
    }

    /// Line and column, from 1, of a byte of the text.
    pub(super) fn line_and_column(&self, byte: usize) -> (usize, usize) {
        // Not by counting from the beginning: that takes minutes for 25000 points.
        let line = self.starts.partition_point(|start| *start <= byte);
        let start = self.starts.get(line - 1).copied().unwrap_or(0);
        (line, self.text.get(start..byte).map_or(0, |before| before.chars().count()) + 1)
    }

    /// Notes a problem.
    pub(super) fn wrong(&mut self, place: Range<usize>, found: &str, expected: &str) {
        let (line, column) = self.line_and_column(place.start);
        let (found, expected) = (found.to_owned(), expected.to_owned());
        self.problems.push(TrackError::Syntax { line, column, found, expected });
    }

    /// Notes every key that is not one of these.
    pub(super) fn known_keys(&mut self, table: &DeTable<'_>, keys: &[&str]) {
        let unknown = table.keys().filter(|key| !keys.contains(&key.get_ref().as_ref()));
        for key in unknown {
            let found = format!("unknown key `{}`", key.get_ref());
            self.wrong(key.span(), &found, &format!("one of {}", keys.join(", ")));
        }
    }

    /// The track's name.
    pub(super) fn name(&mut self, table: &DeTable<'_>) -> String {
        match table.get("name") {
            Some(value) => match value.get_ref().as_str() {
                Some(name) => return name.to_owned(),
                None => {
                    let found = format!("name is of type {}", value.get_ref().type_str());
                    self.wrong(value.span(), &found, "a string");
                }
            },
            None => self.wrong(0..0, "no name", "name = \"...\""),
        }
        String::new()
    }

    /// The number at a key, if there is one as expected.
    pub(super) fn number(
        &mut self,
        table: &DeTable<'_>,
        key: &str,
        expected: &str,
        allowed: impl Fn(f64) -> bool,
    ) -> Option<f64> {
        let value = table.get(key)?;
        let number = match value.get_ref() {
            DeValue::Float(float) => float.as_str().parse::<f64>().ok(),
            DeValue::Integer(integer) if integer.radix() == 10 => integer.as_str().parse().ok(),
            other => {
                let found = format!("{key} is of type {}", other.type_str());
                self.wrong(value.span(), &found, expected);
                return None;
            }
        };
        let number = number.filter(|number| number.is_finite() && allowed(*number));
        if number.is_none() {
            let found = format!("{key} is {}", self.text.get(value.span()).unwrap_or("no number"));
            self.wrong(value.span(), &found, expected);
        }
        number
    }

    /// The segments with their lines.
    fn segments(&mut self, table: &DeTable<'_>, widths: (f64, f64)) -> Vec<(usize, Segment)> {
        let Some(value) = table.get("segment") else {
            self.wrong(0..0, "no segment", "[[segment]] for each straight and arc");
            return Vec::new();
        };
        let Some(array) = value.get_ref().as_array() else {
            let found = format!("segment is of type {}", value.get_ref().type_str());
            self.wrong(value.span(), &found, "[[segment]] for each straight and arc");
            return Vec::new();
        };
        array.iter().filter_map(|entry| self.segment(entry, widths)).collect()
    }

    /// A segment with its line; it takes the track's (left, right) widths where it has none.
    fn segment(
        &mut self,
        entry: &Spanned<DeValue<'_>>,
        (left, right): (f64, f64),
    ) -> Option<(usize, Segment)> {
        let Some(table) = entry.get_ref().as_table() else {
            let found = format!("a segment of type {}", entry.get_ref().type_str());
            self.wrong(entry.span(), &found, "a table");
            return None;
        };
        self.known_keys(table, &SEGMENT_KEYS);
        let before = self.problems.len();
        let length = self.number(table, "length_m", POSITIVE, positive);
        let turns = |v: f64| v > 0.0 && v < 360.0;
        let angle = self.number(table, "angle_deg", "a number above 0 and below 360", turns);
        let signed = "a number other than 0, positive to the left";
        let radius = self.number(table, "radius_m", signed, |v| v != 0.0);
        let mut width =
            |key: &str, other| self.number(table, key, POSITIVE, positive).unwrap_or(other);
        let start = (width("width_left_m", left), width("width_right_m", right));
        let end = (width("width_left_end_m", start.0), width("width_right_end_m", start.1));
        if self.problems.len() > before {
            return None;
        }
        let segment = match (radius, angle, length) {
            (None, None, Some(length)) => Ok(Segment::straight(length)),
            // Half and quarter turns are exact this way round.
            (Some(radius), Some(angle), None) => Ok(Segment::arc(radius, angle / 180.0 * PI)),
            (Some(radius), None, Some(length)) => {
                Ok(Segment { kappa: 1.0 / radius, ..Segment::straight(length) })
            }
            (None, None, None) => Err("a segment without a length"),
            (None, Some(_), _) => Err("angle_deg without radius_m"),
            (Some(_), Some(_), Some(_)) => Err("both angle_deg and length_m"),
            (Some(_), None, None) => Err("radius_m without angle_deg or length_m"),
        };
        match segment {
            Ok(segment) => {
                let line = self.line_and_column(entry.span().start).0;
                Some((line, segment.with_taper(start, end)))
            }
            Err(found) => {
                let expected = "length_m alone, or radius_m with one of angle_deg and length_m";
                self.wrong(entry.span(), found, expected);
                None
            }
        }
    }
}
