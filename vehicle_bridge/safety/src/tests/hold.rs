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
    /// Whether it still counts as creeping after another START.
    creeps_on: bool,
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
    let mut tell = |event: &BridgeEvent<'_>, now: i64| {
        let (next, output) = step(&rules, &safety, event, now);
        safety = next;
        (safety, output)
    };
    let order =
        |kind| BridgeEvent::Order(Order { kind, token: token(9), deadman: false, fresh: token(9) });
    let mut now = MS;
    tell(&BridgeEvent::State(start, 2), now);
    tell(&BridgeEvent::Heartbeat(CONTROLLER), now);
    tell(&BridgeEvent::Setup(CONTROLLER, rules.setup), now);
    tell(&order(OrderKind::Arm { moving: true, controller: BootId::NONE }), now);
    tell(&order(OrderKind::Start), now);
    tell(&order(OrderKind::Stop), now);
    let (mut held, mut at_15_s, mut end) = (Input::default(), 0.0, None);
    for n in 0..2000 {
        let u = Input { a: held.a + bias, ..held };
        plant.apply(u, TICK);
        now += 10 * MS;
        tell(&BridgeEvent::State(plant.measure(), 2), now);
        let (safety, output) = tell(&BridgeEvent::Tick, now);
        held = output.applied.sent;
        if n == 1500 {
            at_15_s = plant.progress();
        }
        end = Some((safety, output));
    }
    let (safety, output) = end.unwrap();
    tell(&BridgeEvent::Heartbeat(CONTROLLER), now);
    tell(&order(OrderKind::Arm { moving: true, controller: BootId::NONE }), now);
    let creeps_on = tell(&order(OrderKind::Start), now).0.creeps();
    Stopped {
        creeps_on,
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
            assert_eq!((end.state, end.creeps_on), (BridgeState::Idle, false), "{about}");
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

#[test]
fn at_each_of_its_limits_the_brake_is_what_it_was() {
    let rules = rules();
    let at = |hold: &mut Hold, v_x: f64, at_ms: i64| {
        hold.on_state(&rules, &State { v_x, ..State::default() }, time(at_ms * MS));
        hold.creeps()
    };
    let after = |speeds: [(f64, i64); 3]| {
        let mut hold = Hold::default();
        speeds.map(|(v_x, at_ms)| at(&mut hold, v_x, at_ms))
    };
    assert_eq!(
        after([(rules.still, 0), (rules.still, 4500), (rules.still, 4501)]),
        [false, false, true]
    );
    let below = rules.still.next_down();
    assert_eq!(after([(below, 0), (below, 4500), (below, 9000)]), [false; 3], "it stands");
    assert_eq!(after([(2.0, 0), (2.0, 4500), (2.0, 9000)]), [false; 3], "too fast to be held");
    assert_eq!(after([(0.5, 0), (0.7, 10), (0.9, 20)]), [false; 3], "not yet held");
    assert_eq!(
        after([(0.45, 0), (0.3, 10), (0.41, 20)]),
        [false, false, true],
        "since it was slowest"
    );
    let faster = 0.3 + rules.still;
    assert_eq!(after([(0.3, 0), (faster, 10), (faster.next_up(), 20)]), [false, false, true]);
    // What it asks for, before and after it was pressed.
    let track = Arc::new(Track::builtin("l").unwrap());
    let mut iac = CarParams::builtin("iac").unwrap();
    iac.a_min = -9.0;
    let asked = Input { a: -0.1, delta: 0.2 };
    for (rules, held, most) in
        [(&rules, -0.4, 2.0), (&Rules::new(&iac, &track, 50 * MS), -1.8, 4.5)]
    {
        let mut hold = Hold::default();
        let a = |hold: &Hold, v_x: f64| hold.apply(rules, v_x, asked).a;
        assert_eq!([a(&hold, 0.5_f64.next_down()), a(&hold, 0.5)], [held, -0.1]);
        hold.press();
        let full = rules.limiter.a_min;
        assert_eq!(
            [a(&hold, 0.0), a(&hold, f64::next_down(most)), a(&hold, most)],
            [full, full, -0.1]
        );
        assert!(!hold.creeps(), "nothing moved");
        assert_eq!(
            hold.apply(rules, 0.0, Input { a: -20.0, delta: 0.2 }),
            Input { a: -20.0, delta: 0.2 }
        );
    }
}
