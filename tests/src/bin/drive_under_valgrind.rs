//! What `tests/instructions.rs` runs under Valgrind: `drive_under_valgrind CASE STEPS` drives one of the
//! benchmark's cases until so many learned steps, the first ones, are made.
#![allow(clippy::unwrap_used)] // a part of a test

use std::hint::black_box;

use controller::{Action, Command, Controller, Measurement};
use step_timing::{Circuit, cases};

/// Laps stored before the first learned one.
const LAPS: usize = 4;

/// What is counted; its name is how Valgrind finds it.
#[inline(never)]
fn counted_step(controller: &mut Controller, measurement: &Measurement) -> Command {
    black_box(controller.step(measurement))
}

fn main() {
    let mut arguments = std::env::args().skip(1).map(|text| text.parse::<usize>().unwrap());
    let (case, steps) = (arguments.next().unwrap(), arguments.next().unwrap());
    let mut circuit = Circuit::new(&cases().unwrap()[case], LAPS).unwrap();
    let (mut counted, mut lap_end) = (0, true);
    while counted < steps {
        let measurement = circuit.measurement();
        let learning = !circuit.controller.plan().is_empty() && !lap_end;
        let command = if learning {
            counted += 1;
            let command = counted_step(&mut circuit.controller, &measurement);
            assert_eq!(command.status.action, Action::Learned);
            command
        } else {
            circuit.controller.step(&measurement)
        };
        lap_end = command.status.finished.is_some();
        circuit.drive(&command);
    }
}
