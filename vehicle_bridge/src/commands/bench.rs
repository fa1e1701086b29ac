//! `lmpc bench`.

use std::path::Path;

use anyhow::Result;

use super::{Outcome, folders};
use command_line::BenchArgs;
use hosting::problem_file;
use step_timing::{CaseTimes, TimingPlan, cases, compare, compared_text, measure, text};
use terminal::{Talk, result};

/// Measures and prints case after case.
pub(super) fn run(args: &BenchArgs, talk: Talk) -> Result<Outcome> {
    if let Some(path) = &args.read_qp {
        return solve(path, args.json);
    }
    args.dump_qp.as_deref().map_or(Ok(()), folders::results)?;
    let laps = args.laps.iter().map(|laps| *laps as usize).collect();
    let plan = TimingPlan { steps: args.steps as usize, laps, initial: args.initial as usize };
    let mut all = Vec::new();
    for (i, case) in (0..).zip(cases()?) {
        if args.case.is_some_and(|only| only != i) {
            continue;
        }
        let times = measure(&case, &plan, |doing| talk.say(doing))?;
        if let Some(folder) = &args.dump_qp {
            dump(folder, i, &times)?;
        }
        if !args.json {
            result(&text(&times))?;
        }
        all.push(times);
    }
    if args.json {
        terminal::json(&all)?;
    }
    Ok(Outcome::Done)
}

/// Writes the problems of a case.
fn dump(folder: &Path, case: u32, times: &CaseTimes) -> Result<()> {
    for (k, problem) in times.problems.iter().enumerate() {
        let name = format!("case{case}_{}_n{}_{k:05}.json", times.car, times.horizon);
        problem_file::write(&folder.join(name), problem)?;
    }
    Ok(())
}

/// Solves given problems.
fn solve(path: &Path, json: bool) -> Result<Outcome> {
    let compared = compare(&problem_file::read_all(path)?);
    if json {
        terminal::json(&compared)?;
    } else {
        result(&compared_text(&compared))?;
    }
    Ok(Outcome::Done)
}
