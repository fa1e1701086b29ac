//! Control-step times by phase, measured by the host: the controller has no clock.

use std::time::{Duration, Instant};

use controller::{Phase, Probe};
use nix::time::{ClockId, clock_gettime};

/// The phases in the order of a step, with their names.
pub const PHASES: [(Phase, &str); 5] = [
    (Phase::Project, "project"),
    (Phase::Linearize, "linearize"),
    (Phase::Regress, "regress"),
    (Phase::SafeSet, "safe set"),
    (Phase::Solve, "solve"),
];

/// Times of one step \[s\].
#[derive(Debug, Clone, Copy, Default)]
pub struct StepTime {
    /// By phase, in the order of [`PHASES`].
    pub phases: [f64; 5],
    /// Of the whole step.
    pub total: f64,
    /// Processor time of the whole step: what it takes where nothing else runs beside it.
    pub processor: f64,
}

/// Processor time of this thread so far \[s\]; 0 where the system does not count it.
fn processor_time() -> f64 {
    clock_gettime(ClockId::CLOCK_THREAD_CPUTIME_ID)
        .map_or(0.0, |time| Duration::from(time).as_secs_f64())
}

/// Measures the phases of a step.
#[derive(Debug)]
pub struct Stopwatch {
    time: StepTime,
    /// Processor time at the start \[s\].
    processor: f64,
    whole: Instant,
    begun: Instant,
}

impl Stopwatch {
    /// A clock that starts now.
    #[must_use]
    pub fn start() -> Self {
        let processor = processor_time();
        let now = Instant::now();
        Self { time: StepTime::default(), processor, whole: now, begun: now }
    }

    /// The times until now.
    #[must_use]
    pub fn stop(self) -> StepTime {
        let total = self.whole.elapsed().as_secs_f64();
        StepTime { total, processor: processor_time() - self.processor, ..self.time }
    }
}

impl Probe for Stopwatch {
    fn begin(&mut self, _: Phase) {
        self.begun = Instant::now();
    }

    fn end(&mut self, phase: Phase) {
        if let Some(i) = PHASES.iter().position(|p| p.0 == phase) {
            self.time.phases[i] += self.begun.elapsed().as_secs_f64();
        }
    }
}

/// The value below which the part `share` of the sorted values lies.
#[must_use]
pub fn percentile(sorted: &[f64], share: f64) -> f64 {
    match sorted.len() {
        0 => f64::NAN,
        n => sorted[((n - 1) as f64 * share).round() as usize],
    }
}
