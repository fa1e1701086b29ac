//! Laps that somebody else drove as the first data D^0: a person, or another program.

use vehicle_model::{Input, State};

use crate::controller::Controller;
use crate::learning::dataset::Sample;
use crate::memory::Memory;
use crate::status::{LapKind, LapResult};

/// One period of a recorded drive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DrivenStep {
    /// Time of the state, on any clock \[s\].
    pub time: f64,
    /// The state, s in [0, L).
    pub x: State,
    /// Mean input that acted over the period that begins with the state.
    pub u: Input,
    /// Whether the state lies one period after that of the step before.
    pub follows: bool,
    /// Whether a lap with this state may enter the safe set.
    pub fit: bool,
}

impl Controller {
    /// Takes over a recorded drive in place of what was learned so far, closes its laps at the line
    /// and learns from them. One lap that is fit as a whole takes the place of all initial laps.
    ///
    /// What was driven before the first line and behind the last one stays in the data of the
    /// regression, as do laps that are not fit; a state that is not fit is not learned from.
    /// Returns the laps that were closed.
    pub fn adopt(&mut self, steps: &[DrivenStep]) -> Vec<LapResult> {
        let length = self.setup.track.length();
        let mut memory = Memory::new(&self.setup.config);
        let mut closed = Vec::new();
        for (i, step) in steps.iter().enumerate() {
            let before = i.checked_sub(1).map(|i| &steps[i]).filter(|_| step.follows);
            match before {
                None => begin(&mut memory, step),
                Some(before) => {
                    let current = &mut memory.dataset.current;
                    if let Some(last) = current.samples.last_mut() {
                        let learned = before.fit && step.fit;
                        last.next = learned.then_some([step.x.v_x, step.x.v_y, step.x.omega_z]);
                    }
                    let ahead = step.x.s - before.x.s;
                    if ahead > 0.5 * length {
                        // Backwards over the line: the lap in progress has lost its meaning.
                        memory.dataset.interrupt();
                    }
                    if ahead < -0.5 * length {
                        let share = (length - before.x.s) / (length - before.x.s + step.x.s);
                        let end = before.time + share * (step.time - before.time);
                        closed.extend(memory.dataset.close(memory.lap, LapKind::Driven, end));
                        memory.lap += 1;
                    }
                }
            }
            let current = &mut memory.dataset.current;
            current.clean &= step.fit;
            current.samples.push(Sample { time: step.time, x: step.x, u: step.u, next: None });
        }
        if let Some(last) = steps.last() {
            close_part(&mut memory, last.time);
        }
        memory.learning = memory.initial_laps_done(self.setup.config.warm_up.laps);
        self.memory = memory;
        self.apply_learned();
        self.finish_learning();
        self.prepared = false;
        closed
    }
}

/// Begins a stretch that nothing connects with what came before.
fn begin(memory: &mut Memory, step: &DrivenStep) {
    close_part(memory, step.time);
    let current = &mut memory.dataset.current;
    current.start_time = step.time;
    current.follows = false;
    current.from_line = false;
    current.clean = false;
}

/// Keeps a lap that was not finished as data of the regression, and as what the lap before led to.
fn close_part(memory: &mut Memory, time: f64) {
    if memory.dataset.current.samples.is_empty() {
        return;
    }
    memory.dataset.interrupt();
    memory.dataset.close(memory.lap, LapKind::Driven, time);
    memory.lap += 1;
}
