//! A track described by straights and arcs, as a designer draws it.

use std::f64::consts::TAU;

use super::arc::Arc;
use super::error::{Place, TrackError};
use super::frenet::wrap_angle;
use super::path::Path;
use super::widths::{Span, Widths, too_tight};
use super::{Track, crossing};
use crate::fingerprint::Fnv1a;

/// Largest distance [m] and angle [rad] by which a track of segments may miss its start.
const CLOSURE: f64 = 1e-6;

/// A straight or an arc of a track, with the widths along it if they differ from the track's.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Segment {
    /// Length along the centre line \[m\].
    pub length: f64,
    /// Curvature, positive to the left, 0 for a straight [1/m].
    pub kappa: f64,
    /// Distances to the left and right edge at the beginning \[m\].
    pub width_start: Option<(f64, f64)>,
    /// Distances to the left and right edge at the end \[m\]; linear in between.
    pub width_end: Option<(f64, f64)>,
}

impl Segment {
    /// A straight of the given length \[m\].
    #[must_use]
    pub fn straight(length: f64) -> Self {
        Self { length, kappa: 0.0, width_start: None, width_end: None }
    }

    /// An arc with signed radius \[m\], positive to the left, through the angle \[rad\], positive.
    #[must_use]
    pub fn arc(radius: f64, angle: f64) -> Self {
        let length = radius.abs() * angle;
        Self { length, kappa: 1.0 / radius, width_start: None, width_end: None }
    }

    /// The same piece with its own distances to the left and right edge \[m\].
    #[must_use]
    pub fn with_widths(self, left: f64, right: f64) -> Self {
        self.with_taper((left, right), (left, right))
    }

    /// The same piece with distances to the (left, right) edge \[m\] that change linearly.
    #[must_use]
    pub fn with_taper(self, start: (f64, f64), end: (f64, f64)) -> Self {
        Self { width_start: Some(start), width_end: Some(end), ..self }
    }
}

/// The track of the segments, or everything wrong with them. `item` names segment i.
pub(super) fn build(
    name: &str,
    segments: &[Segment],
    width_left: f64,
    width_right: f64,
    item: &dyn Fn(usize) -> String,
) -> Result<Track, Vec<TrackError>> {
    let mut problems = Vec::new();
    let mut arcs = Vec::with_capacity(segments.len());
    let mut spans = Vec::with_capacity(segments.len());
    let mut hash = Fnv1a::new();
    if segments.len() < 2 {
        let (what, found) = ("segments", segments.len());
        problems.push(TrackError::TooFew { what, found, expected: 2 });
    }
    let (mut s, mut x, mut y, mut psi) = (0.0, 0.0, 0.0, 0.0);
    for (i, segment) in segments.iter().enumerate() {
        let start = segment.width_start.unwrap_or((width_left, width_right));
        let end = segment.width_end.unwrap_or(start);
        problems.extend(segment.problems(start, end, &|| item(i)));
        let Segment { length, kappa, .. } = *segment;
        hash = hash.with(&[length, kappa, start.0, start.1, end.0, end.1]);
        let arc = Arc { s, length, kappa, x, y, psi };
        let from = Place { s, x, y };
        (x, y, psi) = arc.pose(length);
        arcs.push(arc);
        spans.push(Span::new(s, length, start, end));
        s += length;
        let tight = too_tight(from, kappa, start);
        problems.extend(tight.or_else(|| too_tight(Place { s, x, y }, kappa, end)));
    }
    let (gap, turn) = (libm::hypot(x, y), wrap_angle(psi));
    if problems.is_empty() && (gap > CLOSURE || turn.abs() > CLOSURE) {
        let end = Place { s, x, y };
        problems.push(TrackError::Open { end, gap, turn, tolerance: CLOSURE });
    }
    let (path, widths) = (Path::Arcs(arcs), Widths::new(spans));
    if !problems.is_empty() {
        return Err(problems);
    }
    let bridges = crossing::find(&path, s, widths.range().1)?;
    Ok(Track::assemble(name, path, widths, bridges, hash.finish()))
}

impl Segment {
    /// The numbers of this segment that are not what they may be.
    fn problems(
        &self,
        start: (f64, f64),
        end: (f64, f64),
        item: &dyn Fn() -> String,
    ) -> Vec<TrackError> {
        let turn = (self.kappa * self.length).abs();
        let positive = |v: f64| v > 0.0;
        [
            ("length", self.length, positive(self.length), "a length above 0 m"),
            ("curvature", self.kappa, true, "a finite curvature (a radius other than 0 m)"),
            ("angle", turn, turn < TAU, "less than a full turn (6.283 rad)"),
            ("width_left", start.0, positive(start.0), "a width above 0 m"),
            ("width_right", start.1, positive(start.1), "a width above 0 m"),
            ("width_left_end", end.0, positive(end.0), "a width above 0 m"),
            ("width_right_end", end.1, positive(end.1), "a width above 0 m"),
        ]
        .into_iter()
        .filter(|(_, found, ok, _)| !(*ok && found.is_finite()))
        .map(|(key, found, _, expected)| TrackError::Value { item: item(), key, found, expected })
        .collect()
    }
}
