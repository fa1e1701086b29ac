//! A track described by straights and arcs, as a designer draws it.

use super::arc::Arc;
use super::error::{Place, TrackError};
use super::frenet::wrap_angle;
use super::widths::{Span, Widths};

/// Largest distance [m] and angle [rad] by which a track of segments may miss its start.
const CLOSURE: f64 = 1e-6;

/// A straight or an arc of a track, with the widths along it if they differ from the track's.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Segment {
    /// Length along the centre line [m].
    pub length: f64,
    /// Curvature, positive to the left, 0 for a straight [1/m].
    pub kappa: f64,
    /// Distances to the left and right edge at the beginning [m].
    pub width_start: Option<(f64, f64)>,
    /// Distances to the left and right edge at the end [m]; linear in between.
    pub width_end: Option<(f64, f64)>,
}

impl Segment {
    /// A straight of the given length [m].
    #[must_use]
    pub fn straight(length: f64) -> Self {
        Self { length, kappa: 0.0, width_start: None, width_end: None }
    }

    /// An arc with signed radius [m], positive to the left, through the angle [rad], positive.
    #[must_use]
    pub fn arc(radius: f64, angle: f64) -> Self {
        let length = radius.abs() * angle;
        Self { length, kappa: 1.0 / radius, width_start: None, width_end: None }
    }

    /// The same piece with its own distances to the left and right edge [m].
    #[must_use]
    pub fn with_widths(self, left: f64, right: f64) -> Self {
        self.with_taper((left, right), (left, right))
    }

    /// The same piece with distances to the (left, right) edge [m] that change linearly.
    #[must_use]
    pub fn with_taper(self, start: (f64, f64), end: (f64, f64)) -> Self {
        Self { width_start: Some(start), width_end: Some(end), ..self }
    }
}

/// The chain of arcs of the segments and their widths, with everything wrong with them.
pub(super) fn chain(
    segments: &[Segment],
    width_left: f64,
    width_right: f64,
    item: &dyn Fn(usize) -> String,
) -> (Vec<Arc>, Widths, Vec<TrackError>) {
    let mut problems = Vec::new();
    let mut arcs = Vec::with_capacity(segments.len());
    let mut spans = Vec::with_capacity(segments.len());
    if segments.len() < 2 {
        let (what, found) = ("segments", segments.len());
        problems.push(TrackError::TooFew { what, found, expected: 2 });
    }
    let (mut s, mut x, mut y, mut psi) = (0.0, 0.0, 0.0, 0.0);
    for (i, segment) in segments.iter().enumerate() {
        let mut require = |key, found: f64, ok: bool, expected| {
            if !(found.is_finite() && ok) {
                problems.push(TrackError::Value { item: item(i), key, found, expected });
            }
        };
        let start = segment.width_start.unwrap_or((width_left, width_right));
        let end = segment.width_end.unwrap_or(start);
        let turn = (segment.kappa * segment.length).abs();
        require("length", segment.length, segment.length > 0.0, "a length above 0 m");
        require("curvature", segment.kappa, true, "a finite number");
        require("angle", turn, turn < std::f64::consts::TAU, "less than a full turn");
        for (key, width) in [
            ("width_left", start.0),
            ("width_right", start.1),
            ("width_left at the end", end.0),
            ("width_right at the end", end.1),
        ] {
            require(key, width, width > 0.0, "a width above 0 m");
        }
        let arc = Arc { s, length: segment.length, kappa: segment.kappa, x, y, psi };
        (x, y, psi) = arc.pose(segment.length);
        arcs.push(arc);
        spans.push(Span::new(s, segment.length, start, end));
        s += segment.length;
    }
    if problems.is_empty() {
        let (gap, turn) = (x.hypot(y), wrap_angle(psi));
        if gap > CLOSURE || turn.abs() > CLOSURE {
            let end = Place { s, x, y };
            problems.push(TrackError::Open { end, gap, turn, tolerance: CLOSURE });
        }
    }
    (arcs, Widths::new(spans), problems)
}
