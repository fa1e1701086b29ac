//! Every tunable parameter of the controller FMU, changed while driving in both versions of FMI: the
//! commands are those of a controller with that configuration that took over all that was learned.
#![allow(clippy::unwrap_used, clippy::panic)]

mod slave;

use std::sync::Arc;

use controller::{Config, Controller, Measurement, Pose, Preset};
use fmu_core::{ControllerFmu, FmuModel, Role, Version};
use slave::{COMMAND, STATE, Set, Slave, VERSIONS};
use vehicle_model::{CarParams, Input, Plant, PlantParams, State, Track};

const PERIOD: f64 = 0.1;
/// Steps until the change in a learned lap, and after it.
const BEFORE: usize = 300;
const AFTER: usize = 120;

/// Name, value as a function of that in force, the same in a configuration, steps until the change.
type Case = (&'static str, fn(f64) -> f64, fn(&mut Config, f64), usize);

const CASES: [Case; 12] = [
    ("limits.speed_cap", |_| 2.0, |c, x| c.limits.speed_cap = x, BEFORE),
    ("limits.lane_margin", |x| 1.5 * x, |c, x| c.limits.lane_margin = x, BEFORE),
    ("limits.front_slip", |x| 0.5 * x, |c, x| c.limits.front_slip = x, BEFORE),
    ("limits.rear_slip", |x| 0.5 * x, |c, x| c.limits.rear_slip = x, BEFORE),
    ("cost.input", |x| 3.0 * x + 1.0, |c, x| c.cost.input = x, BEFORE),
    ("cost.control_rate", |x| 3.0 * x, |c, x| c.cost.control_rate = x, BEFORE),
    ("cost.acceleration_rate", |x| 3e3 * x, |c, x| c.cost.acceleration_rate = x, BEFORE),
    ("cost.steering_rate", |x| 3.0 * x, |c, x| c.cost.steering_rate = x, BEFORE),
    ("cost.steering_rate_floor", |x| 30.0 * x + 1.0, |c, x| c.cost.steering_rate_floor = x, BEFORE),
    ("regression.bandwidth", |x| 0.5 * x, |c, x| c.regression.bandwidth = x, BEFORE),
    ("regression.ridge", |x| 30.0 * x + 1.0, |c, x| c.regression.ridge = x, BEFORE),
    ("warm_up.speed", |x| 0.7 * x, |c, x| c.warm_up.speed = x, 30),
];

fn setup() -> (Config, CarParams, Arc<Track>) {
    let (car, track) = (CarParams::builtin("barc").unwrap(), Track::builtin("l").unwrap());
    let mut config = Config::derived(Preset::Race, &car, &track);
    config.warm_up.laps = 1;
    (config, car, Arc::new(track))
}

/// A car a little heavier than the controller believes: there is something to learn.
fn plant() -> Plant {
    let (config, mut car, track) = setup();
    car.mass *= 1.1;
    let start = State { v_x: config.warm_up.speed, ..State::default() };
    Plant::new(PlantParams::new(car), track, start).unwrap()
}

/// Drives from one step to another; the commands as bits.
fn drive(
    plant: &mut Plant,
    steps: std::ops::Range<usize>,
    mut u: impl FnMut(f64, &State) -> Input,
) -> Vec<[u64; 2]> {
    let step = |k| {
        let command = u(k as f64 * PERIOD, &plant.measure());
        plant.apply(command, PERIOD);
        [command.a.to_bits(), command.delta.to_bits()]
    };
    steps.map(step).collect()
}

fn native(controller: &mut Controller) -> impl FnMut(f64, &State) -> Input {
    |time, x| {
        let measurement = Measurement { time, pose: Pose::Frenet(*x), applied: None };
        let input = controller.step(&measurement).input;
        controller.prepare();
        input
    }
}

fn stepped(fmu: &Slave<ControllerFmu>) -> impl FnMut(f64, &State) -> Input {
    |time, x| {
        fmu.set_all(STATE, [x.v_x, x.v_y, x.omega_z, x.e_psi, x.s, x.e_y]);
        assert!(fmu.step(time, PERIOD) <= 1, "{:?}", fmu.log());
        let [a, delta] = fmu.all(COMMAND);
        Input { a, delta }
    }
}

fn fmu(version: Version, more: &[Set<'_>]) -> Slave<ControllerFmu> {
    Slave::with(version, &[&[Set::Number("param.warm_up.laps", 1.0)], more].concat())
}

#[test]
fn each_acts_at_once_and_all_that_was_learned_stays() {
    for version in VERSIONS {
        for (name, change, put, before) in CASES {
            let (mut config, car, track) = setup();
            let mut first = Controller::new(config.clone(), car.clone(), track.clone()).unwrap();
            let mut real = plant();
            drive(&mut real, 0..before, native(&mut first));
            let fmu = fmu(version, &[]);
            let mut simulated = plant();
            drive(&mut simulated, 0..before, stepped(&fmu));

            let parameter = format!("param.{name}");
            let value = change(fmu.get(&parameter));
            fmu.set(&parameter, value);
            put(&mut config, value);
            let mut next = Controller::new(config, car, track).unwrap();
            next.resume(&first.state());
            let after = before..before + AFTER;
            let unchanged = drive(&mut real.clone(), after.clone(), native(&mut first));
            let expected = drive(&mut real, after.clone(), native(&mut next));
            let commands = drive(&mut simulated, after, stepped(&fmu));
            assert!(commands == expected, "{version:?} {name}: not the commands of {value}");
            assert!(commands != unchanged, "{version:?} {name}: {value} changes nothing");
            assert_eq!(fmu.get(&parameter), value);
            if before == BEFORE {
                let [action, support] = fmu.all(["status.action", "support.mean"]);
                assert!(action == 1.0 && support > 0.0, "{name}: action {action}, {support}");
            }
        }
    }
}

#[test]
fn the_description_calls_those_tunable_and_no_others() {
    let variables = ControllerFmu::description().table.variables();
    let tunable = variables.iter().filter(|v| v.role == Role::Tunable);
    let mut found: Vec<&str> = tunable.filter_map(|v| v.name.strip_prefix("param.")).collect();
    // Driven in requests.rs.
    let mut expected = vec!["recovery.mode"];
    expected.extend(CASES.map(|case| case.0));
    found.sort_unstable();
    expected.sort_unstable();
    assert_eq!(found, expected);
}

#[test]
fn numbers_that_do_not_go_together_are_put_back_with_a_warning() {
    for version in VERSIONS {
        let [fmu, untouched] = [fmu(version, &[]), fmu(version, &[])];
        let mut cars = [plant(), plant()];
        drive(&mut cars[0], 0..60, stepped(&fmu));
        let expected = drive(&mut cars[1], 0..90, stepped(&untouched));
        let margin = fmu.get("param.limits.lane_margin");
        fmu.set("param.limits.lane_margin", 50.0);
        // A step that warns is done.
        let x = cars[0].measure();
        fmu.set_all(STATE, [x.v_x, x.v_y, x.omega_z, x.e_psi, x.s, x.e_y]);
        assert_eq!(fmu.step(60.0 * PERIOD, PERIOD), 1);
        assert_eq!(fmu.get("param.limits.lane_margin"), margin);
        if version == Version::Fmi3 {
            let log = fmu.log().join("\n");
            assert!(log.contains("limits.lane_margin_m = 50") && log.contains("stay"), "{log}");
        }
        let [a, delta] = fmu.all(COMMAND);
        cars[0].apply(Input { a, delta }, PERIOD);
        let after = drive(&mut cars[0], 61..90, stepped(&fmu));
        assert!(after == expected[61..]);
    }
}

#[test]
fn learned_data_belong_to_the_parameters_at_the_start() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("learned.lmpc");
    let file = path.to_str().unwrap();
    for version in VERSIONS {
        let start = Set::Number("param.cost.input", 0.3);
        let saving = fmu(version, &[start, Set::Text("param.learned_save", file)]);
        let mut car = plant();
        drive(&mut car, 0..BEFORE, stepped(&saving));
        saving.set("param.limits.lane_margin", 0.17);
        saving.set("param.limits.speed_cap", 2.5);
        let laps = saving.get("lap.finished");
        // From here on what is saved is that of another controller than the one that began.
        std::fs::remove_file(&path).unwrap();
        drive(&mut car, BEFORE..BEFORE + AFTER, stepped(&saving));
        assert!(saving.get("lap.finished") > laps);
        let loading = fmu(version, &[start, Set::Text("param.learned_load", file)]);
        let mut next_day = plant();
        drive(&mut next_day, 0..40, stepped(&loading));
        assert_eq!(loading.get("status.action"), 1.0);
        let other = Slave::<ControllerFmu>::instantiate(version);
        assert_eq!(other.set_text("param.learned_load", file), 0);
        assert_eq!(other.initialise(), 3, "data of another configuration were taken");
    }
}
