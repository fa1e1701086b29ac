//! A vehicle of your own: any code that takes an input and returns a state.
//! `cargo run --release -p controller --example own_vehicle`
//!
//! Here it is a kinematic bicycle in the global frame, integrated by explicit Euler steps of 1 ms.
//! The controller still plans with the dynamic model of the `barc` car: the regression learns the
//! difference from the measured laps.
#![allow(clippy::print_stdout, reason = "an example")]

use std::sync::Arc;

use controller::{Config, Controller, Measurement, Pose, Preset};
use vehicle_model::{CarParams, GlobalState, Input, State, Track};

/// Step of the integration [s].
const STEP: f64 = 1e-3;

struct OwnVehicle {
    state: GlobalState,
    l_f: f64,
    l_r: f64,
}

impl OwnVehicle {
    fn drive(&mut self, u: Input, duration: f64) {
        for _ in 0..(duration / STEP).round() as usize {
            let wheelbase = self.l_f + self.l_r;
            let side_slip = (self.l_r * u.delta.tan() / wheelbase).atan();
            let state = &mut self.state;
            let (sin, cos) = state.psi.sin_cos();
            state.x += STEP * (state.v_x * cos - state.v_y * sin);
            state.y += STEP * (state.v_x * sin + state.v_y * cos);
            state.psi += STEP * state.omega_z;
            state.v_x = (state.v_x + STEP * u.a).max(0.0);
            state.v_y = state.v_x * side_slip.tan();
            state.omega_z = state.v_y / self.l_r;
        }
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let car = CarParams::builtin("barc")?;
    let track = Arc::new(Track::builtin("l").ok_or("no such track")?);
    let config = Config::derived(Preset::Race, &car, &track);
    let start = State { v_x: config.warm_up.speed, ..State::default() };
    let period = config.horizon.period;
    let mut vehicle = OwnVehicle { state: track.to_global(&start), l_f: car.l_f, l_r: car.l_r };
    let mut controller = Controller::new(config, car, track)?;
    for n in 0..800 {
        // A pose in the world; the controller projects it onto the track.
        let pose = Pose::Global(vehicle.state);
        let time = f64::from(n) * period;
        let command = controller.step(&Measurement { time, pose, applied: None });
        // Between two measurements: the part of the next step that needs no measurement.
        controller.prepare();
        vehicle.drive(command.input, period);
        if let Some(lap) = command.status.finished {
            println!("{:?} lap: {:.3} s", lap.kind, lap.lap_time);
        }
    }
    Ok(())
}
