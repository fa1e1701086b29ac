//! The step by phase.

use std::time::Instant;

use controller::Action;
use controller::fhocp::Fhocp;
use serde::Serialize;

use super::circuit::Circuit;
use super::samples::{Times, preemptions};
use hosting::timing::{PHASES, Stopwatch};

/// Names of the [`PHASES`].
const NAMES: [&str; PHASES.len()] = ["project", "linearise", "regress", "safe set", QP];
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
    /// Median of a phase \[us\].
    #[must_use]
    pub fn median(&self, name: &str) -> f64 {
        let phase = self.phases.iter().find(|phase| phase.name == name);
        phase.map_or(f64::NAN, |phase| phase.times.median_us)
    }
}

fn microseconds(since: Instant) -> f64 {
    since.elapsed().as_secs_f64() * 1e6
}

/// Steps of one circuit before the next has its turn: enough to warm its memory, few enough for
/// all to see the same machine.
const TURN: usize = 10;

/// Measurements on one circuit.
pub(super) struct Drive {
    circuit: Circuit,
    laps: usize,
    columns: Vec<(&'static str, Vec<f64>)>,
    measured: usize,
    preempted: usize,
    lap_end: bool,
}

/// Drives all of them in turns until `count` learned steps of each are measured; the problems of
/// the first go to `record`.
pub(super) fn measure(
    drives: &mut [Drive],
    count: usize,
    record: &mut Vec<Fhocp>,
) -> Vec<StepTimes> {
    while drives.iter().any(|drive| drive.measured < count) {
        for (i, drive) in drives.iter_mut().enumerate() {
            for _ in 0..TURN {
                if drive.measured < count {
                    drive.step((i == 0).then_some(&mut *record));
                }
            }
        }
    }
    drives.iter_mut().map(Drive::times).collect()
}

impl Drive {
    /// Measurements to come on a circuit with so many laps stored.
    pub(super) fn new(circuit: Circuit, laps: usize) -> Self {
        let names = NAMES.into_iter().chain([REST, PREPARE, FEEDBACK, WHOLE]);
        let columns = names.map(|name| (name, Vec::new())).collect();
        Self { circuit, laps, columns, measured: 0, preempted: 0, lap_end: true }
    }

    fn step(&mut self, record: Option<&mut Vec<Fhocp>>) {
        let circuit = &mut self.circuit;
        let measurement = circuit.measurement();
        let mut watch = Stopwatch::start();
        let interference = preemptions();
        let begun = Instant::now();
        circuit.controller.prepare_probed(&mut watch);
        let prepare = microseconds(begun);
        let begun = Instant::now();
        let command = circuit.controller.step_probed(&measurement, &mut watch);
        let feedback = microseconds(begun);
        let disturbed = preemptions() != interference;
        let phases = watch.stop().phases.map(|seconds| 1e6 * seconds);
        // Learning at the end of a lap is no part of a step.
        if command.status.action == Action::Learned && !self.lap_end {
            self.measured += 1;
            if let Some(record) = record {
                record.push(circuit.controller.problem().clone());
            }
            if disturbed {
                self.preempted += 1;
            } else {
                let whole = prepare + feedback;
                let rest = whole - phases.iter().sum::<f64>();
                let row = phases.into_iter().chain([rest, prepare, feedback, whole]);
                for ((_, column), time) in self.columns.iter_mut().zip(row) {
                    column.push(time);
                }
            }
        }
        self.lap_end = command.status.finished.is_some();
        circuit.drive(&command);
    }

    fn times(&mut self) -> StepTimes {
        let columns = self.columns.iter_mut();
        let phases = columns.map(|(name, column)| PhaseTimes { name, times: Times::of(column) });
        StepTimes {
            laps: self.laps,
            steps: self.measured,
            preempted: self.preempted,
            phases: phases.collect(),
        }
    }
}
