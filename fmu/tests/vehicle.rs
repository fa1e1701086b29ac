//! The vehicle FMU over its C interface against the plant called directly, bit for bit.
#![allow(clippy::unwrap_used, clippy::panic, unsafe_code)]

use std::ffi::{CString, c_void};
use std::ptr::{null, null_mut};
use std::sync::Arc;

use fmu_core::{FmuModel, VehicleFmu};
use vehicle_model::{CarParams, GripChange, Input, Plant, PlantParams, State, Track};

fmu_core::export_fmu!(VehicleFmu);
use fmi_exports as c;

const STATE: [&str; 6] = ["v_x", "v_y", "omega_z", "e_psi", "s", "e_y"];

fn reference(name: &str) -> u32 {
    let variables = VehicleFmu::description().table.variables();
    variables.iter().position(|v| v.name == name).unwrap_or_else(|| panic!("no '{name}'")) as u32
}

/// One FMI 3.0 instance.
struct Car(*mut c_void);

impl Car {
    fn new(parameters: &[(&str, f64)], integers: &[(&str, i32)], texts: &[(&str, &str)]) -> Self {
        let car = Self::bare();
        for (name, value) in parameters {
            car.set(name, *value);
        }
        for (name, value) in integers {
            let status =
                // SAFETY: one reference, one value.
                unsafe { c::fmi3SetInt32(car.0, &reference(name), 1, value, 1) };
            assert_eq!(status, 0, "{name}");
        }
        for (name, value) in texts {
            let text = CString::new(*value).unwrap();
            // SAFETY: one reference, one text.
            let status = unsafe { c::fmi3SetString(car.0, &reference(name), 1, &text.as_ptr(), 1) };
            assert_eq!(status, 0, "{name}");
        }
        car
    }

    fn bare() -> Self {
        let token = CString::new(VehicleFmu::description().token()).unwrap();
        // SAFETY: strings end with a zero byte.
        let handle = unsafe {
            c::fmi3InstantiateCoSimulation(
                c"car".as_ptr(),
                token.as_ptr(),
                null(),
                0,
                0,
                0,
                0,
                null(),
                0,
                null_mut(),
                None,
                null_mut(),
            )
        };
        assert!(!handle.is_null());
        Self(handle)
    }

    fn initialize(&self) -> i32 {
        // SAFETY: no pointers but the handle.
        unsafe {
            c::fmi3EnterInitializationMode(self.0, 0, 0.0, 0.0, 0, 0.0)
                .max(c::fmi3ExitInitializationMode(self.0))
        }
    }

    fn set(&self, name: &str, value: f64) {
        // SAFETY: one reference, one value.
        let status = unsafe { c::fmi3SetFloat64(self.0, &reference(name), 1, &value, 1) };
        assert_eq!(status, 0, "{name} = {value}");
    }

    fn get(&self, name: &str) -> f64 {
        let mut value = f64::NAN;
        // SAFETY: one reference, one value.
        let status = unsafe { c::fmi3GetFloat64(self.0, &reference(name), 1, &mut value, 1) };
        assert_eq!(status, 0, "{name}");
        value
    }

    fn step(&self, time: f64, size: f64) {
        let (mut event, mut stop, mut early, mut last) = (0, 0, 0, 0.0);
        // SAFETY: all places are ours.
        let status = unsafe {
            c::fmi3DoStep(self.0, time, size, 1, &mut event, &mut stop, &mut early, &mut last)
        };
        assert_eq!((status, last), (0, time + size));
    }

    fn state(&self, prefix: &str) -> [u64; 6] {
        STATE.map(|name| self.get(&format!("{prefix}.{name}")).to_bits())
    }

    fn serialized(&self) -> Vec<u8> {
        let (mut state, mut size) = (null_mut(), 0);
        // SAFETY: all places are ours.
        unsafe {
            assert_eq!(c::fmi3GetFMUState(self.0, &mut state), 0);
            assert_eq!(c::fmi3SerializedFMUStateSize(self.0, state, &mut size), 0);
            let mut bytes = vec![0; size];
            assert_eq!(c::fmi3SerializeFMUState(self.0, state, bytes.as_mut_ptr(), size), 0);
            assert_eq!(c::fmi3FreeFMUState(self.0, &mut state), 0);
            bytes
        }
    }

    fn restore(&self, bytes: &[u8]) -> i32 {
        let mut state = null_mut();
        // SAFETY: all places are ours.
        unsafe {
            c::fmi3DeserializeFMUState(self.0, bytes.as_ptr(), bytes.len(), &mut state)
                .max(c::fmi3SetFMUState(self.0, state))
        }
    }
}

impl Drop for Car {
    fn drop(&mut self) {
        // SAFETY: the handle is ours.
        unsafe { c::fmi3FreeInstance(self.0) };
    }
}

fn bits(x: State) -> [u64; 6] {
    let x = x.to_vector();
    std::array::from_fn(|i| x[i].to_bits())
}

fn command(k: usize) -> Input {
    let t = 0.1 * k as f64;
    Input { a: 0.8 * (0.7 * t).sin(), delta: 0.15 * (1.3 * t).cos() }
}

#[test]
fn the_fmu_is_the_plant_bit_for_bit() {
    let car = Car::new(
        &[
            ("car.mass", 2.5),
            ("car.actuator_lag", 0.05),
            ("car.actuator_delay", 0.03),
            ("noise.v_x", 0.02),
            ("noise.e_y", 0.01),
            ("process_noise.v_y", 0.01),
            ("force.y", 0.3),
            ("initial.v_x", 1.0),
            ("initial.e_y", 0.1),
        ],
        &[("param.seed", 7)],
        &[],
    );
    assert_eq!(car.initialize(), 0);

    let mut params = PlantParams::new(CarParams::builtin("barc").unwrap());
    params.car.mass = 2.5;
    params.car.actuator_lag = 0.05;
    params.car.actuator_delay = 0.03;
    params.noise.v_x = 0.02;
    params.noise.e_y = 0.01;
    params.disturbance.process_std = [0.0, 0.01, 0.0];
    params.disturbance.force_global_n = [0.0, 0.3];
    params.seed = 7;
    let track = Arc::new(Track::builtin("l").unwrap());
    let initial = State { v_x: 1.0, e_y: 0.1, ..State::default() };
    let mut plant = Plant::new(params.clone(), track.clone(), initial).unwrap();

    assert_eq!(car.state("vehicle"), bits(plant.measure()));
    let mut saved = None;
    for k in 0..120 {
        if k == 40 {
            car.set("grip.front", 0.7);
            params.disturbance.grip =
                vec![GripChange { factor: [0.7, 1.0], time_s: None, s_m: None }];
            let state = plant.state().clone();
            plant = Plant::new(params.clone(), track.clone(), initial).unwrap();
            plant.restore(state);
        }
        if k == 70 {
            saved = Some((k, car.serialized()));
        }
        let u = command(k);
        car.set("cmd.a", u.a);
        car.set("cmd.delta", u.delta);
        car.step(0.1 * k as f64, 0.1);
        plant.apply(u, 0.1);
        assert_eq!(car.state("vehicle"), bits(plant.measure()), "step {k}");
        assert_eq!(car.state("truth"), bits(plant.truth()), "step {k}");
        assert_eq!(car.get("tyre.rear.slip").to_bits(), plant.tyres().slip[1].to_bits());
        assert!(car.get("vehicle.x").is_finite());
    }
    let end = car.state("vehicle");

    // The same from the saved bytes in a new instance.
    let (k, bytes) = saved.unwrap();
    let second = Car::bare();
    assert_eq!(second.restore(&bytes), 0);
    for k in k..120 {
        let u = command(k);
        second.set("cmd.a", u.a);
        second.set("cmd.delta", u.delta);
        second.step(0.1 * k as f64, 0.1);
    }
    assert_eq!(second.state("vehicle"), end);
}

#[test]
fn wrong_parameters_are_refused_at_the_end_of_initialisation() {
    for (parameters, texts) in [
        (vec![("car.mass", 0.0)], vec![]),
        (vec![("car.blend_speed_low", 5.0)], vec![]),
        (vec![], vec![("param.track", "nürburgring")]),
        (vec![], vec![("param.track", "missing.toml")]),
        (vec![], vec![("param.car", "missing/car.toml")]),
    ] {
        assert_eq!(Car::new(&parameters, &[], &texts).initialize(), 3, "{parameters:?} {texts:?}");
    }
    for name in CarParams::builtin_names() {
        assert_eq!(Car::new(&[], &[], &[("param.car", name)]).initialize(), 0, "{name}");
    }
}

#[test]
fn a_number_overrides_the_chosen_car_and_all_read_as_in_force() {
    let car = Car::new(&[("car.mass", 900.0)], &[], &[("param.car", "iac")]);
    // Reading an output builds the car early; the choice is still open.
    // SAFETY: no pointers but the handle.
    assert_eq!(unsafe { c::fmi3EnterInitializationMode(car.0, 0, 0.0, 0.0, 0, 0.0) }, 0);
    assert_eq!(car.get("vehicle.v_x"), 1.2);
    assert_eq!(car.get("car.mass"), 900.0);
    let name = c"kart";
    // SAFETY: one reference, one text; no pointers but the handle.
    unsafe {
        assert_eq!(c::fmi3SetString(car.0, &reference("param.car"), 1, &name.as_ptr(), 1), 0);
        assert_eq!(c::fmi3ExitInitializationMode(car.0), 0);
    }
    let kart = CarParams::builtin("kart").unwrap();
    assert_eq!(car.get("car.mass"), 900.0);
    assert_eq!(car.get("car.inertia_z"), kart.inertia_z);
    assert_eq!(car.get("car.a_max"), kart.a_max);
    assert_eq!(car.get("car.power_max"), kart.power_max.unwrap_or_default());
    // It goes on from its bytes, in an instance that nothing was set in.
    car.set("cmd.a", kart.a_max);
    car.step(0.0, 0.1);
    let (bytes, second) = (car.serialized(), Car::bare());
    assert_eq!(second.restore(&bytes), 0);
    for car in [&car, &second] {
        car.step(0.1, 0.1);
    }
    assert_eq!(car.state("truth"), second.state("truth"));
    assert_eq!(second.get("car.mass"), 900.0);
}

#[test]
fn a_command_beyond_the_chosen_cars_limits_warns_once() {
    let car = Car::new(&[], &[], &[("param.car", "kart")]);
    assert_eq!(car.initialize(), 0);
    let most = CarParams::builtin("kart").unwrap().a_max;
    let statuses = [1.0, 2.0, 3.0].map(|times| {
        car.set("cmd.a", times * most);
        let (mut event, mut stop, mut early, mut last) = (0, 0, 0, 0.0);
        let time = car.get("time");
        // SAFETY: all places are ours.
        unsafe { c::fmi3DoStep(car.0, time, 0.1, 1, &mut event, &mut stop, &mut early, &mut last) }
    });
    assert_eq!(statuses, [0, 1, 0]);
}
