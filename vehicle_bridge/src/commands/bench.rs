//! `lmpc bench`.

use anyhow::Result;

use super::Outcome;
use crate::cli::BenchArgs;
use crate::console::{self, Talk, result};
use step_timing::{Plan, cases, measure, text};

/// Measures and prints case after case.
pub(super) fn run(args: &BenchArgs, talk: Talk) -> Result<Outcome> {
    let laps = args.laps.iter().map(|laps| *laps as usize).collect();
    let plan = Plan { steps: args.steps as usize, laps, initial: args.initial as usize };
    let mut all = Vec::new();
    for (i, case) in (0..).zip(cases()?) {
        if args.case.is_some_and(|only| only != i) {
            continue;
        }
        let times = measure(&case, &plan, |doing| talk.say(doing))?;
        if !args.json {
            result(&text(&times))?;
        }
        all.push(times);
    }
    if args.json {
        console::json(&all)?;
    }
    Ok(Outcome::Done)
}
