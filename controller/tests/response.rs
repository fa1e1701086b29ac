//! Delay and lag of a plant that the controller is not given, found in the initial laps.
#![allow(clippy::unwrap_used)]

use std::sync::Arc;

use controller::{Config, Controller, Measurement, Pose, Preset, Response};
use vehicle_model::{CarParams, Plant, PlantParams, State};

/// What is found in a plant that responds so.
fn found(car: &CarParams, nominal_mu: f64, response: Response, noise: f64) -> Response {
    let nominal = car.clone().with_mu(nominal_mu * car.tyre_front.mu);
    let track = Arc::new(vehicle_model::track::random(4, car).unwrap());
    let config = Config::derived(Preset::Race, &nominal, &track);
    let period = config.horizon.period;
    let mut params = PlantParams::new(car.clone());
    (params.car.actuator_delay, params.car.actuator_lag) = (response.delay, response.lag);
    (params.noise.s, params.noise.e_y, params.noise.e_psi) = (noise, noise, noise);
    let velocity = 10.0 * noise;
    (params.noise.v_x, params.noise.v_y, params.noise.omega_z) = (velocity, velocity, velocity);
    let laps = config.warm_up.laps;
    let start = State { v_x: config.warm_up.speed, ..State::default() };
    let mut plant = Plant::new(params, Arc::clone(&track), start).unwrap();
    let mut controller = Controller::new(config, nominal, track).unwrap();
    for n in 0..20_000_u32 {
        let pose = Pose::Frenet(plant.measure());
        let measurement = Measurement { time: f64::from(n) * period, pose, applied: None };
        let command = controller.step(&measurement);
        plant.apply(command.input, period);
        if controller.laps().iter().filter(|lap| lap.result.valid).count() == laps {
            controller.finish_learning();
            let saved = controller.save();
            let found = controller.response();
            controller.load(&saved).unwrap();
            assert_eq!(controller.response(), found, "learned data keep it");
            return found;
        }
    }
    unreachable!("no lap")
}

#[test]
fn delay_and_lag_are_found_whatever_the_car_and_noise() {
    for name in ["barc", "kart", "mini"] {
        let car = CarParams::builtin(name).unwrap();
        for (delay, lag, noise) in
            [(0.1, 0.0, 0.0), (0.13, 0.08, 0.0), (0.05, 0.1, 0.002), (0.2, 0.05, 0.005)]
        {
            let found = found(&car, 1.0, Response { delay, lag }, noise);
            let case = format!("{name}, delay {delay}, lag {lag}, noise {noise}: {found:?}");
            assert!((found.delay - delay).abs() < 0.01, "{case}");
            assert!((found.lag - lag).abs() < (0.15 * lag).max(0.01), "{case}");
        }
    }
}

#[test]
fn nothing_is_found_where_nothing_is_late() {
    for name in ["barc", "kart", "f1tenth"] {
        let car = CarParams::builtin(name).unwrap();
        for (nominal_mu, noise) in [(1.0, 0.0), (1.3, 0.0), (1.3, 0.002), (0.8, 0.003)] {
            let found = found(&car, nominal_mu, Response::default(), noise);
            assert_eq!(found, Response::default(), "{name}, {nominal_mu} of the grip, {noise}");
        }
    }
}

#[test]
fn a_delay_that_grows_while_the_car_races_is_reported() {
    let car = CarParams::builtin("barc").unwrap();
    let track = Arc::new(vehicle_model::Track::builtin("l").unwrap());
    let config = Config::derived(Preset::Race, &car, &track);
    let (period, fall) = (config.horizon.period, 100.0);
    let start = State { v_x: config.warm_up.speed, ..State::default() };
    let mut plant = Plant::new(PlantParams::new(car.clone()), Arc::clone(&track), start).unwrap();
    let mut controller = Controller::new(config, car, track).unwrap();
    let (mut before, mut reported) = (controller::Command::default().input, 0);
    for n in 0..1600_u32 {
        let time = f64::from(n) * period;
        let pose = Pose::Frenet(plant.measure());
        let command = controller.step(&Measurement { time, pose, applied: None });
        let change = command.status.delay_change;
        assert_eq!(change, controller.delay_change());
        if time < fall {
            assert_eq!(change, 0.0, "at {time} s nothing has changed");
        }
        reported += u32::from((change - period).abs() < 1e-9);
        plant.apply(if time < fall { command.input } else { before }, period);
        before = command.input;
    }
    assert!(reported > 50, "{reported} steps");
}
