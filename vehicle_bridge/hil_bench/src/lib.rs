//! The bench: scenarios in real time, faults between controller and car, a verdict.
//!
//! [`mod@bench`], [`fault`] and [`measure`] are what a bench file says. A run starts the processes,
//! puts a fault proxy between the two networks, drives, injects and observes; [`verdict`] sums up.

mod alter;
mod attack;
pub mod bench;
mod controller_side;
mod driver;
pub mod fault;
mod fault_names;
mod field;
mod forge;
pub mod host;
pub mod malformed;
pub mod measure;
mod observe;
pub mod on_car;
mod operator;
mod output;
mod passed;
pub mod probe;
mod process;
mod program;
mod proxy;
mod random;
mod run;
mod stall;
pub mod timeline;
pub mod verdict;
mod wire;

use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, AtomicI64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use anyhow::Result;

pub use bench::Bench;
pub use run::RunOutcome;
pub use stall::Stood;
pub use timeline::Timeline;
pub use verdict::Verdict;

use driver::{Driver, Task};
use stall::Watch;

use hosting::load;
use hosting::parallel::parallel;

/// First of the ports; each job takes two.
const PORTS: u16 = 17_000;
const LOOK: Duration = Duration::from_millis(20);

/// Runs every scenario of a bench, `jobs` runs at a time; `done` sees each run. Also returns
/// how often the computer itself stood still.
///
/// # Errors
/// If car or track cannot be loaded, or `done` fails.
pub fn execute<'b>(
    bench: &'b Bench,
    lmpc: PathBuf,
    jobs: usize,
    mut done: impl FnMut(&bench::Scenario, &RunOutcome) -> Result<()>,
) -> Result<(Vec<Verdict<'b>>, Stood)> {
    let (car, track) = (load::car(&bench.car)?, load::track(&bench.track)?);
    let context = run::RunContext { bench, car, track: Arc::clone(&track), lmpc };
    let watch = Watch::start()?;
    let free = Mutex::new((0..jobs).filter_map(|i| u16::try_from(2 * i).ok()).collect::<Vec<_>>());
    let lock = || free.lock().unwrap_or_else(PoisonError::into_inner);
    let mut verdicts: Vec<Verdict<'b>> =
        bench.scenarios.iter().map(|scenario| Verdict { scenario, runs: Vec::new() }).collect();
    let one = |&(index, seed): &(usize, u64)| {
        let offset = lock().pop().unwrap_or_default();
        let run = || run::run(&context, &bench.scenarios[index], seed, PORTS + offset);
        let outcome = watch.undisturbed(run);
        lock().push(offset);
        outcome
    };
    for alone in [false, true] {
        let scenarios = bench.scenarios.iter().enumerate().filter(|(_, s)| s.alone == alone);
        let seeds = |scenario| bench.seed..bench.seed + u64::from(bench.repeats(scenario));
        let mut work: Vec<(usize, u64)> =
            scenarios.flat_map(|(index, s)| seeds(s).map(move |seed| (index, seed))).collect();
        // Scenarios in turn: heavy ones do not all run at the same time.
        work.sort_by_key(|(index, seed)| (*seed, *index));
        let jobs = if alone { 1 } else { jobs };
        parallel(&work, jobs, one, |i, mut outcome| {
            let index = work[i].0;
            done(&bench.scenarios[index], &outcome)?;
            // Pictures of all runs would fill the memory: of the passed ones the first is enough.
            let pictured = verdicts[index].runs.iter().any(|r| !r.timeline.is_empty());
            if outcome.broken.is_empty() && pictured {
                outcome.timeline = Timeline::default();
            }
            verdicts[index].runs.push(outcome);
            Ok::<(), anyhow::Error>(())
        })?;
    }
    for verdict in &mut verdicts {
        verdict.runs.sort_by_key(|run| run.seed);
    }
    Ok((verdicts, watch.stalls()))
}

/// Commands a car like the bench does, as a program of its own, until `stop` is set.
///
/// # Errors
/// If the network cannot be joined, or car or track cannot be loaded.
pub fn drive(url: &str, car: &str, track: &str, speed: f64, stop: &AtomicBool) -> Result<()> {
    let network = run::join(url)?;
    let (car, track) = (load::car(car)?, load::track(track)?);
    let (commands, arming, deadman, faults) = (true, false, false, Vec::new());
    let task = Task { car, track, speed, commands, arming, deadman, faults };
    let _driver = Driver::start(&network, task, &Arc::new(AtomicI64::new(i64::MAX)))?;
    while !stop.load(Ordering::Relaxed) {
        std::thread::sleep(LOOK);
    }
    Ok(())
}
