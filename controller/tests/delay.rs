//! The delay of a plant that the controller is not given, found in the initial laps.
#![allow(clippy::unwrap_used)]

use std::sync::Arc;

use controller::{Config, Controller, Measurement, Pose, Preset};
use vehicle_model::{CarParams, Plant, PlantParams, State};

/// Delay found for a plant with `periods` of it, in the fourth learned lap.
fn found(car: &CarParams, nominal_mu: f64, periods: usize, noise: f64) -> usize {
    let nominal = car.clone().with_mu(nominal_mu * car.tyre_front.mu);
    let track = Arc::new(vehicle_model::track::random(4, car).unwrap());
    let config = Config::derived(Preset::Race, &nominal, &track);
    let period = config.horizon.period;
    let mut params = PlantParams::new(car.clone());
    params.car.actuator_delay = periods as f64 * period;
    let scale = noise * car.wheelbase() / 0.26;
    (params.noise.s, params.noise.e_y, params.noise.e_psi) = (scale, scale, noise);
    let velocity = 10.0 * scale;
    (params.noise.v_x, params.noise.v_y, params.noise.omega_z) = (velocity, velocity, 10.0 * noise);
    let laps = config.warm_up.laps;
    let start = State { v_x: config.warm_up.speed, ..State::default() };
    let mut plant = Plant::new(params, Arc::clone(&track), start).unwrap();
    let mut controller = Controller::new(config, nominal, track).unwrap();
    for n in 0..20_000_u32 {
        let pose = Pose::Frenet(plant.measure());
        let measurement = Measurement { time: f64::from(n) * period, pose, applied: None };
        let command = controller.step(&measurement);
        plant.apply(command.input, period);
        if controller.laps().len() == laps {
            controller.finish_learning();
            let saved = controller.save();
            let delay = controller.delay();
            controller.load(&saved).unwrap();
            assert_eq!(controller.delay(), delay, "learned data keep it");
            return delay;
        }
    }
    unreachable!("no lap")
}

#[test]
fn whole_periods_are_found_whatever_the_car_grip_and_noise() {
    for name in ["barc", "kart", "f1tenth"] {
        let car = CarParams::builtin(name).unwrap();
        for (nominal_mu, noise) in [(1.0, 0.0), (1.3, 0.002), (0.8, 0.005)] {
            for periods in 0..=2 {
                let case = format!("{name}, {nominal_mu} of the grip, noise {noise}");
                assert_eq!(found(&car, nominal_mu, periods, noise), periods, "{case}");
            }
        }
    }
}
