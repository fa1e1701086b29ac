//! A track described by surveyed points of its centre line.
//!
//! A closed cubic spline over the chord lengths goes through the points. Its arc length is then
//! measured, points at equal distances are taken from it, and a second closed spline goes
//! through those: its parameter is the arc length.
//!
//! The spline interpolates: nothing is smoothed. What comes from a file is smoothed before.

use super::error::{Place, TrackError};
use super::frenet::wrap_angle;
use super::path::Path;
use super::spline::Spline;
use super::widths::{Span, Widths, too_tight};
use super::{Track, crossing};
use crate::fingerprint::Fnv1a;

/// Largest deviation of |r'(s)| from 1.
const SPEED_TOLERANCE: f64 = 1e-6;
/// Knots of the arc-length spline are taken this many times as dense as the points, then
/// doubled until the tolerance is met, at most up to the second number.
const DENSITY: (usize, usize) = (2, 32);
/// No denser than this many knots, whatever the tolerance: a survey at every centimetre is taken
/// as it is.
const MOST_KNOTS: usize = 100_000;
/// Fewest points of a track.
pub(super) const FEWEST: usize = 8;
/// Largest coordinate and width: more than twice around the earth [m].
pub(super) const FARTHEST: f64 = 1e8;
/// Points closer than this are the same point [m].
pub(super) const SAME: f64 = 1e-6;
/// Largest turn from one chord to the next, just above that of a regular octagon [rad].
const TURN: f64 = 0.8;
/// Largest sagitta between neighbouring points, in distances to the nearer edge.
const SAGITTA_WIDTHS: f64 = 0.5;
/// The last point may be this many of the largest other spacings away from the first.
const GAP_SPACINGS: f64 = 3.0;
/// Nodes and weights of the five-point rule of Gauss and Legendre on [-1, 1].
const GAUSS: [(f64, f64); 5] = [
    (0.0, 128.0 / 225.0),
    (-0.538_469_310_105_683_1, 0.478_628_670_499_366_5),
    (0.538_469_310_105_683_1, 0.478_628_670_499_366_5),
    (-0.906_179_845_938_664, 0.236_926_885_056_189_1),
    (0.906_179_845_938_664, 0.236_926_885_056_189_1),
];

/// A point of the centre line with the distances to both edges.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrackPoint {
    /// Position \[m\].
    pub x: f64,
    /// Position \[m\].
    pub y: f64,
    /// Distance to the left edge \[m\].
    pub width_left: f64,
    /// Distance to the right edge \[m\].
    pub width_right: f64,
}

/// Arc length of piece i from its beginning to u.
fn arc_length(spline: &Spline, i: usize, u: f64) -> f64 {
    GAUSS.iter().map(|(x, w)| w * spline.speed_in(i, 0.5 * u * (1.0 + x))).sum::<f64>() * 0.5 * u
}

/// Path and widths through distinct points.
pub(super) fn fit(points: &[TrackPoint]) -> (Path, Widths) {
    let n = points.len();
    let xy: Vec<(f64, f64)> = points.iter().map(|p| (p.x, p.y)).collect();
    let mut knots = vec![0.0];
    for i in 0..n {
        let (a, b) = (xy[i], xy[(i + 1) % n]);
        knots.push(knots[i] + libm::hypot(b.0 - a.0, b.1 - a.1));
    }
    let chordal = Spline::through(knots, &xy);
    let mut s = vec![0.0];
    for i in 0..n {
        s.push(s[i] + arc_length(&chordal, i, chordal.length_of(i)));
    }
    let mut density = DENSITY.0;
    let mut spline = equidistant(&chordal, &s, density * n);
    while density < DENSITY.1 && density * n < MOST_KNOTS && speed_error(&spline) > SPEED_TOLERANCE
    {
        density *= 2;
        spline = equidistant(&chordal, &s, density * n);
    }
    let widths = |i: usize| (points[i % n].width_left, points[i % n].width_right);
    let spans = (0..n).map(|i| Span::new(s[i], s[i + 1] - s[i], widths(i), widths(i + 1)));
    (Path::Spline(spline), Widths::new(spans.collect()))
}

/// The closed spline through n points at equal distances along the curve, whose knots lie at
/// the arc lengths s.
fn equidistant(curve: &Spline, s: &[f64], n: usize) -> Spline {
    let length = s[s.len() - 1];
    let knots: Vec<f64> = (0..=n).map(|k| length * k as f64 / n as f64).collect();
    let mut points = Vec::with_capacity(n);
    let mut i = 0;
    for &target in &knots[..n] {
        while i + 2 < s.len() && s[i + 1] <= target {
            i += 1;
        }
        let wanted = target - s[i];
        let mut u = wanted / (s[i + 1] - s[i]) * curve.length_of(i);
        for _ in 0..8 {
            u -= (arc_length(curve, i, u) - wanted) / curve.speed_in(i, u);
        }
        let (x, y, _) = curve.pose_in(i, u);
        points.push((x, y));
    }
    Spline::through(knots, &points)
}

/// Largest deviation of |r'(s)| from 1, at the knots, middles and quarters.
fn speed_error(spline: &Spline) -> f64 {
    let at = |i: usize, part: f64| (spline.speed_in(i, part * spline.length_of(i)) - 1.0).abs();
    (0..spline.len())
        .flat_map(|i| [at(i, 0.0), at(i, 0.25), at(i, 0.5), at(i, 0.75)])
        .fold(0.0, f64::max)
}

/// The track through the points, or everything wrong with them. `item` names point i.
pub(super) fn build(
    name: &str,
    points: &[TrackPoint],
    item: &dyn Fn(usize) -> String,
) -> Result<Track, Vec<TrackError>> {
    // A list that repeats its first point at the end means the same track.
    let points = match points {
        [first, .., last] if libm::hypot(last.x - first.x, last.y - first.y) < SAME => {
            &points[..points.len() - 1]
        }
        _ => points,
    };
    let mut problems = bad_numbers(points, item);
    if points.len() < FEWEST {
        let found = points.len();
        problems.push(TrackError::TooFew { what: "points", found, expected: FEWEST });
    }
    if problems.is_empty() {
        problems = bad_shape(points, item);
    }
    if !problems.is_empty() {
        return Err(problems);
    }
    let (path, widths) = fit(points);
    problems.extend(tight_bends(&path, &widths));
    let last = path.len() - 1;
    let length = path.start_of(last) + path.length_of(last);
    let bridges = crossing::find(&path, length, widths.range().1);
    problems.extend(bridges.as_ref().err().into_iter().flatten().cloned());
    if !problems.is_empty() {
        return Err(problems);
    }
    let bridges = bridges?;
    let hash = points
        .iter()
        .fold(Fnv1a::new(), |hash, p| hash.with(&[p.x, p.y, p.width_left, p.width_right]));
    Ok(Track::assemble(name, path, widths, bridges, hash.finish()))
}

/// Numbers that are not finite or not positive where they must be.
pub(super) fn bad_numbers(
    points: &[TrackPoint],
    item: &dyn Fn(usize) -> String,
) -> Vec<TrackError> {
    let mut problems = Vec::new();
    for (i, p) in points.iter().enumerate() {
        for (key, found, ok, expected) in [
            ("x", p.x, true, "metres from -1e8 to 1e8"),
            ("y", p.y, true, "metres from -1e8 to 1e8"),
            ("width_left", p.width_left, p.width_left > 0.0, "a width above 0 m, at most 1e8 m"),
            ("width_right", p.width_right, p.width_right > 0.0, "a width above 0 m, at most 1e8 m"),
        ] {
            if !(found.abs() <= FARTHEST && ok) {
                problems.push(TrackError::Value { item: item(i), key, found, expected });
            }
        }
    }
    problems
}

/// Points that coincide, that are too far apart for their bend, or that do not close.
pub(super) fn bad_shape(points: &[TrackPoint], item: &dyn Fn(usize) -> String) -> Vec<TrackError> {
    let n = points.len();
    let chord = |i: usize| {
        let (a, b) = (&points[i % n], &points[(i + 1) % n]);
        (b.x - a.x, b.y - a.y)
    };
    let spacing = |i: usize| libm::hypot(chord(i).0, chord(i).1);
    let mut s = 0.0;
    let mut places = Vec::with_capacity(n);
    for (i, p) in points.iter().enumerate() {
        places.push(Place { s, x: p.x, y: p.y });
        s += spacing(i);
    }
    let duplicates: Vec<TrackError> = (1..n)
        .filter(|&i| spacing(i - 1) < SAME)
        .map(|i| TrackError::Duplicate { item: item(i), place: places[i] })
        .collect();
    if !duplicates.is_empty() {
        return duplicates;
    }
    let mut problems = Vec::new();
    let limit = GAP_SPACINGS * (0..n - 1).map(spacing).fold(0.0, f64::max);
    let closed = spacing(n - 1) <= limit;
    if !closed {
        problems.push(TrackError::Gap { end: places[n - 1], gap: spacing(n - 1), limit });
    }
    for (i, &place) in places.iter().enumerate() {
        let (before, after) = (chord(i + n - 1), chord(i));
        let turn =
            wrap_angle(libm::atan2(after.1, after.0) - libm::atan2(before.1, before.0)).abs();
        // The ends of an open list say nothing about its points.
        let spacing = spacing((i + n - 1) % n).max(spacing(i));
        // Between two points the path is known to about a sagitta, spacing * turn / 8.
        let width = points[i].width_left.min(points[i].width_right);
        let limit = TURN.min(8.0 * SAGITTA_WIDTHS * width / spacing);
        // The ends of an open list say nothing about its points.
        if turn > limit && (closed || (1..n - 1).contains(&i)) {
            problems.push(TrackError::TooCoarse { place, turn, spacing, limit });
        }
    }
    problems
}

/// The tightest place of each stretch whose radius is below its inner width.
fn tight_bends(path: &Path, widths: &Widths) -> Vec<TrackError> {
    let mut problems: Vec<TrackError> = Vec::new();
    let mut last = None;
    for i in 0..path.len() {
        let s = path.start_of(i);
        let (x, y, _) = path.pose_in(i, 0.0);
        let Some(found) = too_tight(Place { s, x, y }, path.kappa_in(i, 0.0), widths.at(s)) else {
            continue;
        };
        match (problems.last_mut(), &found) {
            (
                Some(TrackError::TooTight { radius: least, .. }),
                TrackError::TooTight { radius, .. },
            ) if i > 0 && last == Some(i - 1) => {
                if radius < least
                    && let Some(worst) = problems.last_mut()
                {
                    *worst = found;
                }
            }
            _ => problems.push(found),
        }
        last = Some(i);
    }
    problems
}
