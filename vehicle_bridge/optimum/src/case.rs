//! The nonlinear program of a car on a track, and where its solution starts.

use std::sync::Arc;

use vehicle_model::params::GRAVITY;
use vehicle_model::{CarParams, Track};

use crate::dynamics::{Dynamics, Mode};
use crate::error::Error;
use crate::interior_point::Start;
use crate::interval::{Interval, Node};
use crate::mesh;
use crate::options::Options;
use crate::problem::Problem;
use crate::rules::Rules;
use crate::start;

/// Indices of e_y and a among the variables of a node.
pub(crate) const E_Y: usize = 4;
pub(crate) const A: usize = 5;
/// Largest heading error \[rad\].
const MOST_E_PSI: f64 = 1.3;
/// Cost of the squared change of the inputs over an interval; the mean cost of an interval is 1.
const COST_OF_CHANGE: f64 = 1e-4;
/// The same with speed limits: where one binds, no other input is faster than the one that is held, and
/// the inputs would ring from node to node.
const COST_OF_CHANGE_LIMITED: f64 = 3e-3;
/// Times the tyres take to build up force that an interval of the first mesh may last.
const RELAXATION_SHARE: f64 = 1.0;
/// Starts: how far the line goes to the inside of bends, as a share of the room there, and the
/// share of grip, engine and brakes that is used.
const STARTS: [(f64, f64); Options::MOST_STARTS] =
    [(0.0, 0.6), (0.6, 0.85), (0.0, 0.4), (0.3, 0.7)];
/// How near to 0, as a share of its unit, a is where braking passes into driving.
const PASSAGE: f64 = 1e-4;

/// A car on a track.
pub(crate) struct Case<'a> {
    pub(crate) car: &'a CarParams,
    pub(crate) track: &'a Arc<Track>,
    pub(crate) options: &'a Options,
    /// Least and largest input that has an effect.
    stops: [[f64; 2]; 2],
}

impl<'a> Case<'a> {
    pub(crate) fn new(car: &'a CarParams, track: &'a Arc<Track>, options: &'a Options) -> Self {
        let drive = car.drive_force_max.map_or(f64::INFINITY, |force| force / car.mass);
        let a = [-car.hardest_braking(), car.a_max.min(drive)];
        Self { car, track, options, stops: [a, [-car.delta_max, car.delta_max]] }
    }

    /// The first mesh: as long intervals as the way made while the tyres build up force, at the mean
    /// speed or the limit there.
    pub(crate) fn first_mesh(&self) -> Vec<Interval> {
        let tyre = &self.car.tyre_rear;
        let stiffness = tyre.b * tyre.c * tyre.mu * GRAVITY;
        let probe = mesh::uniform(self.track, |_| self.track.length() / 200.0);
        let v = self.mean_speed(&probe);
        mesh::uniform(self.track, |limit| {
            let v = v.min(limit).min(self.car.speed_max.unwrap_or(f64::INFINITY));
            RELAXATION_SHARE * v * v / stiffness
        })
    }

    fn mean_speed(&self, intervals: &[Interval]) -> f64 {
        let line = vec![0.0; intervals.len()];
        let nodes = start::drive(self.car, intervals, &line, 0.8, &self.stops);
        let time: f64 = intervals.iter().zip(&nodes).map(|(i, z)| i.length / z[0]).sum();
        self.track.length() / time
    }

    /// The problem of a mesh.
    pub(crate) fn problem(&self, intervals: &[Interval], band: f64) -> Result<Problem, Error> {
        let car = self.car;
        let n = intervals.len();
        let edges = self.edges(intervals)?;
        let mean = self.mean_speed(intervals);
        let grip = car.tyre_rear.mu * GRAVITY;
        let half = edges.iter().map(|e| 0.5 * (e[1] - e[0])).sum::<f64>() / n as f64;
        let scale = Node::from([
            mean,
            0.2 * mean,
            grip / mean,
            0.3,
            half.max(0.1 * car.width),
            car.a_max.max(-car.a_min),
            car.delta_max,
        ]);
        let slowest = car.blend_speed_low.max(0.02 * mean);
        let free = f64::INFINITY;
        let limits: Vec<f64> =
            intervals.iter().map(|interval| self.speed_limit(interval)).collect();
        let bounds = |side: usize| -> Vec<Node> {
            let sign = if side == 0 { -1.0 } else { 1.0 };
            edges
                .iter()
                .enumerate()
                .map(|(k, edge)| {
                    let [mut a, delta] = self.stops;
                    let passage = PASSAGE * scale[A];
                    match (intervals[(k + n - 1) % n].mode, intervals[k].mode) {
                        (Mode::Either, _) | (_, Mode::Either) => {}
                        (Mode::Drive, Mode::Drive) => a[0] = 0.0,
                        (Mode::Brake, Mode::Brake) => a[1] = 0.0,
                        _ => a = [-passage, passage],
                    }
                    let speed = if side == 0 { slowest } else { limits[k].max(1.1 * slowest) };
                    let psi = sign * MOST_E_PSI;
                    let z =
                        [speed, sign * free, sign * free, psi, edge[side], a[side], delta[side]];
                    Node::from(z).component_div(&scale)
                })
                .collect()
        };
        let time = self.track.length() / mean;
        Ok(Problem {
            model: Dynamics::new(car, band),
            intervals: intervals.to_vec(),
            rules: Rules::new(car, &self.stops),
            scale,
            lower: bounds(0),
            upper: bounds(1),
            cost_of_time: n as f64 / time,
            cost_of_change: if limits.iter().any(|limit| limit.is_finite()) {
                COST_OF_CHANGE_LIMITED
            } else {
                COST_OF_CHANGE
            },
        })
    }

    /// Highest speed at the node where an interval begins, by the track and the car \[m/s\].
    fn speed_limit(&self, interval: &Interval) -> f64 {
        let near = [-1e-6, 1e-6].map(|ds| self.track.speed_limit(interval.s + ds));
        near[0].min(near[1]).min(self.car.speed_max.unwrap_or(f64::INFINITY))
    }

    /// Right and left bound of e_y at every node.
    fn edges(&self, intervals: &[Interval]) -> Result<Vec<[f64; 2]>, Error> {
        let (track, margin) = (self.track, self.options.margin);
        intervals
            .iter()
            .map(|interval| {
                let s = interval.s;
                let near = [s - 1e-6, s, s + 1e-6];
                let least = |width: &dyn Fn(f64) -> f64| {
                    near.iter().map(|s| width(*s)).fold(f64::INFINITY, f64::min)
                };
                let left = least(&|s| track.width_left(s));
                let right = least(&|s| track.width_right(s));
                let width = left + right;
                if width <= 2.0 * margin {
                    return Err(Error::TooNarrow { s, width, margin });
                }
                Ok([margin - right, left - margin])
            })
            .collect()
    }

    /// Start number `index`.
    pub(crate) fn start(&self, problem: &Problem, index: usize) -> Start {
        let (inside, share) = STARTS[index % STARTS.len()];
        let bounds = problem.lower.iter().zip(&problem.upper);
        let edges = bounds.map(|(l, u)| [l[E_Y], u[E_Y]].map(|e| e * problem.scale[E_Y]));
        let line = start::line(&problem.intervals, &edges.collect::<Vec<_>>(), inside);
        let nodes = start::drive(self.car, &problem.intervals, &line, share, &self.stops);
        let z = nodes.iter().map(|z| z.component_div(&problem.scale)).collect();
        Start { z, multipliers: None }
    }
}
