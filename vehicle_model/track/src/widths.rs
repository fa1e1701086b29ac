//! Distances from the centre line to both edges, piecewise linear in s.

use super::error::{Place, TrackError};

/// A stretch with linear widths.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Span {
    /// Distance along the track at the beginning [m].
    pub s: f64,
    /// Length [m].
    pub length: f64,
    /// Widths (left, right) at the beginning [m].
    pub start: (f64, f64),
    /// Widths (left, right) at the end [m].
    pub end: (f64, f64),
    /// Change of the widths (left, right) per metre.
    pub slope: (f64, f64),
}

impl Span {
    /// The stretch of this length [m] with (left, right) widths at its ends [m].
    pub(super) fn new(s: f64, length: f64, start: (f64, f64), end: (f64, f64)) -> Self {
        let slope = ((end.0 - start.0) / length, (end.1 - start.1) / length);
        Self { s, length, start, end, slope }
    }
}

/// What is wrong with a bend of this curvature whose (left, right) widths [m] these are: on its
/// inner side the width must stay below the radius, or s has no meaning there.
pub(super) fn too_tight(place: Place, kappa: f64, widths: (f64, f64)) -> Option<TrackError> {
    let width = if kappa > 0.0 { widths.0 } else { widths.1 };
    let radius = 1.0 / kappa.abs();
    (width >= radius).then_some(TrackError::TooTight { place, radius, width })
}

/// The widths of a whole lap.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Widths {
    spans: Vec<Span>,
}

impl Widths {
    /// Widths of the stretches in order; the first begins at 0.
    pub(super) fn new(spans: Vec<Span>) -> Self {
        Self { spans }
    }

    /// Distance along the track where each stretch begins [m].
    pub(super) fn starts(&self) -> Vec<f64> {
        self.spans.iter().map(|span| span.s).collect()
    }

    /// Widths (left, right) at the beginning and the end of each stretch [m].
    pub(super) fn ends(&self) -> impl Iterator<Item = ((f64, f64), (f64, f64))> {
        self.spans.iter().map(|span| (span.start, span.end))
    }

    /// Least and largest distance from edge to edge [m].
    pub(super) fn range(&self) -> (f64, f64) {
        self.spans
            .iter()
            .flat_map(|span| {
                let width = span.start.0 + span.start.1;
                [width, width + (span.slope.0 + span.slope.1) * span.length]
            })
            .fold((f64::INFINITY, 0.0), |(least, largest), width| {
                (width.min(least), width.max(largest))
            })
    }

    /// The distances from `from` to `to` in [0, L), if they are the same all along [m].
    pub(super) fn even(&self, from: f64, to: f64) -> Option<(f64, f64)> {
        let i = self.spans.partition_point(|span| span.s <= from).saturating_sub(1);
        let span = &self.spans[i];
        let even = span.slope == (0.0, 0.0) && to <= span.s + span.length;
        even.then_some(span.start)
    }

    /// Distances (left, right) to the edges at s in [0, L) [m].
    pub(super) fn at(&self, s: f64) -> (f64, f64) {
        let i = self.spans.partition_point(|span| span.s <= s).saturating_sub(1);
        let Span { s: s_i, start, slope, .. } = self.spans[i];
        (start.0 + slope.0 * (s - s_i), start.1 + slope.1 * (s - s_i))
    }
}
