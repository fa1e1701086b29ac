//! Distances from the centre line to both edges, piecewise linear in s.

/// A stretch with linear widths.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Span {
    /// Distance along the track at the beginning [m].
    pub s: f64,
    /// Widths (left, right) at the beginning [m].
    pub start: (f64, f64),
    /// Change of the widths (left, right) per metre.
    pub slope: (f64, f64),
}

impl Span {
    /// The stretch of this length [m] with (left, right) widths at its ends [m].
    pub(super) fn new(s: f64, length: f64, start: (f64, f64), end: (f64, f64)) -> Self {
        let slope = ((end.0 - start.0) / length, (end.1 - start.1) / length);
        Self { s, start, slope }
    }
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

    /// The stretches in order.
    pub(super) fn spans(&self) -> &[Span] {
        &self.spans
    }

    /// Distances (left, right) to the edges at s in [0, L) [m].
    pub(super) fn at(&self, s: f64) -> (f64, f64) {
        let i = self.spans.partition_point(|span| span.s <= s).saturating_sub(1);
        let Span { s: s_i, start, slope } = self.spans[i];
        (start.0 + slope.0 * (s - s_i), start.1 + slope.1 * (s - s_i))
    }
}
