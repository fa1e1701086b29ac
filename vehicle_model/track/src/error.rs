//! Everything that can be wrong with a track, each with the place a user has to look at.

use std::fmt;

/// A place on a track's centre line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Place {
    /// Distance along the centre line \[m\].
    pub s: f64,
    /// Position \[m\].
    pub x: f64,
    /// Position \[m\].
    pub y: f64,
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "s = {:.3} m (x = {:.3}, y = {:.3})", self.s, self.x, self.y)
    }
}

/// Why a track is refused.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum TrackError {
    /// The text of a file could not be read as numbers in the expected columns or keys.
    #[error("line {line}, column {column}: {found}; expected {expected}")]
    Syntax {
        /// Line, from 1.
        line: usize,
        /// Column of the first character, from 1.
        column: usize,
        /// What stands there.
        found: String,
        /// What was expected.
        expected: String,
    },
    /// The text gives no widths, and none was given beside it.
    #[error(
        "line {line}: no widths; expected columns w_tr_right_m and w_tr_left_m (in GeoJSON a property \
         `width`), or a width for the whole track beside the file (`--width METRES`)"
    )]
    NoWidth {
        /// Line, from 1.
        line: usize,
    },
    /// Too little of the path is given.
    #[error("{what}: found {found}, expected at least {expected}")]
    TooFew {
        /// Points or segments.
        what: &'static str,
        /// How many there are.
        found: usize,
        /// How many are needed.
        expected: usize,
    },
    /// A number is outside what it may be.
    #[error("{item}: {key} is {found}, expected {expected}")]
    Value {
        /// Which segment or point, and its line if it came from a file.
        item: String,
        /// Which of its numbers.
        key: &'static str,
        /// The number.
        found: f64,
        /// The allowed range.
        expected: &'static str,
    },
    /// Two neighbouring points coincide.
    #[error("{item} repeats the point before it at {place}; expected distinct points")]
    Duplicate {
        /// Which point, and its line if it came from a file.
        item: String,
        /// Where.
        place: Place,
    },
    /// The path does not come back to where it began.
    #[error(
        "open track: the end at {end} misses the start by {gap:.3e} m and {turn:.3e} rad; \
         expected a closed path (at most {tolerance:e})"
    )]
    Open {
        /// End of the path.
        end: Place,
        /// Distance between end and start \[m\].
        gap: f64,
        /// Angle between the tangents at end and start, in (-pi, pi] \[rad\].
        turn: f64,
        /// Largest allowed distance \[m\] and angle \[rad\].
        tolerance: f64,
    },
    /// The last point is far from the first.
    #[error(
        "open track: the last point at {end} is {gap:.3} m from the first, \
         expected at most {limit:.3} m (three times the largest spacing of the other points); \
         add the points of the rest of the lap"
    )]
    Gap {
        /// The last point.
        end: Place,
        /// Its distance from the first \[m\].
        gap: f64,
        /// Largest allowed distance \[m\].
        limit: f64,
    },
    /// The centre line crosses itself as no bridge does.
    #[error(
        "the centre line crosses itself: {first} meets {second}; expected stretches that keep \
         apart, or cross at more than 30 degrees (a bridge)"
    )]
    Crossing {
        /// First passage.
        first: Place,
        /// Second passage.
        second: Place,
    },
    /// Points too far apart for the bend between them.
    #[error(
        "too coarse at {place}: the path turns {turn:.3} rad between neighbouring points \
         {spacing:.3} m apart, expected at most {limit:.3} rad; \
         correct the points there or add some between them"
    )]
    TooCoarse {
        /// Where.
        place: Place,
        /// Turn between neighbouring chords \[rad\].
        turn: f64,
        /// Distance of the points \[m\].
        spacing: f64,
        /// Largest allowed turn \[rad\].
        limit: f64,
    },
    /// A point far from the line through its neighbours.
    #[error(
        "{item} at {place} lies {distance:.3} m from the line through its neighbours, expected at \
         most {limit:.3} m (three tenths of the track's width); correct the point or \
         remove it, or check the unit of the widths"
    )]
    Outlier {
        /// Which point, and its line if it came from a file.
        item: String,
        /// Where.
        place: Place,
        /// Its distance from the line through the others \[m\].
        distance: f64,
        /// Largest allowed distance \[m\].
        limit: f64,
    },
    /// A stretch without points.
    #[error(
        "{item} at {place} is {gap:.3} m from the next point, expected about {typical:.3} m as \
         elsewhere; add the missing points"
    )]
    Hole {
        /// Which point, and its line if it came from a file.
        item: String,
        /// Where.
        place: Place,
        /// Distance to the next point \[m\].
        gap: f64,
        /// Median distance of neighbouring points \[m\].
        typical: f64,
    },
    /// Many points far from any smooth line.
    #[error(
        "{count} points lie far from a smooth line, most of all {item} at {place} by {distance:.3} \
         m, expected at most {limit:.3} m (three tenths of the track's width); check the order of \
         the points and the unit of the widths, or state the noise (`--smooth METRES`)"
    )]
    Scattered {
        /// How many.
        count: usize,
        /// The worst, and its line if it came from a file.
        item: String,
        /// Where it is.
        place: Place,
        /// Its distance from the line \[m\].
        distance: f64,
        /// Largest allowed distance there \[m\].
        limit: f64,
    },
    /// The points go round more than once.
    #[error(
        "the points go round {laps} times: {first} is passed again at {second}; expected one lap; \
         remove the others"
    )]
    Laps {
        /// How often.
        laps: usize,
        /// A place of the first lap.
        first: Place,
        /// The same place later on.
        second: Place,
    },
    /// The widths do not belong to the line, as when one of the two is not in metres.
    #[error(
        "the widths do not fit the line: {share:.0} % of a lap of {length:.3} m bends tighter than \
         its inner width allows, at a mean width of {width:.3} m from edge to edge; expected at \
         most {limit:.0} %; check that x, y and the widths are all in metres"
    )]
    Scale {
        /// Share of the lap whose inner width had to be cut \[%\].
        share: f64,
        /// Length of the lap \[m\].
        length: f64,
        /// Mean width from edge to edge \[m\].
        width: f64,
        /// Largest allowed share \[%\].
        limit: f64,
    },
    /// The inner edge lies beyond the centre of the bend, where s is not defined.
    #[error(
        "too narrow a bend at {place}: its radius is {radius:.3} m, expected more than the \
         inner width of {width:.3} m; smooth the line more, or make the track narrower there"
    )]
    TooTight {
        /// Where.
        place: Place,
        /// Radius of the centre line \[m\].
        radius: f64,
        /// Width to the inner edge \[m\].
        width: f64,
    },
    /// The car's body does not fit between the edges.
    #[error(
        "too narrow at {place}: {width:.3} m from edge to edge, expected more than the body's \
         {body:.3} m; check the unit of the widths, or take a track of the car's scale"
    )]
    TooNarrow {
        /// Where it is narrowest.
        place: Place,
        /// Width from edge to edge \[m\].
        width: f64,
        /// Width of the body \[m\].
        body: f64,
    },
    /// The track is far wider than the car.
    #[error(
        "{width:.3} m from edge to edge at the narrowest place is {share:.0} times the body's width \
         of {body:.3} m, expected at most {limit:.0} times; check that the file is in metres"
    )]
    TooWide {
        /// Width from edge to edge at the narrowest place \[m\].
        width: f64,
        /// Width of the body \[m\].
        body: f64,
        /// Their ratio \[-\].
        share: f64,
        /// Largest allowed ratio \[-\].
        limit: f64,
    },
    /// No line between the edges takes a bend within the car's steering lock.
    #[error(
        "too sharp a bend at {place}: the widest line has a radius of {radius:.3} m, expected at \
         least the {lock:.3} m that the car steers; smooth the line more, or take a track of the \
         car's scale"
    )]
    TooSharp {
        /// Where it is tightest.
        place: Place,
        /// Radius of the widest line \[m\].
        radius: f64,
        /// Radius at full steering lock \[m\].
        lock: f64,
    },
}

impl TrackError {
    /// Line and column in the file, where the problem belongs to one; (0, 0) where not.
    pub(super) fn line_and_column(&self) -> (usize, usize) {
        match self {
            Self::Syntax { line, column, .. } => (*line, *column),
            Self::NoWidth { line } => (*line, 1),
            _ => (0, 0),
        }
    }
}
