//! The small car learns the L track: `cargo run --release -p controller --example race_in_20_lines`.
#![allow(clippy::print_stdout, reason = "an example")]

use std::sync::Arc;

use controller::{Config, Controller, Measurement, Pose, Preset};
use vehicle_model::{CarParams, Plant, PlantParams, State, Track};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let car = CarParams::builtin("barc")?;
    let track = Arc::new(Track::builtin("l").ok_or("no such track")?);
    let config = Config::derived(Preset::Race, &car, &track);
    let start = State { v_x: config.warm_up.speed, ..State::default() };
    let period = config.horizon.period;
    let mut vehicle = Plant::new(PlantParams::new(car.clone()), Arc::clone(&track), start)?;
    let mut controller = Controller::new(config, car, track)?;
    for n in 0..1500 {
        let pose = Pose::Frenet(vehicle.measure());
        let time = f64::from(n) * period;
        let command = controller.step(&Measurement { time, pose, applied: None });
        vehicle.apply(command.input, period);
        if let Some(lap) = command.status.finished {
            println!("{:?} lap: {:.3} s", lap.kind, lap.lap_time);
        }
    }
    Ok(())
}
