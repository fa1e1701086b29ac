//! A car is held where it stopped, also by a brake against a throttle that is off or on a slope.

use vehicle_model::{Plant, PlantParams};

use super::*;
use crate::hold::Hold;

const TICK: f64 = 0.01;

/// A car that is stopped by the operator from 2 m/s with a throttle that is off by `bias` \[m/s^2\].
struct Stopped {
    /// Driven in the last five of 20 s. \[m\]
    crept: f64,
    /// Speed at the end. \[m/s\]
    speed: f64,
    creeps: bool,
    /// Acceleration asked for at the end. \[m/s^2\]
    asked: f64,
    state: BridgeState,
}

fn stopped(car: &CarParams, bias: f64) -> Stopped {
    let track = Arc::new(Track::builtin("l").unwrap());
    let mut rules = Rules::new(car, &track, 10 * MS);
    rules.ready_ns = 0;
    // The operator stops it, not a doubt.
    rules.doubt = None;
    let start = State { v_x: 2.0, ..State::default() };
    let mut plant = Plant::new(PlantParams::new(car.clone()), track, start).unwrap();
    let mut safety = Safety::default();
    let mut tell = |event: &Event<'_>, now: i64| {
        let (next, output) = step(&rules, &safety, event, now);
        safety = next;
        (safety, output)
    };
    let order =
        |kind| Event::Order(Order { kind, token: token(9), deadman: false, fresh: token(9) });
    let mut now = MS;
    tell(&Event::State(start, 2), now);
    tell(&Event::Heartbeat(CONTROLLER), now);
    tell(&Event::Setup(CONTROLLER, rules.setup), now);
    tell(&order(OrderKind::Arm { moving: true, controller: BootId::NONE }), now);
    tell(&order(OrderKind::Start), now);
    tell(&order(OrderKind::Stop), now);
    let (mut held, mut at_15_s, mut end) = (Input::default(), 0.0, None);
    for n in 0..2000 {
        let u = Input { a: held.a + bias, ..held };
        plant.apply(u, TICK);
        now += 10 * MS;
        tell(&Event::State(plant.measure(), 2), now);
        let (safety, output) = tell(&Event::Tick, now);
        held = output.applied.sent;
        if n == 1500 {
            at_15_s = plant.progress();
        }
        end = Some((safety, output));
    }
    let (safety, output) = end.unwrap();
    Stopped {
        crept: plant.progress() - at_15_s,
        speed: plant.truth().v_x,
        creeps: safety.creeps(),
        asked: output.applied.asked.a,
        state: safety.bridge_state(),
    }
}

#[test]
fn a_car_stands_whatever_its_throttle_is_off_by_and_the_brake_can_hold() {
    let mut iac = CarParams::builtin("iac").unwrap();
    iac.a_min = -9.0;
    for car in [CarParams::builtin("barc").unwrap(), iac] {
        for share in [0.0, 0.05, 0.1, 0.15, 0.21, 0.3, 0.6] {
            let bias = -share * car.a_min;
            let end = stopped(&car, bias);
            let about =
                format!("{}, {bias} m/s^2 off: {:.3} m/s, {:.3} m", car.name, end.speed, end.crept);
            assert!(end.speed < 0.01 && end.crept < 0.01, "{about}");
            assert_eq!(end.state, BridgeState::Idle, "{about}");
            // The usual brake fades from 2 m/s to 0.5 m/s, then stays; beyond both it is pressed and
            // the car's motion named.
            assert!(end.creeps || share < 0.2, "{about}");
            assert!(!end.creeps || share > 0.1, "{about}");
            let brake = if end.creeps { 1.0 } else { 0.2 };
            assert!((end.asked - brake * car.a_min).abs() < 1e-9, "{about}: {}", end.asked);
        }
    }
}

#[test]
fn a_throttle_beyond_all_the_brake_there_is_is_named() {
    let car = CarParams::builtin("barc").unwrap();
    let end = stopped(&car, 2.2);
    assert!(end.creeps || end.speed > 2.0, "{:.2} m/s", end.speed);
    assert!(end.asked < -0.5, "it goes on to brake: {}", end.asked);
}

#[test]
fn a_start_begins_with_the_usual_brake() {
    let rules = rules();
    let mut hold = Hold::default();
    let at = |hold: &mut Hold, v_x: f64, at_ms: i64| {
        hold.on_state(&rules, &State { v_x, ..State::default() }, time(at_ms * MS));
        hold.creeps()
    };
    // From 0.5 m/s the brake of 0.4 m/s^2 needs 1.25 s; twice that and 2 s it may take from 2 m/s on.
    assert!(!at(&mut hold, 2.1, 0) && !at(&mut hold, 1.9, 100) && !at(&mut hold, 0.6, 4590));
    assert!(at(&mut hold, 0.6, 4610));
    // Or it becomes faster, by more than what counts as standing.
    let mut hold = Hold::default();
    assert!(!at(&mut hold, 0.3, 0) && !at(&mut hold, 0.39, 10));
    assert!(at(&mut hold, 0.41, 20));
    // A car that stood in between is not slow since then.
    let mut hold = Hold::default();
    assert!(!at(&mut hold, 0.3, 0) && !at(&mut hold, 0.0, 10) && !at(&mut hold, 0.39, 20));
    assert!(!at(&mut hold, 0.3, 3000) && !at(&mut hold, 0.3, 4510) && at(&mut hold, 0.3, 4530));
    // Faster again above that is what a throttle does that closes slowly.
    let mut hold = Hold::default();
    assert!(!at(&mut hold, 1.4, 0) && !at(&mut hold, 1.8, 400) && !at(&mut hold, 0.4, 2000));
}
