//! The mesh along s.

use nalgebra::SVector;
use vehicle_model::{RoadPoint, Track};

use crate::dynamics::{Dynamics, Mode};

use crate::interval::{Interval, NS, Node};

/// Share of an interval by which its ends are looked at from inside.
const INSIDE: f64 = 1e-6;
/// Runge-Kutta steps that check an interval.
const CHECKS: u32 = 8;
/// Least number of intervals.
const LEAST: f64 = 60.0;

/// Intervals of about the length that belongs to the speed limit there, whose ends include every jump of the curvature and every station.
pub(crate) fn uniform(track: &Track, length: impl Fn(f64) -> f64) -> Vec<Interval> {
    let mut ends = track.curvature_jumps();
    // Bank and slope have kinks at the places that state them, speed limits steps.
    ends.extend(track.stations().iter().map(|station| station.s));
    ends.sort_by(f64::total_cmp);
    ends.dedup_by(|b, a| *b - *a < 1e-9);
    ends.retain(|s| *s > 1e-9);
    ends.push(track.length());
    let mut places = Vec::new();
    let mut begin = 0.0;
    for end in ends {
        let limit = track.speed_limit(0.5 * (begin + end));
        let length = length(limit).min(track.length() / LEAST);
        let pieces = ((end - begin) / length).ceil().max(1.0);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a count")]
        let count = pieces as u32;
        for i in 0..count {
            places.push(begin + (end - begin) * f64::from(i) / pieces);
        }
        begin = end;
    }
    intervals(track, &places)
}

/// The intervals that begin at these places; the first is 0.
pub(crate) fn intervals(track: &Track, places: &[f64]) -> Vec<Interval> {
    let ends = places.iter().skip(1).copied().chain([track.length()]);
    let road = track.road();
    places
        .iter()
        .zip(ends)
        .map(|(&s, end)| {
            let length = end - s;
            let at = |share: f64| RoadPoint::of(&road, s + share * length);
            Interval {
                s,
                length,
                road: [at(INSIDE), at(0.5), at(1.0 - INSIDE)],
                mode: Mode::Either,
            }
        })
        .collect()
}

/// Deviation of the fine integration over an interval from its end node, per state.
pub(crate) fn deviation(
    model: &Dynamics,
    track: &Track,
    interval: &Interval,
    z: [&Node; 2],
) -> SVector<f64, NS> {
    let road = track.road();
    let at = |x: &SVector<f64, NS>, share: f64| {
        let share = share.clamp(INSIDE, 1.0 - INSIDE);
        let mut node = z[0] + (z[1] - z[0]) * share;
        node.fixed_rows_mut::<NS>(0).copy_from(x);
        let here = RoadPoint::of(&road, interval.s + share * interval.length);
        let rates = model.rates(interval.mode, &node.into(), &here);
        SVector::<f64, NS>::from_fn(|i, _| rates[i])
    };
    let h = interval.length / f64::from(CHECKS);
    let mut x = z[0].fixed_rows::<NS>(0).into_owned();
    for step in 0..CHECKS {
        let share = |part: f64| (f64::from(step) + part) / f64::from(CHECKS);
        let k1 = at(&x, share(0.0));
        let k2 = at(&(x + k1 * (0.5 * h)), share(0.5));
        let k3 = at(&(x + k2 * (0.5 * h)), share(0.5));
        let k4 = at(&(x + k3 * h), share(1.0));
        x += (k1 + (k2 + k3) * 2.0 + k4) * (h / 6.0);
    }
    x - z[1].fixed_rows::<NS>(0)
}

/// An interval of a finer mesh: which one of the coarser mesh it is part of, where in it it
/// begins, and which share of it it is.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Part {
    pub(crate) of: usize,
    pub(crate) begin: f64,
    pub(crate) share: f64,
}

/// A finer mesh: each interval is split into as many as its error asks for, the error falling
/// with the fifth power of the length.
pub(crate) fn refined(
    track: &Track,
    coarse: &[Interval],
    errors: &[f64],
    tolerance: f64,
) -> (Vec<Interval>, Vec<Part>) {
    let (mut places, mut parts) = (Vec::new(), Vec::new());
    for (of, interval) in coarse.iter().enumerate() {
        let wanted = (errors[of] / (0.3 * tolerance)).powf(0.2).ceil().clamp(1.0, 4.0);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a count")]
        let count = wanted as u32;
        for i in 0..count {
            let begin = f64::from(i) / wanted;
            places.push(interval.s + begin * interval.length);
            parts.push(Part { of, begin, share: 1.0 / wanted });
        }
    }
    (intervals(track, &places), parts)
}
