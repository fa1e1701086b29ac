//! What the FMI layer costs, beside what it wraps, in one run: a control step called directly and
//! through FMI 3.0, and an FMU state taken and restored with many laps learned.
//!
//! `cargo bench -p fmu_core` prints medians and 99th percentiles.
#![allow(clippy::unwrap_used, clippy::print_stdout, unsafe_code)]

use std::ffi::{CString, c_void};
use std::hint::black_box;
use std::ptr::{null, null_mut};
use std::sync::Arc;
use std::time::Instant;

use controller::{Config, Controller, Measurement, Pose};
use fmu_core::{ControllerFmu, FmuModel};
use vehicle_model::{CarParams, Input, Plant, PlantParams, State, Track};

fmu_core::export_fmu!(ControllerFmu);
use fmi_exports as c;

const PERIOD: f64 = 0.1;

fn reference(name: &str) -> u32 {
    let variables = ControllerFmu::description().table.variables();
    variables.iter().position(|v| v.name == name).unwrap() as u32
}

fn instance() -> *mut c_void {
    let token = CString::new(ControllerFmu::description().token()).unwrap();
    // SAFETY: strings end with a zero byte; one reference, one value.
    unsafe {
        let fmu = c::fmi3InstantiateCoSimulation(
            c"c".as_ptr(),
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
        );
        assert_eq!(c::fmi3SetFloat64(fmu, &reference("param.warm_up.laps"), 1, &1.0, 1), 0);
        assert_eq!(c::fmi3EnterInitializationMode(fmu, 0, 0.0, 0.0, 0, 0.0), 0);
        assert_eq!(c::fmi3ExitInitializationMode(fmu), 0);
        fmu
    }
}

/// Names resolved once, as a host does.
struct References {
    state: [u32; 6],
    command: [u32; 2],
}

fn fmi_step(fmu: *mut c_void, r: &References, k: usize, x: &State) -> Input {
    let (x, mut u) = (x.to_vector(), [0.0; 2]);
    let (mut event, mut stop, mut early, mut last) = (0, 0, 0, 0.0);
    // SAFETY: arrays have the lengths given, all places are ours.
    unsafe {
        c::fmi3SetFloat64(fmu, r.state.as_ptr(), 6, x.as_ptr(), 6);
        let time = k as f64 * PERIOD;
        let status =
            c::fmi3DoStep(fmu, time, PERIOD, 1, &mut event, &mut stop, &mut early, &mut last);
        assert!(status <= 1);
        c::fmi3GetFloat64(fmu, r.command.as_ptr(), 2, u.as_mut_ptr(), 2);
    }
    Input { a: u[0], delta: u[1] }
}

fn report(what: &str, times: &mut [f64]) -> f64 {
    times.sort_by(f64::total_cmp);
    let at = |share: f64| 1e6 * times[((times.len() - 1) as f64 * share) as usize];
    println!("{what:<46} median {:>10.2} us   p99 {:>10.2} us", at(0.5), at(0.99));
    at(0.5)
}

fn main() {
    let laps: usize = std::env::var("LMPC_BENCH_LAPS").map_or(100, |l| l.parse().unwrap());
    let track = Arc::new(Track::builtin("l").unwrap());
    let car = CarParams::builtin("barc").unwrap();
    let mut config = Config::default();
    config.warm_up.laps = 1;
    let mut native = Controller::new(config, car.clone(), track.clone()).unwrap();
    let start = State { v_x: 1.2, ..State::default() };
    let mut plant = Plant::new(PlantParams::new(car), track, start).unwrap();
    let begin = Instant::now();
    let fmu = instance();
    println!("instantiate and initialise: {:.2} ms", 1e3 * begin.elapsed().as_secs_f64());
    let names = ["v_x", "v_y", "omega_z", "e_psi", "s", "e_y"];
    let r = References {
        state: names.map(|n| reference(&format!("vehicle.{n}"))),
        command: ["cmd.a", "cmd.delta"].map(reference),
    };

    let (mut direct, mut fmi, mut extra) = (Vec::new(), Vec::new(), Vec::new());
    let mut k = 0;
    while native.laps().len() < laps && k < 100_000 {
        let x = plant.measure();
        let measurement =
            Measurement { time: k as f64 * PERIOD, pose: Pose::Frenet(x), applied: None };
        // Take turns in who goes first, so that neither always finds warm caches.
        let (mut native_time, mut fmi_time, mut u, mut v) = (0.0, 0.0, None, None);
        for turn in 0..2 {
            let begin = Instant::now();
            if (k + turn) % 2 == 0 {
                u = Some(native.step(&measurement).input);
                native_time = begin.elapsed().as_secs_f64();
            } else {
                v = Some(fmi_step(fmu, &r, k, &x));
                fmi_time = begin.elapsed().as_secs_f64();
            }
        }
        assert_eq!(u, v, "step {k}");
        direct.push(native_time);
        fmi.push(fmi_time);
        extra.push(fmi_time - native_time);
        plant.apply(u.unwrap(), PERIOD);
        k += 1;
    }
    println!("{} laps, {k} steps", native.laps().len());
    report("control step, direct", &mut direct);
    report("control step, FMI 3.0 set 6 + step + get 2", &mut fmi);
    report("difference, pair by pair", &mut extra);

    let mut times: Vec<f64> = (0..20_000)
        .map(|_| {
            let begin = Instant::now();
            let (x, mut u) = ([1.0, 0.0, 0.0, 0.0, 1.0, 0.0], [0.0; 2]);
            // SAFETY: arrays have the lengths given.
            unsafe {
                c::fmi3SetFloat64(fmu, r.state.as_ptr(), 6, x.as_ptr(), 6);
                c::fmi3GetFloat64(fmu, r.command.as_ptr(), 2, u.as_mut_ptr(), 2);
            }
            black_box(u);
            begin.elapsed().as_secs_f64()
        })
        .collect();
    report("set 6 + get 2 alone", &mut times);

    let mut times: Vec<f64> = (0..2_000)
        .map(|_| {
            let (begin, mut state) = (Instant::now(), null_mut());
            // SAFETY: the place is ours.
            unsafe {
                assert_eq!(c::fmi3GetFMUState(fmu, &mut state), 0);
                assert_eq!(c::fmi3SetFMUState(fmu, state), 0);
            }
            let time = begin.elapsed().as_secs_f64();
            // SAFETY: as above.
            unsafe { c::fmi3FreeFMUState(fmu, &mut state) };
            time
        })
        .collect();
    report(&format!("get + set FMU state, {} laps", native.laps().len()), &mut times);
    // SAFETY: the handle is ours.
    unsafe { c::fmi3FreeInstance(fmu) };
}
