//! Finds where a centre line crosses or touches itself.
//!
//! The line is cut into chords that stay within a ten-thousandth of the track's width of it, so
//! that two stretches side by side are not taken for a crossing. Chords are swept along the
//! longer side of the track.

use super::error::{Place, TrackError};
use super::path::Path;

/// Largest distance between a chord and its piece, in widths of the track.
const SAGITTA_WIDTHS: f64 = 1e-4;
/// Chords closer than this along the line are neighbours, in widths of the track.
const NEIGHBOUR_WIDTHS: f64 = 1e-3;

/// Sine of the least angle at which a track may cross itself on a bridge: 30 degrees.
const STEEP: f64 = 0.5;
/// Least length of either loop between the two passages of a bridge, in widths of the track.
const LOOP_WIDTHS: f64 = 3.0;

/// Most chords of one piece.
const MOST_CHORDS: f64 = 1e5;

/// A straight line between two places.
#[derive(Clone, Copy)]
struct Chord {
    from: Place,
    to: Place,
}

impl Chord {
    /// Least and largest coordinate along x, or along y.
    fn range(&self, along_x: bool) -> (f64, f64) {
        let (a, b) = if along_x { (self.from.x, self.to.x) } else { (self.from.y, self.to.y) };
        (a.min(b), a.max(b))
    }

    /// Which side of the chord's line a place is on: positive left, negative right.
    fn side(&self, p: Place) -> f64 {
        let (a, b) = (self.from, self.to);
        (b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x)
    }

    /// Where the chord meets the line of another; its beginning if it runs along it.
    fn meeting(&self, other: &Self) -> Place {
        let (a, b) = (other.side(self.from), other.side(self.to));
        let t = if a == b { 0.0 } else { a / (a - b) };
        let between = |from: f64, to: f64| from + t * (to - from);
        Place {
            s: between(self.from.s, self.to.s),
            x: between(self.from.x, self.to.x),
            y: between(self.from.y, self.to.y),
        }
    }

    /// Sine of the angle between the chords.
    fn sine(&self, other: &Self) -> f64 {
        let along = |c: &Self| (c.to.x - c.from.x, c.to.y - c.from.y);
        let (a, b) = (along(self), along(other));
        (a.0 * b.1 - a.1 * b.0).abs() / (libm::hypot(a.0, a.1) * libm::hypot(b.0, b.1))
    }

    /// Whether the chords have a point in common.
    fn meets(&self, other: &Self) -> bool {
        let overlap = |along_x: bool| {
            let (a, b) = (self.range(along_x), other.range(along_x));
            a.0 <= b.1 && b.0 <= a.1
        };
        overlap(false)
            && overlap(true)
            && self.side(other.from) * self.side(other.to) <= 0.0
            && other.side(self.from) * other.side(self.to) <= 0.0
    }
}

/// The chords of the whole line, in order.
fn chords(path: &Path, width: f64) -> Vec<Chord> {
    let mut places = Vec::new();
    for i in 0..path.len() {
        let (start, length) = (path.start_of(i), path.length_of(i));
        let step = (8.0 * SAGITTA_WIDTHS * width / path.kappa_in(i, 0.0).abs()).sqrt();
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let count = (length / step).ceil().min(MOST_CHORDS) as usize;
        let count = count.max(1);
        for k in 0..count {
            let u = length * k as f64 / count as f64;
            let (x, y) = path.point_in(i, u);
            places.push(Place { s: start + u, x, y });
        }
    }
    let end = path.start_of(path.len() - 1) + path.length_of(path.len() - 1);
    let home = Place { s: end, ..places[0] };
    let ends = places.iter().skip(1).copied().chain([home]);
    places.iter().zip(ends).map(|(&from, to)| Chord { from, to }).collect()
}

/// Every crossing of the centre line with itself that a bridge can explain, each as its two
/// passages; those closer together than a width once.
///
/// # Errors
/// Those that no bridge explains: the stretches meet at a shallow angle, or a short loop closes.
pub(super) fn find(
    path: &Path,
    length: f64,
    width: f64,
) -> Result<Vec<(Place, Place)>, Vec<TrackError>> {
    let chords = chords(path, width);
    let n = chords.len();
    let mut order: Vec<usize> = (0..n).collect();
    // Few chords share a place on the longer side of the track.
    let extent = |along_x: bool| {
        let ranges = chords.iter().map(|chord| chord.range(along_x));
        let (low, high) = ranges.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), range| {
            (range.0.min(low), range.1.max(high))
        });
        high - low
    };
    let along_x = extent(true) >= extent(false);
    let range = |i: usize| chords[i].range(along_x);
    order.sort_by(|&a, &b| range(a).0.total_cmp(&range(b).0));
    let mut found: Vec<(Place, Place, bool)> = Vec::new();
    for (k, &a) in order.iter().enumerate() {
        let reach = range(a).1;
        for &b in order[k + 1..].iter().take_while(|&&b| range(b).0 <= reach) {
            let (i, j) = (a.min(b), a.max(b));
            let apart = chords[j].from.s - chords[i].to.s;
            let around = length - chords[j].to.s + chords[i].from.s;
            let wraps = i == 0 && j == n - 1;
            let near = NEIGHBOUR_WIDTHS * width;
            if j > i + 1 && !wraps && apart.min(around) > near && chords[i].meets(&chords[j]) {
                let (i, j) = (&chords[i], &chords[j]);
                let loops = apart.min(around) > LOOP_WIDTHS * width;
                found.push((i.meeting(j), j.meeting(i), loops && i.sine(j) > STEEP));
            }
        }
    }
    found.sort_by(|a, b| a.0.s.total_cmp(&b.0.s));
    found.dedup_by(|b, a| {
        let same = (b.0.s - a.0.s).abs() < width && (b.1.s - a.1.s).abs() < width;
        a.2 &= b.2 || !same;
        same
    });
    let (bridges, wrong): (Vec<_>, Vec<_>) = found.into_iter().partition(|crossing| crossing.2);
    if wrong.is_empty() {
        return Ok(bridges.into_iter().map(|(first, second, _)| (first, second)).collect());
    }
    let error = |(first, second, _)| TrackError::Crossing { first, second };
    Err(wrong.into_iter().map(error).collect())
}
