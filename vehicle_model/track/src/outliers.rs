//! What points far from the line through the others say about a file.

use super::error::{Place, TrackError};
use super::frenet::wrap_angle;
use super::points::TrackPoint;
use super::survey::{distance, mean_width};
use std::f64::consts::TAU;

/// More wrong points than this, and than this share of all, are no single mistakes.
const MANY: (usize, f64) = (2, 0.01);
/// A spacing this many times the median one is a hole.
const HOLE: f64 = 4.0;
/// A wrong point has a hole beside it if it is no more than this many points away.
const BESIDE: usize = 2;
/// Points further apart than this many mean widths are sparse.
const SPARSE: f64 = 1.0;
/// A median turn from chord to chord above this is no order of driving \[rad\].
const TURN: f64 = 0.8;

/// A point far from the line through the others.
pub(super) struct Far {
    /// Its number.
    pub point: usize,
    /// Its distance from that line [m].
    pub distance: f64,
    /// Largest allowed distance [m].
    pub limit: f64,
}

/// Where the points are, along the chords.
pub(super) fn places(points: &[TrackPoint]) -> Vec<Place> {
    let mut s = 0.0;
    (0..points.len())
        .map(|i| {
            let p = &points[i];
            let place = Place { s, x: p.x, y: p.y };
            s += distance(p, &points[(i + 1) % points.len()]);
            place
        })
        .collect()
}

/// Turns from each chord to the next, in (-pi, pi] \[rad\].
fn turns(points: &[TrackPoint]) -> Vec<f64> {
    let n = points.len();
    let heading = |i: usize| {
        let (a, b) = (&points[i % n], &points[(i + 1) % n]);
        libm::atan2(b.y - a.y, b.x - a.x)
    };
    (0..n).map(|i| wrap_angle(heading(i) - heading(i + n - 1))).collect()
}

/// The middle one of the values.
pub(super) fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or_default()
}

/// Stretches without points that the line bends in by more than the points tell: as between
/// neighbours elsewhere, it is known to about a sagitta, spacing * turn / 8, which half the width
/// to the nearer edge must exceed. `item` names point i.
pub(super) fn holes(points: &[TrackPoint], item: &dyn Fn(usize) -> String) -> Vec<TrackError> {
    let n = points.len();
    let (places, turns) = (places(points), turns(points));
    let spacings: Vec<f64> = (0..n).map(|i| distance(&points[i], &points[(i + 1) % n])).collect();
    let typical = median(spacings.iter().copied());
    (0..n)
        .filter(|&i| {
            let p = &points[i];
            let turn = turns[i].abs().max(turns[(i + 1) % n].abs());
            let most = TURN.min(4.0 * p.width_left.min(p.width_right) / spacings[i]);
            is_hole(points, i, typical) && turn > most
        })
        .map(|i| TrackError::Hole { item: item(i), place: places[i], gap: spacings[i], typical })
        .collect()
}

/// Whether the points after i are missing. Past a single point far away the line goes on where it
/// was.
fn is_hole(points: &[TrackPoint], i: usize, typical: f64) -> bool {
    let n = points.len();
    let across = |a: usize, b: usize| distance(&points[a % n], &points[b % n]);
    across(i, i + 1).min(across(i + n - 1, i + 1)).min(across(i, i + 2)) > HOLE * typical
}

/// What is wrong with a file that has these points far from the line: a hole, sparse points,
/// points in no order or with much noise, or single wrong points. `item` names point i.
pub(super) fn explain(
    points: &[TrackPoint],
    far: &[Far],
    item: &dyn Fn(usize) -> String,
) -> Vec<TrackError> {
    let n = points.len();
    let places = places(points);
    let spacings: Vec<f64> = (0..n).map(|i| distance(&points[i], &points[(i + 1) % n])).collect();
    let typical = median(spacings.iter().copied());
    let Some(worst) = far.iter().max_by(|a, b| a.distance.total_cmp(&b.distance)) else {
        return Vec::new();
    };
    let beside = |p: usize| (p + n - BESIDE - 1..p + n + BESIDE).map(|i| i % n);
    let hole = far
        .iter()
        .flat_map(|far| beside(far.point))
        .filter(|&i| is_hole(points, i, typical))
        .max_by(|&a, &b| spacings[a].total_cmp(&spacings[b]));
    let many = far.len() > MANY.0 && far.len() as f64 > MANY.1 * n as f64;
    let turns = turns(points);
    let ordered = median(turns.iter().map(|turn| turn.abs())) < TURN;
    if let Some(i) = hole
        && ordered
    {
        let (item, place, gap) = (item(i), places[i], spacings[i]);
        return vec![TrackError::Hole { item, place, gap, typical }];
    }
    if many && ordered && typical > SPARSE * mean_width(points) {
        let i = (0..n).max_by(|&a, &b| turns[a].abs().total_cmp(&turns[b].abs())).unwrap_or(0);
        let spacing = spacings[i].max(spacings[(i + n - 1) % n]);
        let limit = (2.0 * mean_width(points) / spacing).min(TURN);
        let turn = turns[i].abs();
        return vec![TrackError::TooCoarse { place: places[i], turn, spacing, limit }];
    }
    if many {
        return vec![TrackError::Scattered {
            count: far.len(),
            item: item(worst.point),
            place: places[worst.point],
            distance: worst.distance,
            limit: worst.limit,
        }];
    }
    far.iter()
        .map(|far| TrackError::Outlier {
            item: item(far.point),
            place: places[far.point],
            distance: far.distance,
            limit: far.limit,
        })
        .collect()
}

/// The problems, or the one behind them if points that cross themselves go round several times.
pub(super) fn laps(points: &[TrackPoint], problems: Vec<TrackError>) -> Vec<TrackError> {
    let turn: f64 = turns(points).iter().sum();
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let laps = (turn.abs() / TAU).round() as usize;
    match problems.first() {
        Some(&TrackError::Crossing { first, second }) if laps > 1 => {
            vec![TrackError::Laps { laps, first, second }]
        }
        _ => problems,
    }
}
