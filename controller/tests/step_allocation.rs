//! After warm-up, `prepare` and `step` allocate nothing. Excepted is the end of a lap: the step that
//! crosses the line, and `prepare` as long as the lap is being learned from.
#![allow(unsafe_code, clippy::unwrap_used)]

#[path = "../fhocp/tests/support/counting.rs"]
mod counting;

use std::sync::Arc;

use controller::fhocp::Backend;
use controller::{Action, Config, Controller, Measurement, Pose};
use counting::count;
use vehicle_model::{CarParams, Discretized, Model, ModelKind, State, Track};

#[test]
fn no_allocation_in_closed_loop() {
    let car = CarParams::builtin("barc").unwrap();
    let track = Arc::new(Track::builtin("l").unwrap());
    let mut config = Config::default();
    // Also through the predictor of the delay.
    config.delay.steps = 1;
    let dt = config.horizon.period;
    let plant = Discretized { model: Model::new(ModelKind::Dynamic, car.clone()), dt, substeps: 5 };
    let mut x = State { v_x: config.warm_up.speed, ..State::default() };
    let mut acting = Default::default();
    let mut controller = Controller::new(config, car, track.clone()).unwrap();
    let (mut learned, mut structured) = (0, 0);
    for k in 0..2000_u32 {
        let pose = Pose::Frenet(State { s: track.wrap(x.s), ..x });
        let measurement = Measurement { time: f64::from(k) * dt, pose, applied: None };
        let due = controller.learning_pending();
        let start = count();
        controller.prepare();
        let prepared = count();
        let command = controller.step(&measurement);
        let stepped = count();
        let lap_end = command.status.finished.is_some();
        // The first learned lap lays out memory.
        if learned > 100 {
            if !due {
                assert_eq!(prepared - start, 0, "prepare, step {k}");
            }
            if !lap_end {
                assert_eq!(stepped - prepared, 0, "step {k}: {:?}", command.status);
            }
        }
        learned += u32::from(command.status.action == Action::Learned);
        structured += u32::from(command.status.solver == Some(Backend::Structured));
        if learned == 500 {
            break;
        }
        x = plant.next(&x, &acting, |s| track.kappa(s));
        acting = command.input;
    }
    assert_eq!(learned, 500, "the loop was driven");
    assert!(structured >= 500);
}
