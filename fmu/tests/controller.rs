//! The controller FMU over its C interface against the controller called directly, bit for bit:
//! straight through, after a rollback, and from serialized bytes in a fresh instance.
#![allow(clippy::unwrap_used, clippy::panic, unsafe_code)]

use std::ffi::{CString, c_void};
use std::ptr::{null, null_mut};
use std::sync::Arc;

use controller::{Config, Controller, Measurement, Pose};
use fmu_core::c::fmi2::Callbacks;
use fmu_core::{ControllerFmu, FmuModel};
use vehicle_model::{CarParams, Input, Plant, PlantParams, State, Track};

fmu_core::export_fmu!(ControllerFmu);
use fmi_exports as c;

const STEPS: usize = 520;
const PERIOD: f64 = 0.1;
/// One initial lap, so that most of the steps are learned ones.
const WARM_UP_LAPS: usize = 1;

fn reference(name: &str) -> u32 {
    let variables = ControllerFmu::description().table.variables();
    variables.iter().position(|v| v.name == name).unwrap_or_else(|| panic!("no '{name}'")) as u32
}

fn references<const N: usize>(names: [&str; N]) -> [u32; N] {
    names.map(reference)
}

const STATE: [&str; 6] =
    ["vehicle.v_x", "vehicle.v_y", "vehicle.omega_z", "vehicle.e_psi", "vehicle.s", "vehicle.e_y"];

/// One FMI 2.0 instance.
struct Fmu(*mut c_void);

impl Fmu {
    fn instantiate() -> Self {
        let token = CString::new(ControllerFmu::description().token()).unwrap();
        let callbacks = Callbacks {
            logger: None,
            allocate_memory: None,
            free_memory: None,
            step_finished: None,
            environment: null_mut(),
        };
        // SAFETY: strings end with a zero byte, the callbacks are whole.
        let handle = unsafe {
            c::fmi2Instantiate(c"c".as_ptr(), 1, token.as_ptr(), null(), &callbacks, 0, 0)
        };
        assert!(!handle.is_null());
        Self(handle)
    }

    fn ready() -> Self {
        Self::with(&[])
    }

    /// Initialised with these texts.
    fn with(texts: &[(&str, &str)]) -> Self {
        let fmu = Self::instantiate();
        let laps = WARM_UP_LAPS as f64;
        for (name, text) in texts {
            let text = CString::new(*text).unwrap();
            // SAFETY: one reference, one text.
            let status = unsafe { c::fmi2SetString(fmu.0, &reference(name), 1, &text.as_ptr()) };
            assert_eq!(status, 0, "{name}");
        }
        // SAFETY: one reference, one value.
        unsafe {
            assert_eq!(c::fmi2SetReal(fmu.0, &reference("param.warm_up.laps"), 1, &laps), 0);
            assert_eq!(c::fmi2SetupExperiment(fmu.0, 0, 0.0, 0.0, 0, 0.0), 0);
            assert_eq!(c::fmi2EnterInitializationMode(fmu.0), 0);
            assert_eq!(c::fmi2ExitInitializationMode(fmu.0), 0);
        }
        fmu
    }

    fn command(&self) -> Input {
        let (names, mut u) = (references(["cmd.a", "cmd.delta"]), [0.0; 2]);
        // SAFETY: two references, two values.
        assert_eq!(unsafe { c::fmi2GetReal(self.0, names.as_ptr(), 2, u.as_mut_ptr()) }, 0);
        Input { a: u[0], delta: u[1] }
    }

    fn step(&self, k: usize, x: &State) -> Input {
        let (names, x) = (references(STATE), x.to_vector());
        // SAFETY: six references, six values.
        let status = unsafe {
            c::fmi2SetReal(self.0, names.as_ptr(), 6, x.as_ptr())
                | c::fmi2DoStep(self.0, k as f64 * PERIOD, PERIOD, 1)
        };
        assert!(status <= 1, "step {k}: status {status}");
        self.command()
    }

    fn saved(&self) -> *mut c_void {
        let mut state = null_mut();
        // SAFETY: the place is ours.
        assert_eq!(unsafe { c::fmi2GetFMUstate(self.0, &mut state) }, 0);
        state
    }

    fn bytes(&self) -> Vec<u8> {
        let (state, mut size) = (self.saved(), 0);
        // SAFETY: the places are ours.
        unsafe {
            assert_eq!(c::fmi2SerializedFMUstateSize(self.0, state, &mut size), 0);
            let mut bytes = vec![0; size];
            assert_eq!(c::fmi2SerializeFMUstate(self.0, state, bytes.as_mut_ptr(), size), 0);
            bytes
        }
    }

    fn restore(&self, bytes: &[u8]) -> i32 {
        let mut state = null_mut();
        // SAFETY: the places are ours.
        unsafe {
            let made = c::fmi2DeSerializeFMUstate(self.0, bytes.as_ptr(), bytes.len(), &mut state);
            if made == 0 { c::fmi2SetFMUstate(self.0, state) } else { made }
        }
    }
}

impl Drop for Fmu {
    fn drop(&mut self) {
        // SAFETY: the handle is ours.
        unsafe { c::fmi2FreeInstance(self.0) };
    }
}

fn plant() -> Plant {
    let track = Arc::new(Track::builtin("l").unwrap());
    let params = PlantParams::new(CarParams::builtin("barc").unwrap());
    Plant::new(params, track, State { v_x: 1.2, ..State::default() }).unwrap()
}

/// Drives from step `from` on; the commands as bits.
fn drive(
    plant: &mut Plant,
    from: usize,
    to: usize,
    mut u: impl FnMut(usize, &State) -> Input,
) -> Vec<[u64; 2]> {
    let mut commands = Vec::new();
    for k in from..to {
        let command = u(k, &plant.measure());
        commands.push([command.a.to_bits(), command.delta.to_bits()]);
        plant.apply(command, PERIOD);
    }
    commands
}

/// What the FMU derives from car and track.
fn derived(car: &CarParams, track: &Track) -> Config {
    Config::derived(controller::Preset::Race, car, track)
}

#[test]
fn commands_are_the_controllers_bit_for_bit_and_so_after_rollback_and_revival() {
    let track = Arc::new(Track::builtin("l").unwrap());
    let car = CarParams::builtin("barc").unwrap();
    let mut config = derived(&car, &track);
    config.warm_up.laps = WARM_UP_LAPS;
    let mut native = Controller::new(config, car, track).unwrap();
    let expected = drive(&mut plant(), 0, STEPS, |k, x| {
        let time = k as f64 * PERIOD;
        native.step(&Measurement { time, pose: Pose::Frenet(*x), applied: None }).input
    });
    // Enough laps to have learned something.
    assert!(native.laps().len() >= 6, "{} laps", native.laps().len());

    let (fmu, mut car) = (Fmu::ready(), plant());
    let half = STEPS / 2;
    assert!(drive(&mut car, 0, half, |k, x| fmu.step(k, x)) == expected[..half]);
    let (state, bytes, at_half) = (fmu.saved(), fmu.bytes(), car.clone());
    assert!(drive(&mut car, half, STEPS, |k, x| fmu.step(k, x)) == expected[half..]);

    // SAFETY: the state is one of this instance.
    assert_eq!(unsafe { c::fmi2SetFMUstate(fmu.0, state) }, 0);
    let again = drive(&mut at_half.clone(), half, STEPS, |k, x| fmu.step(k, x));
    assert!(again == expected[half..], "after rollback");
    drop(fmu);

    let revived = Fmu::instantiate();
    assert_eq!(revived.restore(&bytes), 0);
    let again = drive(&mut at_half.clone(), half, STEPS, |k, x| revived.step(k, x));
    assert!(again == expected[half..], "after serialization");

    let mut damaged = bytes.clone();
    damaged[bytes.len() / 2] ^= 4;
    assert_eq!(Fmu::instantiate().restore(&damaged), 3);
}

#[test]
fn learned_data_goes_through_a_file_to_the_next_day() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("learned.lmpc");
    let saving = Fmu::with(&[("param.learned_save", path.to_str().unwrap())]);
    drive(&mut plant(), 0, STEPS * 3 / 4, |k, x| saving.step(k, x));

    let (car, start) = (CarParams::builtin("barc").unwrap(), plant());
    let mut config = derived(&car, start.track());
    config.warm_up.laps = WARM_UP_LAPS;
    let mut native = Controller::new(config, car, start.track().clone()).unwrap();
    native.load(&std::fs::read(&path).unwrap()).unwrap();
    assert!(native.laps().len() > 1, "{} laps", native.laps().len());
    let expected = drive(&mut start.clone(), 0, 100, |k, x| {
        let time = k as f64 * PERIOD;
        native.step(&Measurement { time, pose: Pose::Frenet(*x), applied: None }).input
    });
    let loading = Fmu::with(&[("param.learned_load", path.to_str().unwrap())]);
    assert!(drive(&mut start.clone(), 0, 100, |k, x| loading.step(k, x)) == expected);
    // Nothing learned, other commands.
    let fresh = Fmu::ready();
    assert!(drive(&mut plant(), 0, 100, |k, x| fresh.step(k, x)) != expected);
}

#[test]
fn a_speed_cap_set_while_stepping_acts_and_keeps_what_was_learned() {
    let (fmu, mut car) = (Fmu::ready(), plant());
    let half = STEPS / 2;
    drive(&mut car, 0, half, |k, x| fmu.step(k, x));
    let (state, mut again) = (fmu.saved(), car.clone());
    let free = drive(&mut car.clone(), half, STEPS, |k, x| fmu.step(k, x));
    let cap = 2.0;
    // SAFETY: the state is one of this instance; one reference, one value.
    unsafe {
        assert_eq!(c::fmi2SetFMUstate(fmu.0, state), 0);
        assert_eq!(c::fmi2SetReal(fmu.0, &reference("param.limits.speed_cap"), 1, &cap), 0);
    }
    let slow = drive(&mut car, half, STEPS, |k, x| fmu.step(k, x));
    let speed = car.truth().v_x;
    assert!((1.7..2.1).contains(&speed), "{speed} m/s with a cap of {cap} m/s");
    assert!(slow != free);
    // Rolling back takes the cap away again.
    // SAFETY: as above.
    assert_eq!(unsafe { c::fmi2SetFMUstate(fmu.0, state) }, 0);
    assert!(drive(&mut again, half, STEPS, |k, x| fmu.step(k, x)) == free);
}

#[test]
fn commands_are_held_between_periods_and_longer_steps_discarded() {
    let fmu = Fmu::ready();
    let x = State { v_x: 1.2, e_y: 0.1, ..State::default() }.to_vector();
    let names = references(STATE);
    let steps = reference("status.steps");
    // SAFETY: arrays have the length they are given.
    unsafe {
        assert_eq!(c::fmi2SetReal(fmu.0, names.as_ptr(), 6, x.as_ptr()), 0);
        assert_eq!(c::fmi2DoStep(fmu.0, 0.0, 0.11, 1), 2);
        let (mut time, mut held) = (0.0, None);
        for k in 1..=40 {
            let size = 0.025;
            assert_eq!(c::fmi2DoStep(fmu.0, time, size, 1), 0);
            time += size;
            let mut count = 0.0;
            assert_eq!(c::fmi2GetReal(fmu.0, &steps, 1, &mut count), 0);
            assert_eq!(count, f64::from((k + 3) / 4));
            let u = fmu.command();
            if k % 4 != 1 {
                assert_eq!(held, Some(u));
            }
            held = Some(u);
        }
    }
}

#[test]
fn wrong_parameters_are_refused_at_the_end_of_initialisation() {
    for (name, text) in [
        ("param.preset", "fastest"),
        ("param.track", "none.toml"),
        ("param.config", "none.toml"),
        ("param.learned_load", "none.lmpc"),
    ] {
        let fmu = Fmu::instantiate();
        let text = CString::new(text).unwrap();
        // SAFETY: one reference, one text.
        unsafe {
            assert_eq!(c::fmi2SetString(fmu.0, &reference(name), 1, &text.as_ptr()), 0);
            assert_eq!(c::fmi2EnterInitializationMode(fmu.0), 0);
            assert_eq!(c::fmi2ExitInitializationMode(fmu.0), 3, "{name}");
        }
    }
}

#[test]
fn twenty_instances_on_twenty_threads_drive_as_one_alone() {
    let run = || {
        let fmu = Fmu::ready();
        drive(&mut plant(), 0, 200, |k, x| fmu.step(k, x))
    };
    let alone = run();
    std::thread::scope(|scope| {
        let all: Vec<_> = (0..20).map(|_| scope.spawn(run)).collect();
        for one in all {
            assert_eq!(one.join().unwrap(), alone);
        }
    });
}

#[test]
fn settings_read_as_in_force() {
    let get = |fmu: &Fmu, name: &str| {
        let mut value = f64::NAN;
        // SAFETY: one reference, one value.
        assert_eq!(unsafe { c::fmi2GetReal(fmu.0, &reference(name), 1, &mut value) }, 0);
        value
    };
    let (car, track) = (CarParams::builtin("iac").unwrap(), Track::builtin("road_course").unwrap());
    let shipped = Config::derived(controller::Preset::Race, &car, &track);
    let fmu = Fmu::with(&[("param.car", "iac"), ("param.track", "road_course")]);
    assert_eq!(get(&fmu, "param.period"), shipped.horizon.period);
    assert_eq!(get(&fmu, "param.horizon"), shipped.horizon.steps as f64);
    assert_eq!(get(&fmu, "param.limits.speed_cap"), shipped.limits.speed_cap);
    assert_eq!(get(&fmu, "param.warm_up.laps"), WARM_UP_LAPS as f64);
    let paper = Fmu::with(&[("param.preset", "paper")]);
    let expected = Config::preset(controller::Preset::Paper);
    assert_eq!(get(&paper, "param.cost.control_rate"), expected.cost.control_rate);
}

#[test]
fn a_step_that_does_not_divide_the_period_warns_once() {
    let fmu = Fmu::ready();
    let x = State { v_x: 1.2, ..State::default() }.to_vector();
    // SAFETY: six references, six values; no pointers but the handle.
    unsafe {
        assert_eq!(c::fmi2SetReal(fmu.0, references(STATE).as_ptr(), 6, x.as_ptr()), 0);
        let size = f64::from(0.05_f32);
        assert_eq!(c::fmi2DoStep(fmu.0, 0.0, size, 1), 0);
        assert_eq!(c::fmi2DoStep(fmu.0, f64::from(0.05_f32), size, 1), 0);
        assert_eq!(c::fmi2DoStep(fmu.0, 0.1, 0.03, 1), 1);
        assert_eq!(c::fmi2DoStep(fmu.0, 0.13, 0.03, 1), 0);
    }
}

#[test]
fn a_state_of_another_centre_line_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("track.toml");
    let track = |length: f64| {
        let half = format!(
            "[[segment]]\nlength_m = {length}\n[[segment]]\nradius_m = 1.5\nangle_deg = 180.0\n"
        );
        let text = "name = \"oval\"\nwidth_left_m = 0.5\nwidth_right_m = 0.5\n".to_owned();
        std::fs::write(&path, text + &half + &half).unwrap();
    };
    track(5.0);
    let saved = Fmu::with(&[("param.track", path.to_str().unwrap())]).bytes();
    assert_eq!(Fmu::instantiate().restore(&saved), 0);
    track(6.0);
    assert_eq!(Fmu::instantiate().restore(&saved), 3);
}
