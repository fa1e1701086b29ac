//! Local safe set X^j and its cost-to-go T^i - k, (3) of the paper: K samples of each of P laps, nearest in s to
//! the predicted terminal state.
//!
//! ```text
//! X^j = [x_k^i]   P laps i, in each the K samples k with the least |s_k^i - s_q|       (3), with D = diag(0, 0, 0, 0, 1, 0)
//! ```
//!
//! A lap is seen together with the end of the lap before it and the start of the lap that
//! followed, as driven. The set is taken in the frame of the lap that the query lies in, so that
//! nothing jumps when the car itself crosses the line. The cost-to-go of a point of lap i at the time t is
//!
//! ```text
//! J = T_i - k, the periods from t to the end of lap i; negative behind it          cost_to_go = "line"
//! J = (t_{i+1}(s_q) - t) / dt                                                      cost_to_go = "round"
//! ```
//!
//! with the time t_{i+1}(s_q) at which the car came to the query's place in the lap that followed; where it is
//! still on the way there, the round that it has just driven, from its present place in the last lap, counts
//! instead. With "round" the laps are compared by the time of that round, and the last one counts from its line
//! on. With "line" the set falls back by one lap where the
//! query crosses the line, and the laps that cost the same before it differ by their lap times behind it.

use nalgebra::{Vector2, Vector6};

use super::dataset::{Dataset, Lap, Seen};
use crate::config::{CostToGo, SafeSetConfig, Selection};

/// The safe-set points around a query.
#[derive(Debug, Clone, Default)]
pub struct SafeSet {
    /// The points, columns of X, with s in the frame of the query.
    pub points: Vec<Vector6<f64>>,
    /// Cost-to-go J of each point, in steps, least first subtracted.
    pub cost_to_go: Vec<f64>,
    /// Input applied at each point.
    pub(crate) inputs: Vec<Vector2<f64>>,
    /// s of each point's successor.
    pub(crate) successor_s: Vec<f64>,
    /// The laps they are taken from, best first.
    laps: Vec<Source>,
}

/// A lap that points are taken from.
#[derive(Debug, Clone, Copy)]
struct Source {
    lap: usize,
    /// Time of its round \[s\].
    round: f64,
    /// The time that the cost-to-go counts to \[s\].
    until: f64,
}

impl SafeSet {
    /// Fills the set around the query with K points from each of P laps. With fewer than P laps some give their
    /// points several times. `selected` has the best of the laps learned from; if it is empty, so is the set.
    pub(crate) fn fill(
        &mut self,
        data: &Dataset,
        selected: &[usize],
        query: &Query,
        config: &SafeSetConfig,
    ) {
        self.points.clear();
        self.cost_to_go.clear();
        self.inputs.clear();
        self.successor_s.clear();
        if selected.is_empty() {
            return;
        }
        // The query may lie laps ahead of the frame it is given in, by at most one in practice.
        let ahead = (query.s / query.length).floor();
        let local = Query { s: query.s - ahead * query.length, ..*query };
        self.choose_laps(data, selected, (&local, ahead as usize), config);
        for i in 0..config.laps {
            let source = self.laps[i % self.laps.len()];
            self.take_from(data, source, &local, config.neighbors, ahead * query.length);
        }
        let least = self.cost_to_go.iter().copied().fold(f64::INFINITY, f64::min);
        for cost in &mut self.cost_to_go {
            *cost -= least;
        }
    }

    /// The laps to take points from; the query's lap lies `ahead` of the one in progress.
    fn choose_laps(
        &mut self,
        data: &Dataset,
        selected: &[usize],
        (query, ahead): (&Query, usize),
        config: &SafeSetConfig,
    ) {
        self.laps.clear();
        if config.cost_to_go == CostToGo::Line {
            let source = |&lap: &usize| {
                let Lap { result, end_time, .. } = &*data.laps[lap];
                Source { lap, round: result.lap_time, until: *end_time }
            };
            self.laps.extend(selected.iter().map(source));
            return;
        }
        let now = data.laps.len() + ahead.min(1);
        let source = |lap: usize| {
            let here = data.passing(lap, query.s, query.length);
            let until = query.next_passing(data, (lap, here), now);
            Source { lap, round: until - here, until }
        };
        self.laps.extend(selected.iter().map(|&lap| source(lap)));
        self.laps.extend((query.learned..now).filter(|&lap| data.fit(lap)).map(source));
        self.laps.sort_unstable_by(|a, b| match config.selection {
            Selection::Fastest => a.round.total_cmp(&b.round).then(b.lap.cmp(&a.lap)),
            Selection::Recent => b.lap.cmp(&a.lap),
        });
        self.laps.truncate(config.laps);
    }

    /// Takes the samples nearest to the query's s from one lap, both ways from the nearest.
    fn take_from(
        &mut self,
        data: &Dataset,
        Source { lap, until, .. }: Source,
        query: &Query,
        neighbors: usize,
        shift: f64,
    ) {
        let see = |index: isize| data.seen_from(lap, index, query.length);
        let distance = |seen: &Seen| (seen.sample.x.s + seen.offset - query.s).abs();
        let (own, _) = data.driven(lap);
        // partition_point is at most the number of samples, which fits isize.
        let mut above = own.partition_point(|sample| sample.x.s < query.s) as isize;
        let mut below = above - 1;
        for _ in 0..neighbors {
            let (index, seen) = match (see(below), see(above)) {
                (Some(b), Some(a)) if distance(&b) <= distance(&a) => (below, Some(b)),
                (_, Some(a)) => (above, Some(a)),
                (Some(b), None) => (below, Some(b)),
                // A lap with too few samples: its last point again keeps the size.
                (None, None) => (below + 1, see(below + 1)),
            };
            if index == below {
                below -= 1;
            } else {
                above = above.max(index + 1);
            }
            let Some(seen) = seen else { continue };
            let s = seen.sample.x.s + seen.offset + shift;
            let successor = see(index + 1)
                .map_or(s + seen.sample.x.v_x * query.period, |n| n.sample.x.s + n.offset + shift);
            let mut point = seen.sample.x.to_vector();
            point[4] = s;
            self.points.push(point);
            self.cost_to_go.push((until - seen.sample.time) / query.period);
            self.inputs.push(seen.sample.u.to_vector());
            self.successor_s.push(successor);
        }
    }

    /// Slows the points down to a speed at their place, on the same path: yaw rate in proportion, slip with the
    /// square of the speed, the course as it was; time passes in inverse proportion. `l_r` is the
    /// distance of the rear axle from the centre of gravity \[m\].
    pub(crate) fn slow_down(&mut self, speed: impl Fn(f64) -> f64, l_r: f64) {
        for (i, x) in self.points.iter_mut().enumerate() {
            let (v_x, v_y, omega_z) = (x[0], x[1], x[2]);
            let speed = speed(x[4]);
            let r = speed / v_x;
            if r.is_nan() || r <= 0.0 || r >= 1.0 {
                continue;
            }
            let slip = (l_r * omega_z - v_y) / v_x;
            x[0] = speed;
            x[2] = r * omega_z;
            x[1] = l_r * x[2] - r * r * slip * speed;
            x[3] += v_y / v_x - x[1] / speed;
            self.successor_s[i] = x[4] + r * (self.successor_s[i] - x[4]);
            self.cost_to_go[i] /= r;
        }
        let least = self.cost_to_go.iter().copied().fold(f64::INFINITY, f64::min);
        for cost in &mut self.cost_to_go {
            *cost -= least;
        }
    }

    /// Moves the frame by one lap as the car crosses the line.
    pub(crate) fn cross_line(&mut self, length: f64) {
        for point in &mut self.points {
            point[4] -= length;
        }
        for s in &mut self.successor_s {
            *s -= length;
        }
    }

    /// Where the terminal state goes in one step: the successors of the points, times lambda.
    pub(crate) fn successor(&self, lambda: &[f64]) -> f64 {
        self.successor_s.iter().zip(lambda).map(|(s, l)| s * l).sum()
    }

    /// How far the points move on in one step, in the mean \[m\].
    pub(crate) fn advance(&self) -> f64 {
        let moved = self.successor_s.iter().zip(&self.points).map(|(s, point)| s - point[4]);
        moved.sum::<f64>() / self.points.len() as f64
    }

    /// Input at the terminal state: that of the points, times lambda.
    pub(crate) fn input(&self, lambda: &[f64]) -> Vector2<f64> {
        self.inputs.iter().zip(lambda).map(|(u, l)| u * *l).sum()
    }
}

/// Where and in which track the safe set is asked for.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Query {
    /// Progress of the predicted terminal state; past the line it exceeds L [m].
    pub(crate) s: f64,
    /// Length L of the track [m].
    pub(crate) length: f64,
    /// Sampling period [s].
    pub(crate) period: f64,
    /// Number of laps that the selected ones were selected from.
    pub(crate) learned: usize,
}

impl Query {
    /// When the car came to the place in the lap after `lap`, which passed it at `here`; the place lies in lap
    /// `now`. Where it did not come there yet, it is taken to need as long as for the round just driven; a lap
    /// that led to nothing of use is taken to repeat itself \[s\].
    fn next_passing(&self, data: &Dataset, (lap, here): (usize, f64), now: usize) -> f64 {
        let next = lap + 1;
        if next < now && data.driven(next).1 && data.fit(next) {
            return data.passing(next, self.s, self.length);
        }
        let own = || data.laps.get(lap).map(|lap| lap.result.lap_time);
        let open = (next >= data.laps.len()).then(|| data.last_round(self.length)).flatten();
        here + open.or_else(own).unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use vehicle_model::{Input, State};

    use super::*;
    use crate::lap_number::LapNumber;
    use crate::learning::dataset::Sample;
    use crate::status::LapKind;

    const LENGTH: f64 = 10.0;
    const PERIOD: f64 = 0.1;
    /// Speeds of the laps, the last one in progress \[m/s\].
    const SPEEDS: [f64; 4] = [1.0, 1.3, 1.7, 2.1];

    /// How far the lap in progress got \[m\].
    const DRIVEN: f64 = 5.0;

    /// Laps at these speeds without a stop.
    fn laps() -> Dataset {
        let mut data = Dataset::default();
        (data.current.from_line, data.current.clean) = (true, true);
        let (mut s, mut time) = (0.05, 0.05);
        for (lap, v_x) in SPEEDS.into_iter().enumerate() {
            let end = if lap + 1 < SPEEDS.len() { LENGTH } else { DRIVEN };
            while s < end {
                let x = State { v_x, s, ..State::default() };
                let next = Some([v_x, 0.0, 0.0]);
                data.current.samples.push(Sample { time, x, u: Input::default(), next });
                (s, time) = (s + PERIOD * v_x, time + PERIOD);
            }
            if lap + 1 < SPEEDS.len() {
                let end = time - (s - LENGTH) / v_x;
                data.close(LapNumber::default(), LapKind::Learning, end).unwrap();
                s -= LENGTH;
            }
        }
        data
    }

    fn filled(s: f64, cost_to_go: CostToGo) -> SafeSet {
        let data = laps();
        let selection = Selection::Fastest;
        let config = SafeSetConfig { neighbors: 4, laps: 2, selection, cost_to_go };
        let query = Query { s, length: LENGTH, period: PERIOD, learned: 3 };
        let mut set = SafeSet::default();
        set.fill(&data, &[2, 1], &query, &config);
        set
    }

    /// The lap in progress counts as far as it got, from the line on; closed ones all the way round.
    #[test]
    fn speeds_since_a_lap_are_those_of_the_laps_that_passed_there() {
        let data = laps();
        for (first, s, expected) in [(3, 2.0, 2.1), (3, 6.0, 0.0), (2, 6.0, 1.7), (0, 2.0, 2.1)] {
            let found = data.speed_since(first, s, LENGTH);
            assert!((found - expected).abs() < 0.03, "since {first} at {s} m: {found}");
        }
        let at_line =
            [(3, 1e-6), (2, LENGTH - 1e-6)].map(|(lap, s)| data.speed_since(lap, s, LENGTH));
        assert!((at_line[0] - at_line[1]).abs() < 1e-3, "{at_line:?}");
        assert!(at_line[0] > 1.7 && at_line[0] < 2.1, "{at_line:?}");
    }

    #[test]
    fn to_the_line_the_cost_counts_the_periods_to_the_end_of_the_lap() {
        let set = filled(8.0, CostToGo::Line);
        for (point, cost) in set.points.iter().zip(&set.cost_to_go) {
            // Two of a lap's four points lie behind the query's place: the least cost is that of the fastest
            // lap's farthest point.
            let periods = (LENGTH - point[4]) / point[0] / PERIOD;
            let farthest = set.points.iter().map(|p| (LENGTH - p[4]) / p[0]).fold(9.0, f64::min);
            assert!((cost - (periods - farthest / PERIOD)).abs() < 1e-9, "{point:?} {cost}");
        }
    }

    #[test]
    fn round_the_cost_counts_the_periods_to_the_same_place_one_lap_later() {
        let s = 8.0;
        let set = filled(s, CostToGo::Round);
        let least = set.cost_to_go.iter().copied().fold(f64::INFINITY, f64::min);
        assert_eq!(least, 0.0);
        let driven = laps().current.samples.last().unwrap().x.s;
        let cost = |point: &Vector6<f64>| {
            let lap = SPEEDS.iter().position(|v| *v == point[0]).unwrap();
            let ahead_of_place = (s - point[4]) / SPEEDS[lap];
            let round = |from: f64| (LENGTH - from) / SPEEDS[lap] + from / SPEEDS[lap + 1];
            // The last closed lap has not led there yet: the round just driven counts.
            let round = if lap == 2 { round(driven) } else { round(s) };
            (ahead_of_place + round) / PERIOD
        };
        let best = set.points.iter().map(cost).fold(f64::INFINITY, f64::min);
        for (point, found) in set.points.iter().zip(&set.cost_to_go) {
            assert!((found - (cost(point) - best)).abs() < 0.03, "{point:?} {found}");
        }
    }

    #[test]
    fn nothing_changes_where_the_query_crosses_the_line() {
        let sets = [-1e-6, 1e-6].map(|d| {
            let set = filled(LENGTH + d, CostToGo::Round);
            let mut points: Vec<_> = set.points.into_iter().zip(set.cost_to_go).collect();
            points.sort_by(|(a, _), (b, _)| a[4].total_cmp(&b[4]).then(a[0].total_cmp(&b[0])));
            points
        });
        let [before, behind] = &sets;
        for ((a, cost_a), (b, cost_b)) in before.iter().zip(behind) {
            assert!((a - b).norm() < 1e-9, "{a} {b}");
            assert!((cost_a - cost_b).abs() < 1e-3, "{cost_a} {cost_b}");
        }
        // With the cost to the line the newest points are not there any more.
        let [before, behind] = [-1e-6, 1e-6].map(|d| filled(LENGTH + d, CostToGo::Line));
        let fastest = |set: &SafeSet| set.points.iter().map(|p| p[0]).fold(0.0, f64::max);
        assert!(fastest(&before) > fastest(&behind) + 0.1);
    }
}
