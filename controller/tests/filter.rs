//! The state filter against the truth of the plant: errors smaller than the sensor's, a predicted
//! covariance that fits them, and exact measurements untouched.
#![allow(clippy::unwrap_used)]

use std::sync::Arc;

use controller::{Command, Config, Controller, Measurement, Pose, Preset};
use nalgebra::Vector6;
use vehicle_model::track::wrap_angle;
use vehicle_model::{CarParams, Plant, PlantParams, SensorNoise, State, Track};

/// A small car on the L track; its controller believes in another grip.
struct Run {
    controller: Controller,
    plant: Plant,
    steps: u32,
}

impl Run {
    fn new(noise: f64, delay: usize, change: impl Fn(&mut Config)) -> Self {
        let car = CarParams::builtin("barc").unwrap();
        let track = Arc::new(Track::builtin("l").unwrap());
        let nominal = car.clone().with_mu(1.2);
        let mut config = Config::derived(Preset::Race, &nominal, &track);
        config.delay.steps = delay;
        change(&mut config);
        let mut params = PlantParams::new(car);
        params.car.actuator_delay = delay as f64 * config.horizon.period;
        let velocity = 10.0 * noise;
        params.noise = SensorNoise {
            v_x: velocity,
            v_y: velocity,
            omega_z: velocity,
            e_psi: noise,
            s: noise,
            e_y: noise,
        };
        params.seed = 3;
        let start = State { v_x: config.warm_up.speed, ..State::default() };
        let plant = Plant::new(params, Arc::clone(&track), start).unwrap();
        let controller = Controller::new(config, nominal, track).unwrap();
        Self { controller, plant, steps: 0 }
    }

    /// The error of the measurement, and the command.
    fn step(&mut self) -> (Vector6<f64>, Command) {
        let measured = self.plant.measure();
        let error = self.difference(&measured);
        let period = self.controller.config().horizon.period;
        let time = f64::from(self.steps) * period;
        let pose = Pose::Frenet(measured);
        let command = self.controller.step(&Measurement { time, pose, applied: None });
        self.steps += 1;
        (error, command)
    }

    fn drive(&mut self, command: &Command) {
        self.plant.apply(command.input, self.controller.config().horizon.period);
    }

    /// A state minus the true one.
    fn difference(&self, x: &State) -> Vector6<f64> {
        let mut d = x.to_vector() - self.plant.truth().to_vector();
        let length = self.controller.track().length();
        d[3] = wrap_angle(d[3]);
        d[4] -= length * (d[4] / length).round();
        d
    }
}

#[test]
fn exact_measurements_pass_to_the_bit() {
    let mut with = Run::new(0.0, 0, |config| config.filter.active = true);
    let mut without = Run::new(0.0, 0, |config| config.filter.active = false);
    while with.controller.laps().len() < 7 {
        let (command, other) = (with.step().1, without.step().1);
        assert_eq!(command, other, "step {}", with.steps);
        with.drive(&command);
        without.drive(&other);
    }
    assert!(with.controller.covariance().is_none());
}

/// Root mean squares of the sensor's and the filter's errors, and the mean of the squared error in
/// units of the predicted covariance, which is 6 for a filter that knows how good it is.
fn consistency(noise: f64, delay: usize, velocities: bool) -> (Vector6<f64>, Vector6<f64>, f64) {
    let mut run = Run::new(noise, delay, |config| config.filter.velocities = velocities);
    let (mut raw, mut filtered, mut squares) = (Vector6::zeros(), Vector6::zeros(), 0.0);
    let (mut count, mut steps) = (0.0, 0);
    while run.controller.laps().len() < 6 {
        let (error, command) = run.step();
        let own = run.difference(&command.status.state);
        // After the first lap the filter knows its sensors. Noise below the error of the model may
        // pass.
        let known = !run.controller.laps().is_empty();
        steps += u32::from(known);
        if let Some(covariance) = run.controller.covariance().filter(|_| known) {
            raw += error.component_mul(&error);
            filtered += own.component_mul(&own);
            squares += (own.transpose() * covariance.try_inverse().unwrap() * own)[0];
            count += 1.0;
        }
        run.drive(&command);
        assert!(run.steps < 3000, "{:?}", run.plant.truth());
    }
    assert!(count > 0.2 * f64::from(steps), "{count} of {steps} filtered");
    assert!(noise < 0.004 || count > 0.9 * f64::from(steps), "{count} of {steps} filtered");
    let root = |sum: Vector6<f64>| sum.map(|v| (v / count).sqrt());
    (root(raw), root(filtered), squares / count)
}

#[test]
fn the_estimate_is_better_than_the_sensor_and_knows_by_how_much() {
    for noise in [0.001, 0.005, 0.01] {
        for (delay, velocities) in [(0, true), (1, true), (0, false)] {
            let case = format!("noise {noise}, delay {delay}, velocities {velocities}");
            let (raw, filtered, squares) = consistency(noise, delay, velocities);
            assert!((2.0..10.0).contains(&squares), "{case}: {squares}");
            for row in 0..6 {
                let most = if row < 3 && noise > 0.004 { 0.8 } else { 1.25 };
                assert!(filtered[row] < most * raw[row], "{case}: {raw} {filtered}");
            }
        }
    }
}
