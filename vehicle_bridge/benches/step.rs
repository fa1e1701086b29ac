//! One control step by phase with few and with many laps stored, and the QP alone: what
//! `lmpc bench` prints. `cargo bench -p vehicle_bridge --bench step`
#![allow(clippy::print_stdout)] // a program of its own

use step_timing::{BenchError, TimingPlan, cases, measure, text};

fn main() -> Result<(), BenchError> {
    let plan = TimingPlan { steps: 300, laps: vec![4, 100, 1000], initial: 4 };
    for case in cases()? {
        println!("{}", text(&measure(&case, &plan, |_| {})?));
    }
    Ok(())
}
