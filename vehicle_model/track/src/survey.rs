//! A drivable track of surveyed points: smoothed as their noise asks for, with widths that end
//! before the centre of a bend.

use super::changes::{Change, ImportOptions, Imported, Side};
use super::error::{Place, TrackError};
use super::outliers::{self, Far};
use super::path::Path;
use super::points::{self, TrackPoint};
use super::smooth::{self, Smoothed, Strength};

/// Automatic smoothing moves no point further than this share of the mean width.
const MOST_MOVE: f64 = 0.15;
/// A point this share of the track's width from the line of the others is an error in the file.
const OUTLIER: f64 = 0.3;
/// Noise of up to this share of the mean width is what smoothing is for: both limits then are at least
/// this many of its standard deviations.
const NOISE: (f64, f64) = (0.1, 5.0);
/// Median of the absolute value of what [`noise`] takes from the points, in standard deviations of theirs.
const MEDIAN: f64 = 0.6745 * 2.0917;
/// Points stay where they are if smoothing would change the curvature through three neighbours by
/// no more than this share of the largest curvature.
const SAME_CURVATURE: f64 = 0.03;
/// Least share of its width that an edge keeps when the line moves towards it.
const LEAST_WIDTH: f64 = 0.1;
/// Largest share of the radius that the inner width may have: 1 - kappa e_y stays above 0.15.
const INNER: f64 = 0.85;
/// Widths beyond the largest by less than this share are not cut, so that a line that was cut
/// before stays as it is.
const ROUNDING: f64 = 1e-9;
/// Least share of a width that a cut may leave; a bend that leaves less is an error in the file.
const LEAST_CUT: f64 = 0.4;
/// A track with more than this share of the lap cut has widths that do not belong to it.
const MOST_CUT: f64 = 0.5;
/// Most points that are smoothed: one a metre of the longest circuits.
const MOST_POINTS: usize = 20_000;
/// Cuts closer than this many points are one.
const MERGE: usize = 3;

/// The track of a file's points, or everything wrong with them. `item` names point i.
pub(super) fn build(
    name: &str,
    given: &[TrackPoint],
    options: &ImportOptions,
    item: &dyn Fn(usize) -> String,
) -> Result<Imported, Vec<TrackError>> {
    let problems = points::bad_numbers(given, item);
    if !problems.is_empty() {
        return Err(problems);
    }
    let mut changes = Vec::new();
    let (mut kept, repeated) = distinct(given);
    changes.extend(repeated);
    let every = kept.len().div_ceil(MOST_POINTS);
    if every > 1 && options.smooth.is_none_or(|distance| distance > 0.0) {
        changes.push(Change::Thinned { points: kept.len(), every });
        kept = kept.into_iter().step_by(every).collect();
    }
    let own_item = |i: usize| item(kept.get(i).copied().unwrap_or(i));
    let survey: Vec<TrackPoint> = kept.iter().map(|&i| given[i]).collect();
    let noise = noise(&survey);
    let strength = match options.smooth {
        Some(distance) if distance <= 0.0 => None,
        Some(distance) => Some(Strength::Moves(distance)),
        None => Some(Strength::Automatic(most(MOST_MOVE, mean_width(&survey), noise))),
    };
    let line = match strength {
        Some(strength) if survey.len() >= points::FEWEST => {
            check_gap(&survey, item)?;
            let holes = outliers::holes(&survey, &own_item);
            if !holes.is_empty() {
                return Err(holes);
            }
            if options.smooth.is_none() {
                check_jumps(&survey, noise, &own_item)?;
            }
            let (line, change) = smoothed(&survey, strength, noise, &own_item)?;
            changes.extend(change);
            line
        }
        _ => survey,
    };
    let line = if line.len() >= points::FEWEST {
        let shape = points::bad_shape(&line, &own_item);
        if !shape.is_empty() {
            return Err(shape);
        }
        let (line, cuts) = clip(line)?;
        changes.extend(cuts);
        line
    } else {
        line
    };
    let track = points::build(name, &line, &own_item)
        .map_err(|problems| outliers::laps(&line, problems))?;
    Ok(Imported { track, changes, points: given.to_vec(), line, origin: None })
}

/// Numbers of the points that do not repeat the one before them, and what was left out. A last
/// point that repeats the first only closes the lap.
fn distinct(points: &[TrackPoint]) -> (Vec<usize>, Option<Change>) {
    let same = |a: &TrackPoint, b: &TrackPoint| distance(a, b) < points::SAME;
    let mut kept: Vec<usize> = Vec::with_capacity(points.len());
    let mut first = None;
    let (mut count, mut s) = (0, 0.0);
    for (i, p) in points.iter().enumerate() {
        match kept.last() {
            Some(&last) if same(&points[last], p) => {
                count += 1;
                first = first.or(Some(Place { s, x: p.x, y: p.y }));
            }
            Some(&last) => {
                s += distance(&points[last], p);
                kept.push(i);
            }
            None => kept.push(i),
        }
    }
    while let [first, .., last] = kept[..]
        && same(&points[first], &points[last])
    {
        kept.pop();
    }
    (kept, first.map(|first| Change::Repeated { count, first }))
}

/// Distance of two points [m]. Not hypot: its last bit depends on the platform.
pub(super) fn distance(a: &TrackPoint, b: &TrackPoint) -> f64 {
    let (x, y) = (b.x - a.x, b.y - a.y);
    (x * x + y * y).sqrt()
}

/// Mean width from edge to edge [m].
pub(super) fn mean_width(points: &[TrackPoint]) -> f64 {
    points.iter().map(|p| p.width_left + p.width_right).sum::<f64>() / points.len() as f64
}

/// Standard deviation of the points across the line, from the middle one of their fourth differences,
/// which neither bends nor single wrong points change much [m].
fn noise(survey: &[TrackPoint]) -> f64 {
    let n = survey.len();
    if n < points::FEWEST {
        return 0.0;
    }
    let across = (0..n).map(|i| {
        let [a, b, p, c, d] = [2, 1, 0, n - 1, n - 2].map(|back| &survey[(i + n - back) % n]);
        let (x, y) = (c.x - b.x, c.y - b.y);
        let fourth = |a: f64, b: f64, p: f64, c: f64, d: f64| 1.5 * p - b - c + 0.25 * (a + d);
        let (dx, dy) = (fourth(a.x, b.x, p.x, c.x, d.x), fourth(a.y, b.y, p.y, c.y, d.y));
        (x * dy - y * dx).abs() / (x * x + y * y).sqrt().max(points::SAME)
    });
    outliers::median(across) / MEDIAN
}

/// A limit of a share of the width, or more where noise asks for it [m].
fn most(share: f64, width: f64, noise: f64) -> f64 {
    let limit = share * width;
    if noise <= NOISE.0 * width { limit.max(NOISE.1 * noise) } else { limit }
}

/// What is wrong with the ends of the list.
fn check_gap(survey: &[TrackPoint], item: &dyn Fn(usize) -> String) -> Result<(), Vec<TrackError>> {
    let gap: Vec<TrackError> = points::bad_shape(survey, item)
        .into_iter()
        .filter(|problem| matches!(problem, TrackError::Gap { .. }))
        .collect();
    if gap.is_empty() { Ok(()) } else { Err(gap) }
}

/// Single points far from their neighbours. Such a point's second difference stands between two
/// of half its size in the other direction; a corner's stands alone.
fn check_jumps(
    survey: &[TrackPoint],
    noise: f64,
    item: &dyn Fn(usize) -> String,
) -> Result<(), Vec<TrackError>> {
    let n = survey.len();
    let at = |i: usize| &survey[i % n];
    let bend = |i: usize| {
        let (a, b, c) = (at(i + n - 1), at(i), at(i + 1));
        (b.x - 0.5 * (a.x + c.x), b.y - 0.5 * (a.y + c.y))
    };
    let mut wrong = Vec::new();
    for (i, p) in survey.iter().enumerate() {
        let (before, own, after) = (bend(i + n - 1), bend(i), bend(i + 1));
        let against = |other: (f64, f64)| other.0 * own.0 + other.1 * own.1;
        let square = own.0 * own.0 + own.1 * own.1;
        let (a, c) = (at(i + n - 1), at(i + 1));
        let off = ((c.x - a.x) * own.1 - (c.y - a.y) * own.0).abs() / distance(a, c);
        let limit = most(OUTLIER, p.width_left + p.width_right, noise);
        if off > limit && against(before).max(against(after)) < -0.25 * square {
            wrong.push(Far { point: i, distance: off, limit });
        }
    }
    if wrong.is_empty() { Ok(()) } else { Err(outliers::explain(survey, &wrong, item)) }
}

/// The points of a smooth line, with the edges where they were, and what was moved.
fn smoothed(
    survey: &[TrackPoint],
    strength: Strength,
    noise: f64,
    item: &dyn Fn(usize) -> String,
) -> Result<(Vec<TrackPoint>, Option<Change>), Vec<TrackError>> {
    let n = survey.len();
    let xy: Vec<(f64, f64)> = survey.iter().map(|p| (p.x, p.y)).collect();
    let smooth = smooth::smooth(&xy, strength);
    let moved: Vec<f64> = (0..n)
        .map(|i| {
            let (x, y) = smooth.point(i);
            distance(&survey[i], &TrackPoint { x, y, ..survey[i] })
        })
        .collect();
    if matches!(strength, Strength::Automatic(_)) {
        let alone = 1.0 / (1.0 - smooth.leverage).max(0.1);
        let wrong: Vec<Far> = (0..n)
            .filter_map(|i| {
                let width = survey[i].width_left + survey[i].width_right;
                let limit = most(OUTLIER, width, noise);
                let distance = alone * moved[i];
                let peak = moved[i] >= moved[(i + 1) % n] && moved[i] >= moved[(i + n - 1) % n];
                (peak && distance > limit).then_some(Far { point: i, distance, limit })
            })
            .collect();
        if !wrong.is_empty() {
            return Err(outliers::explain(survey, &wrong, item));
        }
    }
    let worst = (0..n).max_by(|&a, &b| moved[a].total_cmp(&moved[b])).unwrap_or(0);
    if matches!(strength, Strength::Automatic(_)) && is_smooth(&xy, &smooth) {
        return Ok((survey.to_vec(), None));
    }
    let change = Change::Smoothed {
        points: n,
        rms: (moved.iter().map(|d| d * d).sum::<f64>() / n as f64).sqrt(),
        largest: moved[worst],
        place: outliers::places(survey)[worst],
        noise: smooth.noise,
    };
    Ok((resampled(survey, &smooth), Some(change)))
}

/// Curvature of the circle through three points, positive to the left.
fn curvature(a: (f64, f64), b: (f64, f64), c: (f64, f64)) -> f64 {
    let (ab, bc, ac) = ((b.0 - a.0, b.1 - a.1), (c.0 - b.0, c.1 - b.1), (c.0 - a.0, c.1 - a.1));
    let square = |v: (f64, f64)| v.0 * v.0 + v.1 * v.1;
    2.0 * (ab.0 * bc.1 - ab.1 * bc.0) / (square(ab) * square(bc) * square(ac)).sqrt()
}

/// Whether points and smooth line have the same curvature everywhere: the points are samples of
/// a curve without noise.
fn is_smooth(xy: &[(f64, f64)], smooth: &Smoothed) -> bool {
    let n = xy.len();
    let near = |i: usize| [(i + n - 1) % n, i, (i + 1) % n];
    let (mut largest, mut change) = (0.0_f64, 0.0_f64);
    for i in 0..n {
        let [a, b, c] = near(i).map(|i| smooth.point(i));
        let after = curvature(a, b, c);
        let [a, b, c] = near(i).map(|i| xy[i]);
        largest = largest.max(after.abs());
        change = change.max((curvature(a, b, c) - after).abs());
    }
    change <= SAME_CURVATURE * largest
}

/// Points of the smooth line whose edges are those of the survey.
fn resampled(survey: &[TrackPoint], smooth: &Smoothed) -> Vec<TrackPoint> {
    let n = survey.len();
    let widths: Vec<(f64, f64)> = survey
        .iter()
        .enumerate()
        .map(|(i, p)| {
            let ((x, y), (dx, dy)) = (smooth.point(i), smooth.tangent(i));
            let left = (dx * (p.y - y) - dy * (p.x - x)) / (dx * dx + dy * dy).sqrt();
            let moved = |width: f64, by: f64| (width + by).max(LEAST_WIDTH * width);
            (moved(p.width_left, left), moved(p.width_right, -left))
        })
        .collect();
    smooth
        .resample()
        .into_iter()
        .map(|((x, y), i, part)| {
            let (a, b) = (widths[i], widths[(i + 1) % n]);
            let between = |a: f64, b: f64| a + part * (b - a);
            TrackPoint { x, y, width_left: between(a.0, b.0), width_right: between(a.1, b.1) }
        })
        .collect()
}

/// Largest curvature to the left and to the right around each of the points that the path was
/// made of, which lie at the distances s.
fn tightest(path: &Path, s: &[f64]) -> Vec<(f64, f64)> {
    let n = s.len();
    let mut between = vec![(0.0_f64, 0.0_f64); n];
    let mut at = 0;
    for i in 0..path.len() {
        while at + 1 < n && s[at + 1] <= path.start_of(i) {
            at += 1;
        }
        for part in [0.0, 0.5] {
            let kappa = path.kappa_in(i, part * path.length_of(i));
            between[at] = (between[at].0.max(kappa), between[at].1.max(-kappa));
        }
    }
    (0..n)
        .map(|i| {
            let (a, b) = (between[(i + n - 1) % n], between[i]);
            (a.0.max(b.0), a.1.max(b.1))
        })
        .collect()
}

/// The points with no width beyond what their bend allows, and the stretches that were cut.
fn clip(mut line: Vec<TrackPoint>) -> Result<(Vec<TrackPoint>, Vec<Change>), Vec<TrackError>> {
    let (path, widths) = points::fit(&line);
    let starts = widths.starts();
    let last = path.len() - 1;
    let length = path.start_of(last) + path.length_of(last);
    let tightest = tightest(&path, &starts);
    let mut changes = Vec::new();
    let mean = mean_width(&line);
    let mut cut = 0;
    let mut tight = None;
    for side in [Side::Left, Side::Right] {
        let mut open: Option<(usize, usize, f64, f64)> = None;
        let close = |open: Option<(usize, usize, f64, f64)>, changes: &mut Vec<Change>| {
            if let Some((first, last, before, after)) = open {
                let (from, to) = (starts[first], starts[last]);
                changes.push(Change::Clipped { side, from, to, before, after });
            }
        };
        for (i, p) in line.iter_mut().enumerate() {
            let (width, kappa) = match side {
                Side::Left => (&mut p.width_left, tightest[i].0),
                Side::Right => (&mut p.width_right, tightest[i].1),
            };
            if *width * kappa <= INNER * (1.0 + ROUNDING) {
                continue;
            }
            let (before, after) = (*width, INNER / kappa);
            if after < LEAST_CUT * before && tight.is_none() {
                let place = Place { s: starts[i], x: p.x, y: p.y };
                tight = Some(TrackError::TooTight { place, radius: 1.0 / kappa, width: before });
            }
            *width = after;
            cut += 1;
            open = match open {
                Some((first, last, b, a)) if i <= last + MERGE => {
                    let deeper = before - after > b - a;
                    let (b, a) = if deeper { (before, after) } else { (b, a) };
                    Some((first, i, b, a))
                }
                other => {
                    close(other, &mut changes);
                    Some((i, i, before, after))
                }
            };
        }
        close(open, &mut changes);
    }
    let share = cut as f64 / line.len() as f64;
    if share > MOST_CUT {
        let (share, limit) = (100.0 * share, 100.0 * MOST_CUT);
        return Err(vec![TrackError::Scale { share, length, width: mean, limit }]);
    }
    match tight {
        Some(tight) => Err(vec![tight]),
        None => Ok((line, changes)),
    }
}
