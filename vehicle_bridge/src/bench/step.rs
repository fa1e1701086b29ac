//! The step by phase.

use std::time::Instant;

use controller::fhocp::Fhocp;
use controller::{Action, Phase, Probe};
use serde::Serialize;

use super::circuit::Circuit;
use super::samples::{Times, preemptions};

/// Names of the phases, in the order they are reported in.
const PHASES: [(&str, Phase); 5] = [
    ("project", Phase::Project),
    ("linearise", Phase::Linearize),
    ("regress", Phase::Regress),
    ("safe set", Phase::SafeSet),
    (QP, Phase::Solve),
];
/// The QP, its part before the measurement included.
pub(super) const QP: &str = "QP";
/// What is left of the step.
const REST: &str = "none of these";
/// The step's part before the measurement.
const PREPARE: &str = "prepare";
/// The step's part after the measurement.
pub(super) const FEEDBACK: &str = "feedback";
/// Both.
pub(super) const WHOLE: &str = "whole step";

/// Times of the step with so many laps stored.
#[derive(Debug, Clone, Serialize)]
pub struct StepTimes {
    /// Laps stored before the first learned one.
    pub laps: usize,
    /// Steps measured.
    pub steps: usize,
    /// Steps left out because the system took the processor away.
    pub preempted: usize,
    /// Phases, then their sums, each with its name.
    pub phases: Vec<PhaseTimes>,
}

/// Times of one phase.
#[derive(Debug, Clone, Serialize)]
pub struct PhaseTimes {
    /// Its name.
    pub name: &'static str,
    /// Its times.
    #[serde(flatten)]
    pub times: Times,
}

impl StepTimes {
    /// Median of a phase [us].
    #[must_use]
    pub fn median(&self, name: &str) -> f64 {
        let phase = self.phases.iter().find(|phase| phase.name == name);
        phase.map_or(f64::NAN, |phase| phase.times.median_us)
    }
}

/// Times of the phases of one step [us].
#[derive(Default)]
struct Stopwatch {
    begun: Option<Instant>,
    phases: [f64; PHASES.len()],
}

impl Probe for Stopwatch {
    fn begin(&mut self, _: Phase) {
        self.begun = Some(Instant::now());
    }

    fn end(&mut self, phase: Phase) {
        if let (Some(begun), Some(i)) = (self.begun, PHASES.iter().position(|p| p.1 == phase)) {
            self.phases[i] += microseconds(begun);
        }
    }
}

fn microseconds(since: Instant) -> f64 {
    since.elapsed().as_secs_f64() * 1e6
}

/// Drives until `count` learned steps are measured; their problems go to `record`.
pub(super) fn measure(
    circuit: &mut Circuit,
    laps: usize,
    count: usize,
    mut record: Option<&mut Vec<Fhocp>>,
) -> StepTimes {
    let names = PHASES.map(|phase| phase.0).into_iter().chain([REST, PREPARE, FEEDBACK, WHOLE]);
    let mut columns: Vec<(&str, Vec<f64>)> = names.map(|name| (name, Vec::new())).collect();
    let (mut measured, mut preempted, mut lap_end) = (0, 0, true);
    while measured < count {
        let measurement = circuit.measurement();
        let mut watch = Stopwatch::default();
        let interference = preemptions();
        let begun = Instant::now();
        circuit.controller.prepare_probed(&mut watch);
        let prepare = microseconds(begun);
        let begun = Instant::now();
        let command = circuit.controller.step_probed(&measurement, &mut watch);
        let feedback = microseconds(begun);
        let disturbed = preemptions() != interference;
        // Learning at the end of a lap is no part of a step.
        if command.status.action == Action::Learned && !lap_end {
            measured += 1;
            if let Some(record) = &mut record {
                record.push(circuit.controller.problem().clone());
            }
            if disturbed {
                preempted += 1;
            } else {
                let whole = prepare + feedback;
                let rest = whole - watch.phases.iter().sum::<f64>();
                let row = watch.phases.into_iter().chain([rest, prepare, feedback, whole]);
                for ((_, column), time) in columns.iter_mut().zip(row) {
                    column.push(time);
                }
            }
        }
        lap_end = command.status.finished.is_some();
        circuit.drive(&command);
    }
    let phases = columns
        .iter_mut()
        .map(|(name, column)| PhaseTimes { name, times: Times::of(column) })
        .collect();
    StepTimes { laps, steps: measured, preempted, phases }
}
