//! Finds where a centre line crosses or touches itself.
//!
//! The line is cut into chords that stay within a ten-thousandth of the track's width of it, so
//! that two stretches side by side are not taken for a crossing. Chords are swept along x.

use super::error::{Place, TrackError};
use super::path::Path;

/// Largest distance between a chord and its piece, in widths of the track.
const SAGITTA_WIDTHS: f64 = 1e-4;
/// Chords closer than this along the line are neighbours, in widths of the track.
const NEIGHBOUR_WIDTHS: f64 = 1e-3;

/// A straight line between two places.
#[derive(Clone, Copy)]
struct Chord {
    from: Place,
    to: Place,
}

impl Chord {
    fn min_x(&self) -> f64 {
        self.from.x.min(self.to.x)
    }

    fn max_x(&self) -> f64 {
        self.from.x.max(self.to.x)
    }

    /// Which side of the chord's line a place is on: positive left, negative right.
    fn side(&self, p: Place) -> f64 {
        let (a, b) = (self.from, self.to);
        (b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x)
    }

    /// Whether the chords have a point in common.
    fn meets(&self, other: &Self) -> bool {
        let overlap = |a_0: f64, a_1: f64, b_0: f64, b_1: f64| {
            a_0.min(a_1) <= b_0.max(b_1) && b_0.min(b_1) <= a_0.max(a_1)
        };
        overlap(self.from.y, self.to.y, other.from.y, other.to.y)
            && overlap(self.from.x, self.to.x, other.from.x, other.to.x)
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
        let count = (length / step).ceil().clamp(1.0, 1e5) as usize;
        for k in 0..count {
            let u = length * k as f64 / count as f64;
            let (x, y) = path.point_in(i, u);
            places.push(Place { s: start + u, x, y });
        }
    }
    let n = places.len();
    (0..n).map(|i| Chord { from: places[i], to: places[(i + 1) % n] }).collect()
}

/// Every crossing of the centre line with itself; those closer together than a width once.
pub(super) fn find(path: &Path, length: f64, width: f64) -> Vec<TrackError> {
    let chords = chords(path, width);
    let n = chords.len();
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by(|&a, &b| chords[a].min_x().total_cmp(&chords[b].min_x()));
    let mut found: Vec<(Place, Place)> = Vec::new();
    for (k, &a) in order.iter().enumerate() {
        let reach = chords[a].max_x();
        for &b in order[k + 1..].iter().take_while(|&&b| chords[b].min_x() <= reach) {
            let (i, j) = (a.min(b), a.max(b));
            let apart = chords[j].from.s - chords[i].to.s;
            let around = length - chords[j].to.s + chords[i].from.s;
            let wraps = i == 0 && j == n - 1;
            let near = NEIGHBOUR_WIDTHS * width;
            if j > i + 1 && !wraps && apart.min(around) > near && chords[i].meets(&chords[j]) {
                found.push((chords[i].from, chords[j].from));
            }
        }
    }
    found.sort_by(|a, b| a.0.s.total_cmp(&b.0.s));
    found.dedup_by(|b, a| (b.0.s - a.0.s).abs() < width && (b.1.s - a.1.s).abs() < width);
    found.into_iter().map(|(first, second)| TrackError::Crossing { first, second }).collect()
}
