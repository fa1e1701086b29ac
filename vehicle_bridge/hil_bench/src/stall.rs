//! Whether the computer itself stood still: one thread for each processor, above all others.

use std::sync::atomic::Ordering;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use nix::sched::{CpuSet, sched_setaffinity};
use nix::unistd::Pid;

use super::run::RunOutcome;
use hosting::realtime;
use hosting::worker::Worker;
use transport::now;

/// Above every loop of ours: what delays this thread delays them all.
const PRIORITY: u8 = 90;
const BEAT: Duration = Duration::from_millis(1);
/// Times a run is repeated. \[-\]
const AGAIN: usize = 3;
/// A beat later than this is a stall. \[ns\]
const LIMIT_NS: i64 = 5_000_000;

/// Begin and length of a stall. \[ns, ns\]
type Stalls = Arc<Mutex<Vec<(i64, i64)>>>;

/// How the computer itself ran meanwhile.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Stood {
    /// Times a processor stood still for more than 5 ms. \[-\]
    pub times: usize,
    /// The longest of them. \[s\]
    pub longest: f64,
}

/// Counts stalls until it is dropped.
pub(super) struct Watch {
    stalls: Stalls,
    _workers: Vec<Worker>,
}

impl Watch {
    /// Begins on every processor there is.
    pub(super) fn start() -> std::io::Result<Self> {
        let stalls = Stalls::default();
        let processors = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
        let worker = |processor: usize| {
            let stalls = Arc::clone(&stalls);
            Worker::start("hil-watch", move |stop| {
                // Without these rights it sees the stalls of common threads: more of them.
                let mut set = CpuSet::new();
                if set.set(processor).is_ok() {
                    let _ = sched_setaffinity(Pid::from_raw(0), &set);
                }
                let _ = realtime::prioritise(PRIORITY);
                while !stop.load(Ordering::Relaxed) {
                    let (begun, due) = (now().mono.as_ns(), Instant::now() + BEAT);
                    std::thread::sleep(BEAT);
                    let late = Instant::now().saturating_duration_since(due).as_nanos();
                    let late = i64::try_from(late).unwrap_or(i64::MAX);
                    if late > LIMIT_NS {
                        stalls.lock().unwrap_or_else(PoisonError::into_inner).push((begun, late));
                    }
                }
            })
        };
        let workers = (0..processors).map(worker).collect::<Result<_, _>>()?;
        Ok(Self { stalls, _workers: workers })
    }

    /// Runs, and again if the computer itself stood still in a run that broke a limit it may be
    /// blamed for. What the runs broke that do not count stays in the outcome of the one that does.
    pub(super) fn undisturbed(&self, run: impl Fn() -> RunOutcome) -> RunOutcome {
        let mut disturbed = Vec::new();
        loop {
            let begun_ns = now().mono.as_ns();
            let mut outcome = run();
            let again = outcome.excusable && disturbed.len() < AGAIN;
            let Some(stall_ns) = self.longest(begun_ns).filter(|_| again) else {
                outcome.disturbed = disturbed;
                return outcome;
            };
            let (stall, broken) = (stall_ns as f64 * 1e-6, outcome.broken.join("; "));
            disturbed.push(format!("the computer stood still for {stall:.1} ms: {broken}"));
        }
    }

    /// All of them so far.
    pub(super) fn stalls(&self) -> Stood {
        let stalls = self.stalls.lock().unwrap_or_else(PoisonError::into_inner);
        let longest = stalls.iter().map(|(_, late)| *late).max().unwrap_or(0);
        Stood { times: stalls.len(), longest: longest as f64 * 1e-9 }
    }

    /// The longest stall since `from_ns`, if there was one. \[ns\]
    fn longest(&self, from_ns: i64) -> Option<i64> {
        let stalls = self.stalls.lock().unwrap_or_else(PoisonError::into_inner);
        let since = stalls.iter().filter(|(begun, late)| begun.saturating_add(*late) >= from_ns);
        since.map(|(_, late)| *late).max()
    }
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;

    use super::*;

    #[test]
    fn only_a_run_that_the_computer_spoilt_is_repeated_and_counted() {
        let outcome = |excusable| RunOutcome {
            broken: vec!["late".to_owned()],
            excusable,
            ..RunOutcome::default()
        };
        let runs = |watch: &Watch, excusable| {
            let count = Cell::new(0);
            let got = watch.undisturbed(|| {
                count.set(count.get() + 1);
                outcome(excusable)
            });
            assert_eq!(got.broken, ["late"]);
            (count.get(), got.disturbed.len())
        };
        let with = |stalls| Watch { stalls: Arc::new(Mutex::new(stalls)), _workers: Vec::new() };
        let spoilt = with(vec![(i64::MAX, 7_000_000)]);
        assert_eq!(runs(&spoilt, true), (AGAIN + 1, AGAIN));
        assert_eq!(runs(&spoilt, false), (1, 0));
        assert_eq!(runs(&with(vec![(0, 7_000_000)]), true), (1, 0));
    }
}
