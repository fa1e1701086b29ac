//! Learned laps outlive the process: `cargo run --release -p controller --example save_and_load`.
//!
//! A controller drives its initial laps and saves them; a second one loads the bytes and learns from
//! the first step on. The bytes carry a checksum and the fingerprints of car, track and configuration.
#![allow(clippy::print_stdout, reason = "an example")]

use std::sync::Arc;

use controller::{Action, Config, Controller, Measurement, Pose, Preset};
use vehicle_model::{CarParams, Plant, PlantParams, State, Track};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let car = CarParams::builtin("barc")?;
    let track = Arc::new(Track::builtin("l").ok_or("no such track")?);
    let config = Config::derived(Preset::Race, &car, &track);
    let start = State { v_x: config.warm_up.speed, ..State::default() };
    let mut first = Controller::new(config.clone(), car.clone(), Arc::clone(&track))?;
    let mut vehicle = Plant::new(PlantParams::new(car.clone()), Arc::clone(&track), start)?;
    drive(&mut first, &mut vehicle, config.warm_up.laps);

    let bytes = first.save();
    println!("{} laps in {} bytes", first.laps().len(), bytes.len());

    let mut second = Controller::new(config, car.clone(), Arc::clone(&track))?;
    second.load(&bytes)?;
    let mut vehicle = Plant::new(PlantParams::new(car), track, start)?;
    let pose = Pose::Frenet(vehicle.measure());
    let command = second.step(&Measurement { time: 0.0, pose, applied: None });
    println!("first step after loading: {:?}", command.status.action);
    if command.status.action != Action::Learned {
        return Err("the loaded laps are not used".into());
    }
    Ok(())
}

/// Drives until `laps` laps are closed.
fn drive(controller: &mut Controller, vehicle: &mut Plant, laps: usize) {
    let period = controller.config().horizon.period;
    let mut step = 0;
    while controller.laps().len() < laps {
        let pose = Pose::Frenet(vehicle.measure());
        let time = f64::from(step) * period;
        let command = controller.step(&Measurement { time, pose, applied: None });
        controller.prepare();
        vehicle.apply(command.input, period);
        step += 1;
    }
}
