//! Local safe set and cost-to-go (paper, SS^j and Q^j): K samples of each of P laps, nearest in s
//! to the predicted terminal state.
//!
//! A lap is seen together with the end of the lap before it and the start of the lap that
//! followed, as driven: before its line the cost-to-go grows past T_i, behind its line it is
//! 0, -1, -2, ... The set is taken in the frame of the lap that the query lies in, so that nothing
//! jumps when the car itself crosses the line.

use nalgebra::{Vector2, Vector6};

use super::dataset::{Dataset, Seen};

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
}

impl SafeSet {
    /// Fills the set around `s_query` with `neighbors` points from each of `count` laps; if
    /// fewer than `count` laps are selected they are repeated. Empty if there is none.
    pub(crate) fn fill(
        &mut self,
        data: &Dataset,
        selected: &[usize],
        query: &Query,
        (neighbors, count): (usize, usize),
    ) {
        self.points.clear();
        self.cost_to_go.clear();
        self.inputs.clear();
        self.successor_s.clear();
        if selected.is_empty() {
            return;
        }
        // The query may lie laps ahead of the frame it is given in, by at most one in practice.
        let laps_ahead = (query.s / query.length).floor() * query.length;
        let local = Query { s: query.s - laps_ahead, ..*query };
        for i in 0..count {
            self.take_from(data, selected[i % selected.len()], &local, neighbors, laps_ahead);
        }
        let least = self.cost_to_go.iter().copied().fold(f64::INFINITY, f64::min);
        for cost in &mut self.cost_to_go {
            *cost -= least;
        }
    }

    /// Takes the samples nearest to the query's s from one lap, both ways from the nearest.
    fn take_from(
        &mut self,
        data: &Dataset,
        lap: usize,
        query: &Query,
        neighbors: usize,
        shift: f64,
    ) {
        let see = |index: isize| data.seen_from(lap, index, query.length);
        let distance = |seen: &Seen| (seen.sample.x.s + seen.offset - query.s).abs();
        let own = &data.laps[lap].samples;
        // partition_point is at most the number of samples, which fits isize.
        let mut above = own.partition_point(|sample| sample.x.s < query.s) as isize;
        let mut below = above - 1;
        for _ in 0..neighbors {
            let index = match (see(below), see(above)) {
                (Some(b), Some(a)) if distance(&b) <= distance(&a) => below,
                (_, Some(_)) => above,
                (Some(_), None) => below,
                // A lap with too few samples: its last point again keeps the size.
                (None, None) => below + 1,
            };
            if index == below {
                below -= 1;
            } else {
                above = above.max(index + 1);
            }
            let Some(seen) = see(index) else { continue };
            let s = seen.sample.x.s + seen.offset + shift;
            let successor = see(index + 1)
                .map_or(s + seen.sample.x.v_x * query.period, |n| n.sample.x.s + n.offset + shift);
            let mut point = seen.sample.x.to_vector();
            point[4] = s;
            self.points.push(point);
            self.cost_to_go.push(data.laps[lap].cost_to_go(seen.sample.time, query.period));
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
}
