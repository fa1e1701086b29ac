//! Starts, meshes and the choice of the best lap.

use std::sync::Arc;

use vehicle_model::{CarParams, Input, ModelError, State, Track};

use crate::check;
use crate::dynamics::{Dynamics, Mode};
use crate::error::Error;
use crate::interior_point::{self, Multipliers, Settings, Solved, Start};
use crate::interval::{Defect, Interval, NS, Node};
use crate::lap::{Optimum, Point, Quality};
use crate::mesh::{self, Part};
use crate::options::{Options, Progress};
use crate::problem::Problem;
use crate::rules::Rules;
use crate::start;

/// Violation of the scaled optimality conditions at which a solution ends.
const TOLERANCE: f64 = 1e-5;
/// The same on the first mesh, and on meshes that are refined once more.
const START_TOLERANCE: f64 = 1e-4;
const ROUND_TOLERANCE: f64 = 3e-3;
/// Share of the allowed defect that is the mesh's.
const MESH_SHARE: f64 = 0.5;
/// Barrier parameter a start begins with, and the solution on a finer mesh.
const BARRIER: f64 = 0.1;
const WARM_BARRIER: f64 = 1e-5;
/// Width of the band between braking and driving on the first mesh, and by which factor it falls from mesh to mesh.
const BAND: f64 = 0.2;
const BAND_FALL: f64 = 0.25;
/// Refinements with that band; from then on every interval either drives or brakes.
const BLENDED_ROUNDS: usize = 1;
/// How near to 0, as a share of its unit, a is where braking passes into driving.
const PASSAGE: f64 = 1e-4;
/// Indices of e_y and a among the variables of a node.
const E_Y: usize = 4;
const A: usize = 5;
/// Largest heading error \[rad\].
const MOST_E_PSI: f64 = 1.3;
/// Cost of the squared change of the inputs over an interval; the mean cost of an interval is 1.
const COST_OF_CHANGE: f64 = 1e-4;
/// Time the tyres take to build up force that an interval of the first mesh may last.
const RELAXATION_SHARE: f64 = 1.0;
/// Most rounds of refinement.
const ROUNDS: usize = 8;

/// The time-optimal lap of a car on a track.
///
/// # Errors
/// [`Error::TooNarrow`] where the margins leave no room, [`Error::Option`] and [`Error::Car`] for
/// values out of range, [`Error::NotConverged`] and [`Error::Defect`] if no lap was found that
/// fulfils the optimality conditions and is confirmed by the plant.
pub fn solve(car: &CarParams, track: &Arc<Track>, options: &Options) -> Result<Optimum, Error> {
    solve_with_progress(car, track, options, |_| {})
}

/// [`solve`], giving word of each part that is done.
///
/// # Errors
/// Those of [`solve`].
pub fn solve_with_progress(
    car: &CarParams,
    track: &Arc<Track>,
    options: &Options,
    mut progress: impl FnMut(Progress),
) -> Result<Optimum, Error> {
    check_options(options)?;
    let problems = car.validate();
    if !problems.is_empty() {
        return Err(Error::Car(ModelError::CarInvalid(problems)));
    }
    let case = Case::new(car, track, options);
    let first = mesh::uniform(track, case.first_length());
    let mut best: Option<(Problem, Solved)> = None;
    let (mut converged, mut slowest) = (0, 0.0_f64);
    let mut failed = (f64::INFINITY, f64::NAN);
    for index in 0..options.starts {
        let problem = case.problem(&first, BAND)?;
        let start = case.start(&problem, index);
        let settings = Settings { tolerance: START_TOLERANCE, mu: BARRIER, steps: options.steps };
        let solved = interior_point::solve(&problem, &start, &settings);
        let time = solved.as_ref().map(|s| s.cost / problem.cost_of_time);
        let good = solved.as_ref().is_some_and(|s| s.converged);
        let steps = solved.as_ref().map_or(0, |s| s.steps);
        progress(Progress::Start { index, steps, lap_time: time.filter(|_| good) });
        let (Some(solved), Some(time)) = (solved, time) else { continue };
        if !good {
            if solved.error < failed.0 {
                failed = (solved.error, time);
            }
            continue;
        }
        converged += 1;
        slowest = slowest.max(time);
        if best.as_ref().is_none_or(|(p, b)| time < b.cost / p.cost_of_time) {
            best = Some((problem, solved));
        }
    }
    let Some((problem, solved)) = best else {
        return Err(Error::NotConverged {
            starts: options.starts,
            error: failed.0,
            tolerance: TOLERANCE,
            lap_time: failed.1,
        });
    };
    let (problem, solved) = case.refine(problem, solved, &mut progress)?;
    case.finish(&problem, &solved, (converged, slowest))
}

fn check_options(options: &Options) -> Result<(), Error> {
    let wrong = |name, found: String, expected| Err(Error::Option { name, found, expected });
    if !(options.margin.is_finite() && options.margin >= 0.0) {
        return wrong("margin", options.margin.to_string(), "a distance of 0 or above");
    }
    if !(options.defect > 0.0) {
        return wrong("defect", options.defect.to_string(), "a number above 0");
    }
    if !(1..=Options::MOST_STARTS).contains(&options.starts) {
        return wrong("starts", options.starts.to_string(), "1 to 4");
    }
    Ok(())
}

/// A car on a track.
struct Case<'a> {
    car: &'a CarParams,
    track: &'a Arc<Track>,
    options: &'a Options,
    /// Least and largest input that has an effect.
    stops: [[f64; 2]; 2],
}

impl<'a> Case<'a> {
    fn new(car: &'a CarParams, track: &'a Arc<Track>, options: &'a Options) -> Self {
        let drive = car.drive_force_max.map_or(f64::INFINITY, |force| force / car.mass);
        let brake = car.brake_force_max.map_or(f64::INFINITY, |force| force / car.mass);
        let a = [car.a_min.max(-brake), car.a_max.min(drive)];
        Self { car, track, options, stops: [a, [-car.delta_max, car.delta_max]] }
    }

    /// Length of the intervals of the first mesh: the way made while the tyres build up force.
    fn first_length(&self) -> f64 {
        let tyre = &self.car.tyre_rear;
        let stiffness = tyre.b * tyre.c * tyre.mu * vehicle_model::params::GRAVITY;
        let probe = mesh::uniform(self.track, self.track.length() / 200.0);
        let v = self.mean_speed(&probe);
        RELAXATION_SHARE * v * v / stiffness
    }

    fn mean_speed(&self, intervals: &[Interval]) -> f64 {
        let line = vec![0.0; intervals.len()];
        let nodes = start::drive(self.car, intervals, &line, 0.8, &self.stops);
        let time: f64 = intervals.iter().zip(&nodes).map(|(i, z)| i.length / z[0]).sum();
        self.track.length() / time
    }

    /// The problem of a mesh.
    fn problem(&self, intervals: &[Interval], band: f64) -> Result<Problem, Error> {
        let car = self.car;
        let n = intervals.len();
        let edges = self.edges(intervals)?;
        let mean = self.mean_speed(intervals);
        let grip = car.tyre_rear.mu * vehicle_model::params::GRAVITY;
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
        let bounds = |side: usize| -> Vec<Node> {
            let sign = if side == 0 { -1.0 } else { 1.0 };
            let speed = if side == 0 { slowest } else { free };
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
            cost_of_change: COST_OF_CHANGE,
        })
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
    fn start(&self, problem: &Problem, index: usize) -> Start {
        let share = [0.6, 0.85, 0.4, 0.7][index % Options::MOST_STARTS];
        let bounds = problem.lower.iter().zip(&problem.upper);
        let middle: Vec<f64> =
            bounds.map(|(l, u)| 0.0_f64.clamp(l[E_Y], u[E_Y]) * problem.scale[E_Y]).collect();
        let nodes = start::drive(self.car, &problem.intervals, &middle, share, &self.stops);
        let z = nodes.iter().map(|z| z.component_div(&problem.scale)).collect();
        Start { z, multipliers: None }
    }

    /// Solves on finer meshes until fine integration agrees, then to full accuracy.
    fn refine(
        &self,
        mut problem: Problem,
        mut solved: Solved,
        progress: &mut impl FnMut(Progress),
    ) -> Result<(Problem, Solved), Error> {
        let tolerance = MESH_SHARE * self.options.defect;
        let mut band = BAND;
        for round in 0..ROUNDS {
            let errors = self.errors(&problem, &solved.z);
            let worst = errors.iter().copied().fold(0.0, f64::max);
            progress(Progress::Refined {
                intervals: problem.len(),
                steps: solved.steps,
                lap_time: times(&problem, &solved.z).iter().sum(),
                defect: worst,
            });
            let sure = problem.model.is_smooth() || round > BLENDED_ROUNDS;
            let accurate = solved.error <= TOLERANCE;
            if worst <= tolerance && sure {
                if accurate {
                    return Ok((problem, solved));
                }
                solved = self.again(&problem, &solved.start(), TOLERANCE)?;
                continue;
            }
            band *= BAND_FALL;
            let (mut fine, parts) =
                mesh::refined(self.track, &problem.intervals, &errors, tolerance);
            if fine.len() > self.options.intervals {
                break;
            }
            if !problem.model.is_smooth() && round >= BLENDED_ROUNDS {
                for (interval, part) in fine.iter_mut().zip(&parts) {
                    interval.mode = mode(&problem, &solved, part);
                }
            }
            let next = self.problem(&fine, band)?;
            let start = between(&problem, &solved, &next, &parts);
            let goal = if round <= BLENDED_ROUNDS { ROUND_TOLERANCE } else { TOLERANCE };
            solved = self.again(&next, &start, goal)?;
            problem = next;
        }
        if solved.error > TOLERANCE {
            solved = self.again(&problem, &solved.start(), TOLERANCE)?;
        }
        Ok((problem, solved))
    }

    /// Solves from near the solution.
    fn again(&self, problem: &Problem, start: &Start, tolerance: f64) -> Result<Solved, Error> {
        let settings = Settings { tolerance, mu: WARM_BARRIER, steps: self.options.steps };
        let failed =
            |error, lap_time| Error::NotConverged { starts: 1, error, tolerance, lap_time };
        match interior_point::solve(problem, start, &settings) {
            Some(solved) if solved.converged => Ok(solved),
            Some(solved) => Err(failed(solved.error, solved.cost / problem.cost_of_time)),
            None => Err(failed(f64::INFINITY, f64::NAN)),
        }
    }

    /// Scaled deviation of fine integration over each interval.
    fn errors(&self, problem: &Problem, z: &[Node]) -> Vec<f64> {
        let nodes: Vec<Node> = z.iter().map(|z| problem.unscaled(z)).collect();
        (0..problem.len())
            .map(|k| {
                let ends = [&nodes[k], &nodes[problem.after(k)]];
                let interval = &problem.intervals[k];
                let off = mesh::deviation(&problem.model, self.track, interval, ends);
                off.component_div(&defect_units(problem)).amax()
            })
            .collect()
    }

    /// The lap, if the plant confirms it.
    fn finish(
        &self,
        problem: &Problem,
        solved: &Solved,
        (converged, slowest_start): (usize, f64),
    ) -> Result<Optimum, Error> {
        let nodes: Vec<Node> = solved.z.iter().map(|z| problem.unscaled(z)).collect();
        let times = times(problem, &solved.z);
        let off = check::deviations(self.car, self.track, &problem.intervals, &nodes, &times)
            .map_err(Error::Car)?;
        let [v_x, v_y, omega_z, e_psi, e_y] = defect_units(problem).into();
        let scales = [v_x, v_y, omega_z, e_psi, e_y, e_y];
        let (mut defect, mut worst, mut place) = ([0.0_f64; 6], 0.0_f64, 0.0);
        for (interval, off) in problem.intervals.iter().zip(&off) {
            for i in 0..6 {
                defect[i] = defect[i].max(off[i].abs());
                if off[i].abs() / scales[i] > worst {
                    (worst, place) = (off[i].abs() / scales[i], interval.s);
                }
            }
        }
        if !(worst <= self.options.defect) {
            let tolerance = self.options.defect;
            return Err(Error::Defect { defect: worst, s: place, tolerance });
        }
        let mut points: Vec<Point> = Vec::with_capacity(nodes.len() + 1);
        let mut time = 0.0;
        for (k, z) in nodes.iter().enumerate() {
            points.push(point(time, problem.intervals[k].s, z));
            time += times[k];
        }
        points.push(point(time, self.track.length(), &nodes[0]));
        let quality = Quality {
            defect,
            scaled_defect: worst,
            optimality: solved.error,
            intervals: problem.len(),
            converged,
            starts: self.options.starts,
            slowest_start,
        };
        Ok(Optimum { lap_time: time, points, quality })
    }
}

/// What defects are divided by: the mean speed for both velocities, the yaw rate of a car at its
/// limit of grip, 1 rad, half the width between the margins.
fn defect_units(problem: &Problem) -> Defect {
    let scale = &problem.scale;
    Defect::from([scale[0], scale[0], scale[2], 1.0, scale[E_Y]])
}

/// Whether the car drives or brakes in part of an interval.
fn mode(problem: &Problem, solved: &Solved, part: &Part) -> Mode {
    let (here, next) = (solved.z[part.of][A], solved.z[problem.after(part.of)][A]);
    let middle = here + (next - here) * (part.begin + 0.5 * part.share);
    if middle >= 0.0 { Mode::Drive } else { Mode::Brake }
}

/// A solution taken over to a finer mesh.
fn between(coarse: &Problem, solved: &Solved, fine: &Problem, parts: &[Part]) -> Start {
    let known = &solved.multipliers;
    let cost = fine.cost_of_time / coarse.cost_of_time;
    let rules = fine.rules.len();
    let unit = coarse.scale.component_div(&fine.scale);
    let states = unit.fixed_rows::<NS>(0).into_owned();
    let at = |nodes: &[Node], part: &Part| {
        let (here, next) = (&nodes[part.of], &nodes[coarse.after(part.of)]);
        here + (next - here) * part.begin
    };
    let density =
        |nodes: &[Node], part: &Part| at(nodes, part).component_div(&unit) * (cost * part.share);
    let nodes: Vec<Node> = solved.z.iter().map(|z| coarse.unscaled(z)).collect();
    let state = |part: &Part| {
        let ends = [&nodes[part.of], &nodes[coarse.after(part.of)]];
        let interval = &coarse.intervals[part.of];
        interval.between(&coarse.model, ends, part.begin).component_div(&fine.scale)
    };
    let lambda = |part: &Part| known.lambda[part.of].component_div(&states) * cost;
    let y = |part: &Part| {
        let own = known.y[part.of * rules..(part.of + 1) * rules].iter();
        own.map(|y| y * cost).collect::<Vec<f64>>()
    };
    Start {
        z: parts.iter().map(state).collect(),
        multipliers: Some(Multipliers {
            lambda: parts.iter().map(lambda).collect(),
            y: parts.iter().flat_map(y).collect(),
            on_lower: parts.iter().map(|part| density(&known.on_lower, part)).collect(),
            on_upper: parts.iter().map(|part| density(&known.on_upper, part)).collect(),
        }),
    }
}

/// Time of every interval.
fn times(problem: &Problem, z: &[Node]) -> Vec<f64> {
    let nodes: Vec<Node> = z.iter().map(|z| problem.unscaled(z)).collect();
    problem
        .intervals
        .iter()
        .enumerate()
        .map(|(k, interval)| {
            let ends = [&nodes[k], &nodes[problem.after(k)]];
            interval.values(&problem.model, ends).map_or(f64::NAN, |values| values.time)
        })
        .collect()
}

fn point(time: f64, s: f64, z: &Node) -> Point {
    let x = State { v_x: z[0], v_y: z[1], omega_z: z[2], e_psi: z[3], s, e_y: z[4] };
    Point { time, x, u: Input { a: z[5], delta: z[6] } }
}
