//! The race without FMI: controller and car called directly, every command as the bits of its two
//! numbers. `fmpy_lockstep.py` holds the FMUs to these.
#![allow(clippy::print_stdout)]

use std::sync::Arc;

use controller::{Config, Controller, Measurement, Pose};
use vehicle_model::{CarParams, Plant, PlantParams, State, Track};

/// Control period [s].
const PERIOD: f64 = 0.1;
const STEPS: usize = 560;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let car = CarParams::builtin("barc")?;
    let track = Arc::new(Track::builtin("l").ok_or("no track")?);
    let mut config = Config::default();
    config.warm_up.laps = 1;
    let mut controller = Controller::new(config, car.clone(), track.clone())?;
    let start = State { v_x: 1.2, ..State::default() };
    let mut plant = Plant::new(PlantParams::new(car), track, start)?;
    for k in 0..STEPS {
        let time = k as f64 * PERIOD;
        let pose = Pose::Frenet(plant.measure());
        let u = controller.step(&Measurement { time, pose, applied: None }).input;
        println!("{:016x} {:016x}", u.a.to_bits(), u.delta.to_bits());
        plant.apply(u, PERIOD);
    }
    Ok(())
}
