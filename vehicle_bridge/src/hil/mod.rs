//! The bench: scenarios in real time, faults between controller and car, a verdict.
//!
//! [`bench`], [`fault`] and [`measure`] are what a bench file says. A run starts the processes,
//! puts a fault proxy between the two networks, drives, injects and observes; [`verdict`] sums up.

mod alter;
mod attack;
pub mod bench;
mod driver;
pub mod fault;
pub mod measure;
mod observe;
mod process;
mod program;
mod proxy;
mod random;
mod run;
pub mod verdict;
mod wire;

use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};

use anyhow::Result;

pub use bench::Bench;
pub use observe::Point;
pub use run::Outcome;
pub use verdict::Verdict;

use crate::parallel::parallel;
use crate::race::load;

/// First of the ports; each job takes two.
const PORTS: u16 = 17_000;

/// Runs every scenario of a bench, `jobs` runs at a time; `done` sees each run.
///
/// # Errors
/// If car or track cannot be loaded, or `done` fails.
pub fn execute<'b>(
    bench: &'b Bench,
    lmpc: PathBuf,
    jobs: usize,
    mut done: impl FnMut(&bench::Scenario, &Outcome) -> Result<()>,
) -> Result<Vec<Verdict<'b>>> {
    let (car, track) = (load::car(&bench.car)?, load::track(&bench.track)?);
    let place = run::Place { bench, car, track: Arc::clone(&track), lmpc };
    let mut work = Vec::new();
    for (index, scenario) in bench.scenarios.iter().enumerate() {
        let repeats = u64::from(bench.repeats(scenario));
        work.extend((0..repeats).map(|i| (index, bench.seed + i)));
    }
    let free = Mutex::new((0..jobs).filter_map(|i| u16::try_from(2 * i).ok()).collect::<Vec<_>>());
    let lock = || free.lock().unwrap_or_else(PoisonError::into_inner);
    let mut verdicts: Vec<Verdict<'b>> =
        bench.scenarios.iter().map(|scenario| Verdict { scenario, runs: Vec::new() }).collect();
    let one = |&(index, seed): &(usize, u64)| {
        let offset = lock().pop().unwrap_or_default();
        let outcome = run::run(&place, &bench.scenarios[index], seed, PORTS + offset);
        lock().push(offset);
        outcome
    };
    parallel(&work, jobs, one, |i, mut outcome| {
        let index = work[i].0;
        done(&bench.scenarios[index], &outcome)?;
        // Pictures of all runs would fill the memory: of the passed ones the first is enough.
        if outcome.broken.is_empty() && verdicts[index].runs.iter().any(|r| !r.points.is_empty()) {
            outcome.points.clear();
        }
        verdicts[index].runs.push(outcome);
        Ok::<(), anyhow::Error>(())
    })?;
    for verdict in &mut verdicts {
        verdict.runs.sort_by_key(|run| run.seed);
    }
    Ok(verdicts)
}
