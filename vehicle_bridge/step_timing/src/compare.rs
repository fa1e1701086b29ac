//! Given problems, solved by the structured solver and by Clarabel: is it solved, to the same optimum, how
//! fast.

use std::fmt::Write as _;
use std::time::Instant;

use controller::fhocp::{ClarabelSolver, Fhocp, FhocpSolver, RiccatiSolver, Solution, Termination};
use controller::{Config, SolveStatus};
use serde::Serialize;

use super::samples::quantiles;

/// Solves of each problem; the least time counts.
const REPEATS: usize = 5;
/// Tolerance of the optimum that is compared with.
const EXACT: f64 = 1e-10;

/// What became of one problem.
#[derive(Debug, Clone, Serialize)]
pub struct Compared {
    /// Name of the problem.
    pub name: String,
    /// Horizon N.
    pub horizon: usize,
    /// Safe-set points.
    pub points: usize,
    /// How the structured solver ended.
    pub status: SolveStatus,
    /// Its iterations.
    pub iterations: u32,
    /// Its least time \[us\].
    pub time_us: f64,
    /// Cost of its solution, in steps.
    pub cost: f64,
    /// Its first input, [m/s^2, rad].
    pub u_0: [f64; 2],
    /// How Clarabel at 1e-10 ended.
    pub clarabel_status: SolveStatus,
    /// Least time of Clarabel with the tolerance of the structured solver, memory and settings as the
    /// controller uses it \[us\].
    pub clarabel_time_us: f64,
    /// Cost of its solution at 1e-10.
    pub clarabel_cost: f64,
    /// Its first input.
    pub clarabel_u_0: [f64; 2],
    /// Difference of the costs, relative to the cost or to one step if that is more.
    pub cost_difference: f64,
    /// Greatest difference of the first inputs.
    pub u_0_difference: f64,
}

/// Solves the problems as the shipped configuration does, each with both solvers.
#[must_use]
pub fn compare(problems: &[(String, Fhocp)]) -> Vec<Compared> {
    let termination = Config::default().solver.termination();
    let clarabel = |tolerance| Termination { tolerance, max_iterations: 200 };
    let mut structured = RiccatiSolver::new(termination);
    let mut tuned = ClarabelSolver::new(clarabel(termination.tolerance));
    let mut exact = ClarabelSolver::reference(clarabel(EXACT));
    let rows = problems.iter().map(|(name, problem)| {
        let (horizon, points) = (problem.horizon(), problem.hull.len());
        let (mut ours, mut theirs) =
            (Solution::new(horizon, points), Solution::new(horizon, points));
        let mut least = [f64::INFINITY; 2];
        for _ in 0..REPEATS {
            for (i, least) in least.iter_mut().enumerate() {
                let begun = Instant::now();
                if i == 0 {
                    structured.solve(problem, &mut ours);
                } else {
                    tuned.solve(problem, &mut theirs);
                }
                *least = least.min(begun.elapsed().as_secs_f64() * 1e6);
            }
        }
        let report = structured.solve(problem, &mut ours);
        let known = exact.solve(problem, &mut theirs);
        let (cost, optimum) = (problem.cost(&ours), problem.cost(&theirs));
        Compared {
            name: name.clone(),
            horizon,
            points,
            status: report.status,
            iterations: report.iterations,
            time_us: least[0],
            cost,
            u_0: ours.u[0].into(),
            clarabel_status: known.status,
            clarabel_time_us: least[1],
            clarabel_cost: optimum,
            clarabel_u_0: theirs.u[0].into(),
            cost_difference: (cost - optimum).abs() / optimum.abs().max(1.0),
            u_0_difference: (ours.u[0] - theirs.u[0]).amax(),
        }
    });
    rows.collect()
}

/// The comparison for people: a line for each problem if there are few, and what all of them give.
#[must_use]
pub fn compared_text(rows: &[Compared]) -> String {
    let mut out = String::new();
    // Writing to a string cannot fail.
    let _ = write_rows(rows, &mut out);
    out
}

/// A number of each problem.
type Column = fn(&Compared) -> f64;

/// Problems up to which each has a line; above, only those that are not solved.
const FEW: usize = 40;

fn write_rows(rows: &[Compared], out: &mut String) -> std::fmt::Result {
    writeln!(
        out,
        "{:<28}{:>4}{:>7}{:>14}{:>6}{:>9}{:>11}{:>16}{:>11}{:>10}",
        "problem",
        "N",
        "points",
        "status",
        "iter",
        "us",
        "Clarabel us",
        "cost",
        "difference",
        "u_0"
    )?;
    let solved = |row: &Compared| row.status == SolveStatus::Solved;
    for row in rows.iter().filter(|row| rows.len() <= FEW || !solved(row)) {
        writeln!(
            out,
            "{:<28}{:>4}{:>7}{:>14}{:>6}{:>9.1}{:>11.1}{:>16.9}{:>11.1e}{:>10.1e}",
            row.name,
            row.horizon,
            row.points,
            format!("{:?}", row.status),
            row.iterations,
            row.time_us,
            row.clarabel_time_us,
            row.cost,
            row.cost_difference,
            row.u_0_difference
        )?;
    }
    let lines: [(&str, Column); 5] = [
        ("time [us]", |row| row.time_us),
        ("Clarabel [us]", |row| row.clarabel_time_us),
        ("iterations", |row| f64::from(row.iterations)),
        ("difference of cost", |row| row.cost_difference),
        ("difference of u_0", |row| row.u_0_difference),
    ];
    writeln!(out, "{:<28}{:>12}{:>12}{:>12}", "all", "median", "99 %", "greatest")?;
    for (name, value) in lines {
        let mut values: Vec<f64> = rows.iter().map(value).collect();
        let [median, tail, most] = quantiles(&mut values, [50, 99, 100]);
        let text = |v: f64| if v < 0.1 { format!("{v:.1e}") } else { format!("{v:.1}") };
        writeln!(out, "{name:<28}{:>12}{:>12}{:>12}", text(median), text(tail), text(most))?;
    }
    let unsolved = rows.iter().filter(|row| !solved(row)).count();
    writeln!(
        out,
        "{} problems, {unsolved} not solved to tolerance by the structured solver",
        rows.len()
    )
}
