//! Control-step times by phase, measured by the host: the controller has no clock.

use std::time::Instant;

use controller::{Phase, Probe};

/// The phases in the order of a step, with their names.
pub const PHASES: [(Phase, &str); 5] = [
    (Phase::Project, "project"),
    (Phase::Linearize, "linearize"),
    (Phase::Regress, "regress"),
    (Phase::SafeSet, "safe set"),
    (Phase::Solve, "solve"),
];

/// Times of one step [s].
#[derive(Debug, Clone, Copy, Default)]
pub struct StepTime {
    /// By phase, in the order of [`PHASES`].
    pub phases: [f64; 5],
    /// Of the whole step.
    pub total: f64,
}

/// A clock that is told about the phases.
#[derive(Debug)]
pub struct Stopwatch {
    time: StepTime,
    whole: Instant,
    begun: Instant,
}

impl Stopwatch {
    /// A clock that starts now.
    #[must_use]
    pub fn start() -> Self {
        let now = Instant::now();
        Self { time: StepTime::default(), whole: now, begun: now }
    }

    /// The times until now.
    #[must_use]
    pub fn stop(self) -> StepTime {
        StepTime { total: self.whole.elapsed().as_secs_f64(), ..self.time }
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
