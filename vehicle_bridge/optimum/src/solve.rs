//! Starts, meshes and the choice of the best lap.

use std::sync::Arc;

use vehicle_model::{CarParams, Input, ModelError, State, Track};

use crate::case::Case;
use crate::error::Error;
use crate::interior_point::{self, Settings, Solved};
use crate::interval::Node;
use crate::lap::{LapPoint, Optimum, Quality};
use crate::options::{Options, SolveProgress};
use crate::problem::Problem;
use crate::refine::{BAND, scaled, times};

/// Violation of the scaled optimality conditions at which a solution on the first mesh ends, and
/// the barrier parameter it begins with.
const START_TOLERANCE: f64 = 1e-4;
const BARRIER: f64 = 0.1;

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
    mut progress: impl FnMut(SolveProgress),
) -> Result<Optimum, Error> {
    check_options(options)?;
    let problems = car.validate();
    if !problems.is_empty() {
        return Err(Error::Car(ModelError::CarInvalid(problems)));
    }
    let case = Case::new(car, track, options);
    let first = case.first_mesh();
    let mut found: Vec<(f64, Problem, Solved)> = Vec::new();
    let mut failed = (f64::INFINITY, f64::NAN);
    for index in 0..options.starts {
        let problem = case.problem(&first, BAND)?;
        let start = case.start(&problem, index);
        let settings = Settings { tolerance: START_TOLERANCE, mu: BARRIER, steps: options.steps };
        let solved = interior_point::solve(&problem, &start, &settings);
        let time = solved.as_ref().map(|s| s.cost / problem.cost_of_time);
        let good = solved.as_ref().is_some_and(|s| s.converged);
        let steps = solved.as_ref().map_or(0, |s| s.steps);
        progress(SolveProgress::Start { index, steps, lap_time: time.filter(|_| good) });
        match (solved, time) {
            (Some(solved), Some(time)) if good => found.push((time, problem, solved)),
            (Some(solved), Some(time)) if solved.error < failed.0 => failed = (solved.error, time),
            _ => {}
        }
    }
    let converged = found.len();
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    let slowest = found.last().map_or(f64::NAN, |last| last.0);
    let mut error = Error::NotConverged {
        starts: options.starts,
        error: failed.0,
        tolerance: START_TOLERANCE,
        lap_time: failed.1,
    };
    // The best one that finer meshes and the plant confirm.
    for (_, problem, solved) in found {
        let refined = case.refine(problem, solved, &mut progress);
        match refined
            .and_then(|(problem, solved)| case.finish(&problem, &solved, (converged, slowest)))
        {
            Ok(lap) => return Ok(lap),
            Err(why) => error = why,
        }
    }
    Err(error)
}

fn check_options(options: &Options) -> Result<(), Error> {
    let wrong = |name, found: String, expected| Err(Error::Option { name, found, expected });
    if !(options.margin.is_finite() && options.margin >= 0.0) {
        return wrong("margin", options.margin.to_string(), "a distance of 0 or above");
    }
    if options.defect.is_nan() || options.defect <= 0.0 {
        return wrong("defect", options.defect.to_string(), "a number above 0");
    }
    if !(1..=Options::MOST_STARTS).contains(&options.starts) {
        return wrong("starts", options.starts.to_string(), "1 to 4");
    }
    Ok(())
}

impl Case<'_> {
    /// The lap, if the plant confirms it.
    fn finish(
        &self,
        problem: &Problem,
        solved: &Solved,
        (converged, slowest_start): (usize, f64),
    ) -> Result<Optimum, Error> {
        let nodes: Vec<Node> = solved.z.iter().map(|z| problem.unscaled(z)).collect();
        let times = times(problem, &solved.z);
        let off = self.plant_errors(problem, solved)?;
        let (mut defect, mut worst, mut place) = ([0.0_f64; 6], 0.0_f64, 0.0);
        for (interval, off) in problem.intervals.iter().zip(&off) {
            for (most, off) in defect.iter_mut().zip(off) {
                *most = most.max(off.abs());
            }
            // A deviation that is not a number must not pass.
            let off = scaled(off, problem);
            if off.is_nan() || off > worst {
                (worst, place) = (off, interval.s);
            }
        }
        if worst.is_nan() || worst > self.options.defect {
            let tolerance = self.options.defect;
            return Err(Error::Defect { defect: worst, s: place, tolerance });
        }
        let mut points: Vec<LapPoint> = Vec::with_capacity(nodes.len() + 1);
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

fn point(time: f64, s: f64, z: &Node) -> LapPoint {
    let x = State { v_x: z[0], v_y: z[1], omega_z: z[2], e_psi: z[3], s, e_y: z[4] };
    LapPoint { time, x, u: Input { a: z[5], delta: z[6] } }
}
