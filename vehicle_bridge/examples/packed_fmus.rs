//! Our packed FMUs, loaded with the `fmi` crate, which is not ours: the car against the native plant
//! and the controller against the native one, bit for bit. `tools/fmu_check.sh` runs it.
//!
//!     cargo run --release -p vehicle_bridge --example packed_fmus -- out/fmu
#![allow(clippy::unwrap_used, clippy::panic, clippy::print_stdout)]

use std::path::{Path, PathBuf};
use std::sync::Arc;

use controller::{Config, Controller, Measurement, Pose, Preset};
use vehicle_host::Vehicle;
use vehicle_host::fmu::{CoSimInstance, FmuOptions, FmuVehicle, ImportedVariable, VariableValue};
use vehicle_model::{CarParams, Input, Plant, PlantParams, State, Track};

const STEPS: usize = 400;
const PERIOD: f64 = 0.1;
const STATE: [&str; 6] =
    ["vehicle.v_x", "vehicle.v_y", "vehicle.omega_z", "vehicle.e_psi", "vehicle.s", "vehicle.e_y"];

fn car_and_track() -> (CarParams, Arc<Track>) {
    (CarParams::builtin("barc").unwrap(), Arc::new(Track::builtin("l").unwrap()))
}

fn drives_as_the_native_plant(file: &Path) {
    let (car, track) = car_and_track();
    let start = State { v_x: 1.5, e_psi: 0.1, e_y: -0.2, ..State::default() };
    let mut native = Plant::new(PlantParams::new(car.clone()), track.clone(), start).unwrap();
    let mut fmu = FmuVehicle::new(FmuOptions {
        file: file.to_owned(),
        map: None,
        preload: None,
        car,
        car_name: "barc".to_owned(),
        track,
        track_name: "l".to_owned(),
        seed: 0,
        start,
    })
    .unwrap();
    for k in 0..STEPS {
        let (x, wave) = (native.truth(), 0.2 * (0.7 * k as f64 * PERIOD).sin());
        let turn = 0.25 * native.track().kappa(x.s);
        let u = Input { a: 1.5 - x.v_x + wave, delta: turn - 0.8 * x.e_psi - 0.5 * x.e_y };
        native.apply(u, PERIOD);
        fmu.apply(u, PERIOD).unwrap();
        assert_eq!(fmu.measure(), native.measure(), "step {k}");
        assert_eq!(fmu.truth(), native.truth(), "step {k}");
        assert_eq!(fmu.applied(), native.applied(), "step {k}");
    }
    assert!(native.truth().is_finite() && native.progress() > 40.0, "{:?}", native.truth());
}

fn commands_as_the_native_controller(file: &Path) {
    let mut fmu = CoSimInstance::open(file, None).unwrap();
    let find = |fmu: &CoSimInstance, names: &[&str]| -> Vec<ImportedVariable> {
        names.iter().map(|name| fmu.variable(name).unwrap()).collect()
    };
    let (state, command) = (find(&fmu, &STATE), find(&fmu, &["cmd.a", "cmd.delta"]));
    // One initial lap, so that most of the steps are learned ones.
    let laps = fmu.variable("param.warm_up.laps").unwrap();
    fmu.set(&laps, &VariableValue::Number(1.0)).unwrap();
    fmu.begin().unwrap();

    let (car, track) = car_and_track();
    let mut config = Config::derived(Preset::Race, &car, &track);
    config.warm_up.laps = 1;
    let mut native = Controller::new(config, car.clone(), track.clone()).unwrap();
    let start = State { v_x: 1.2, ..State::default() };
    let mut plant = Plant::new(PlantParams::new(car), track, start).unwrap();
    for k in 0..STEPS {
        let (x, time) = (plant.measure(), k as f64 * PERIOD);
        let measurement = Measurement { time, pose: Pose::Frenet(x), applied: None };
        let expected = native.step(&measurement).input;
        fmu.set_numbers(&state, &<[f64; 6]>::from(x.to_vector())).unwrap();
        fmu.step(time, PERIOD).unwrap();
        let mut u = [0.0; 2];
        fmu.numbers(&command, &mut u).unwrap();
        assert_eq!(u, [expected.a, expected.delta], "step {k}");
        plant.apply(expected, PERIOD);
    }
    assert!(native.laps().len() > 2, "{} laps", native.laps().len());
}

fn main() {
    let fmus = PathBuf::from(std::env::args().nth(1).unwrap_or_else(|| "out/fmu".to_owned()));
    for version in ["fmi2", "fmi3"] {
        drives_as_the_native_plant(&fmus.join(version).join("lmpc-vehicle.fmu"));
        commands_as_the_native_controller(&fmus.join(version).join("lmpc-controller.fmu"));
        println!(
            "{version} through the fmi crate: {STEPS} steps of car and controller, equal bit for bit"
        );
    }
}
