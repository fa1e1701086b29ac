//! From a solution on a coarse mesh to one that the plant confirms.

use crate::case::{A, Case, E_Y};
use crate::check;
use crate::dynamics::Mode;
use crate::error::Error;
use crate::interior_point::{self, Multipliers, Settings, Solved, Start};
use crate::interval::{Defect, NS, Node};
use crate::mesh::{self, Part};
use crate::options::SolveProgress;
use crate::problem::Problem;

/// Violation of the scaled optimality conditions at which a solution ends.
pub(crate) const TOLERANCE: f64 = 1e-5;
/// The same on meshes that are refined once more.
const ROUND_TOLERANCE: f64 = 3e-3;
/// Share of the allowed defect that is the mesh's.
const MESH_SHARE: f64 = 0.5;
/// Most rounds of refinement.
const ROUNDS: usize = 10;
/// Barrier parameter a solution on a finer mesh begins with.
const WARM_BARRIER: f64 = 1e-5;
/// Width of the band between braking and driving on the first mesh, and by which factor it falls
/// from mesh to mesh.
pub(crate) const BAND: f64 = 0.2;
const BAND_FALL: f64 = 0.25;
/// Refinements with that band; from then on every interval either drives or brakes.
const BLENDED_ROUNDS: usize = 1;

impl Case<'_> {
    /// Solves on finer meshes until fine integration agrees, then to full accuracy.
    pub(crate) fn refine(
        &self,
        mut problem: Problem,
        mut solved: Solved,
        progress: &mut impl FnMut(SolveProgress),
    ) -> Result<(Problem, Solved), Error> {
        let tolerance = MESH_SHARE * self.options.defect;
        let mut band = BAND;
        for round in 0..ROUNDS {
            let mut errors = self.errors(&problem, &solved.z);
            let worst = errors.iter().copied().fold(0.0, f64::max);
            progress(SolveProgress::Refined {
                intervals: problem.len(),
                steps: solved.steps,
                lap_time: times(&problem, &solved.z).iter().sum(),
                defect: worst,
            });
            let sure = problem.model.is_smooth() || round > BLENDED_ROUNDS;
            let accurate = solved.error <= TOLERANCE;
            if worst <= tolerance && sure {
                if !accurate {
                    solved = self.again(&problem, &solved.start(), TOLERANCE)?;
                    continue;
                }
                // The plant has limits that the program knows at the nodes only.
                for (error, off) in errors.iter_mut().zip(self.plant_errors(&problem, &solved)?) {
                    *error = error.max(scaled(&off, &problem));
                }
                if errors.iter().all(|error| *error <= self.options.defect) {
                    return Ok((problem, solved));
                }
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

    /// Deviations of the plant over each interval.
    pub(crate) fn plant_errors(
        &self,
        problem: &Problem,
        solved: &Solved,
    ) -> Result<Vec<[f64; 6]>, Error> {
        let nodes: Vec<Node> = solved.z.iter().map(|z| problem.unscaled(z)).collect();
        let times = times(problem, &solved.z);
        check::deviations(self.car, self.track, &problem.intervals, &nodes, &times)
            .map_err(Error::Car)
    }
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
pub(crate) fn times(problem: &Problem, z: &[Node]) -> Vec<f64> {
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

/// What defects are divided by: the mean speed for both velocities, the yaw rate of a car at its
/// limit of grip, 1 rad, half the width between the margins.
fn defect_units(problem: &Problem) -> Defect {
    let scale = &problem.scale;
    Defect::from([scale[0], scale[0], scale[2], 1.0, scale[E_Y]])
}

/// The largest of a deviation's entries, each divided by its unit.
pub(crate) fn scaled(off: &[f64; 6], problem: &Problem) -> f64 {
    let [v_x, v_y, omega_z, e_psi, e_y] = defect_units(problem).into();
    let units = [v_x, v_y, omega_z, e_psi, e_y, e_y];
    off.iter().zip(units).fold(0.0, |most, (off, unit)| most.max(off.abs() / unit))
}

/// Whether the car drives or brakes in part of an interval.
fn mode(problem: &Problem, solved: &Solved, part: &Part) -> Mode {
    let (here, next) = (solved.z[part.of][A], solved.z[problem.after(part.of)][A]);
    let middle = here + (next - here) * (part.begin + 0.5 * part.share);
    if middle >= 0.0 { Mode::Drive } else { Mode::Brake }
}
