//! Single cases at the edges, which chance does not meet or cannot tell apart.

use super::*;
use crate::hold::Hold;
use crate::stop::{brake, reckon};

fn offer() -> DecodedCommand {
    let mut plan = [Input::default(); PLAN];
    plan[..3].copy_from_slice(&[1.0, 1.5, 2.0].map(|a| Input { a, delta: 0.0 }));
    DecodedCommand {
        drives: true,
        arrival: time(1000 * MS),
        valid_for_ns: 200 * MS,
        input: Input { a: 0.5, delta: 0.0 },
        plan,
        n_plan: 3,
        plan_dt: 0.05,
        ..DecodedCommand::default()
    }
}

/// The acceleration asked, and whether it is the plan's.
fn at(offer: &DecodedCommand, age_ms: i64) -> Option<(f64, bool)> {
    offer.input_at(time((1000 + age_ms) * MS), 50 * MS).map(|(u, planned)| (u.a, planned))
}

#[test]
fn a_command_becomes_its_plan_and_then_nothing() {
    let offer = offer();
    assert_eq!(at(&offer, 0), Some((0.5, false)));
    assert_eq!(at(&offer, 50), Some((0.5, false)));
    assert_eq!(at(&offer, 51), Some((1.5, true)), "the plan's second step has begun");
    assert_eq!(at(&offer, 101), Some((2.0, true)));
    assert_eq!(at(&offer, 199), Some((2.0, true)), "its last step lasts");
    assert_eq!(at(&offer, 200), Some((2.0, true)));
    assert_eq!(at(&offer, 201), None);
    assert_eq!(at(&DecodedCommand { drives: false, ..offer }, 0), None);
    assert_eq!(at(&DecodedCommand { plan_dt: 0.0, ..offer }, 60), Some((1.0, true)));
    assert_eq!(at(&DecodedCommand { n_plan: 0, ..offer }, 60), Some((0.5, true)));
    // More steps than are kept are the steps that are kept.
    assert_eq!(DecodedCommand { n_plan: PLAN + 1, ..offer }.plan().len(), PLAN);
}

#[test]
fn the_box_gives_way_by_a_tolerance_and_no_more() {
    let limiter = rules().limiter;
    let within = |a: f64, delta: f64| {
        DecodedCommand { input: Input { a, delta }, ..offer() }.in_range(&limiter)
    };
    let plan_within = |a: f64, delta: f64| {
        let mut offer = offer();
        offer.input.a = 0.0;
        offer.plan[2] = Input { a, delta };
        offer.in_range(&limiter)
    };
    let (least, most, angle) = (limiter.a_min, limiter.a_max, limiter.delta_max);
    for (by, expected) in [(0.9e-4, true), (1.1e-4, false)] {
        for (a, delta) in
            [(least - by, 0.0), (most + by, 0.0), (0.0, angle + by), (0.0, -angle - by)]
        {
            assert_eq!(within(a, delta), expected, "{a} {delta}");
            assert_eq!(plan_within(a, delta), expected, "plan {a} {delta}");
        }
    }
}

#[test]
fn numbers_follow_in_a_window() {
    let follows = |seq: i64, last: Option<i64>| {
        DecodedCommand { seq: number(seq), ..offer() }.follows(last.map(number))
    };
    assert!(follows(i64::MIN, None));
    assert!(follows(6, Some(5)) && follows(105, Some(5)));
    assert!(!follows(5, Some(5)) && !follows(4, Some(5)) && !follows(106, Some(5)));
    // Numbers of an attacker's choice do not overflow.
    assert!(!follows(i64::MAX, Some(i64::MIN)) && !follows(i64::MIN, Some(i64::MAX)));
}

#[test]
fn between_two_states_the_car_is_reckoned_on_from_the_last_one() {
    let mut rules = rules();
    (rules.limiter.a_rate_max, rules.limiter.a_min) = (f64::INFINITY, -50.0);
    let mut safety = Safety::default();
    let mut tell = |event: BridgeEvent<'_>, at_ms: i64| {
        let (next, output) = step(&rules, &safety, &event, at_ms * MS);
        safety = next;
        output
    };
    let order =
        |kind| BridgeEvent::Order(Order { kind, token: token(9), deadman: false, fresh: token(9) });
    let moving = BridgeEvent::State(State { v_x: 2.0, ..State::default() }, 2);
    tell(moving, 900);
    tell(moving, 1000);
    tell(BridgeEvent::Heartbeat(CONTROLLER), 1000);
    tell(BridgeEvent::Setup(CONTROLLER, rules.setup), 1000);
    tell(BridgeEvent::Published(number(3)), 1000);
    tell(order(OrderKind::SpeedCap(1.5)), 1000);
    tell(order(OrderKind::Arm { moving: true, controller: BootId::NONE }), 1000);
    tell(order(OrderKind::Start), 1000);
    let offer = DecodedCommand {
        boot_id: CONTROLLER,
        token: token(9),
        answers: Some(number(3)),
        since: time(1000 * MS),
        input: Input { a: 1.0, delta: 0.0 },
        ..offer()
    };
    assert_eq!(tell(BridgeEvent::Command(&offer), 1000).answer, Answer::Accepted);
    // What is left of the cap in half a second tells the speed it is reckoned to have.
    let mut speed = |at_ms: i64| {
        let output = tell(BridgeEvent::Tick, at_ms);
        assert!(output.applied.by(Limit::SpeedCap));
        1.5 - 0.5 * output.applied.sent.a
    };
    assert!((speed(1000) - 2.0).abs() < 1e-12);
    // It brakes with 1 m/s^2: after 10 ms without a state, and 4 ms after one.
    assert!((speed(1010) - 1.99).abs() < 1e-12);
    tell(moving, 1016);
    let mut speed = |at_ms: i64| 1.5 - 0.5 * tell(BridgeEvent::Tick, at_ms).applied.sent.a;
    assert!((speed(1020) - (2.0 - 0.98 * 0.004)).abs() < 1e-12);
}

#[test]
fn an_input_that_came_late_is_followed_by_as_much_less() {
    let rules = rules();
    let mut safety = Safety::default();
    let mut tell = |event: BridgeEvent<'_>, at_ms: i64| {
        let (next, output) = step(&rules, &safety, &event, at_ms * MS);
        safety = next;
        output.applied.sent.a
    };
    tell(BridgeEvent::State(State { v_x: 3.0, ..State::default() }, 2), 1000);
    // It brakes as fast as the jerk limit of 20 m/s^3 lets it.
    let near = |a: f64, expected: f64| assert!((a - expected).abs() < 1e-12, "{a} {expected}");
    near(tell(BridgeEvent::Tick, 1000), -0.2);
    near(tell(BridgeEvent::Sent, 1000), -0.2);
    near(tell(BridgeEvent::Tick, 1010), -0.4);
    // Held up for 6 ms: the car has 4 ms of the next tick.
    tell(BridgeEvent::Sent, 1016);
    near(tell(BridgeEvent::Tick, 1020), -0.48);
    // Of the tick before, if nobody says when the car had it.
    near(tell(BridgeEvent::Tick, 1030), -0.68);
    tell(BridgeEvent::Sent, 1045);
    near(tell(BridgeEvent::Tick, 1050), -0.78);
}

#[test]
fn a_reckoned_car_does_not_roll_backwards_and_stays_on_the_lap() {
    let rules = rules();
    let x = State { v_x: 0.5, s: rules.track.length() - 1e-3, ..State::default() };
    let at_once = |a: f64| (Input { a, delta: 0.0 }, Input { a, delta: 0.0 });
    let next = reckon(&rules, &x, at_once(-2.0), 0.5).0;
    assert_eq!(next.v_x, 0.0);
    assert!((0.0..0.1).contains(&next.s), "{next:?}");
    // What cannot be reckoned stays as it was.
    assert_eq!(reckon(&rules, &x, at_once(f64::NAN), 0.1).0, x);
}

#[test]
fn below_half_a_metre_a_second_the_brake_stays_pressed() {
    let mut iac = CarParams::builtin("iac").unwrap();
    iac.a_min = -9.0;
    let track = Arc::new(Track::builtin("l").unwrap());
    let (small, large) = (rules(), Rules::new(&iac, &track, 50 * MS));
    let asked = |rules: &Rules, v_x: f64| {
        brake(rules, &State { v_x, ..State::default() }, Hold::default()).a
    };
    assert_eq!([0.0, 0.1].map(|v_x| asked(&small, v_x)), [-0.4, -0.4], "a fifth of 2 m/s^2");
    // Above it, braking fades with the speed.
    assert_eq!([0.499, 0.5, 1.0].map(|v_x| asked(&large, v_x)), [-1.8, -1.0, -2.0]);
    let rules = rules();
    // Left of the line it steers to the right.
    let u = brake(&rules, &State { v_x: 2.0, e_y: 0.2, ..State::default() }, Hold::default());
    assert!(u.a < 0.0 && u.delta < 0.0, "{u:?}");
}

#[test]
fn a_car_stands_below_the_limit_and_not_at_it() {
    let rules = rules();
    let arm = |speed: f64| {
        let moving = State { v_x: 0.6 * speed, v_y: 0.8 * speed, ..State::default() };
        let (safety, _) = step(&rules, &Safety::default(), &BridgeEvent::State(moving, 2), MS);
        let kind = OrderKind::Arm { moving: false, controller: BootId::NONE };
        let order =
            BridgeEvent::Order(Order { kind, token: token(0), deadman: false, fresh: token(1) });
        step(&rules, &safety, &order, MS).1.answer
    };
    let at = State { v_x: 0.6 * rules.still, v_y: 0.8 * rules.still, ..State::default() };
    assert_eq!(at.v_x.hypot(at.v_y), rules.still, "the test's own rounding");
    assert_eq!(arm(rules.still), Answer::Denied(Denied::Moves { speed: rules.still }));
    // It stands; what is missing next is a second of good states.
    assert_eq!(arm(0.99 * rules.still), Answer::Denied(Denied::NotGood { good_s: 0.0 }));
}

#[test]
fn a_second_controllers_life_signs_change_nothing_while_the_first_is_armed() {
    let rules = rules();
    let mut safety = Safety::default();
    let mut tell = |event: BridgeEvent<'_>, at_ms: i64| {
        let (next, output) = step(&rules, &safety, &event, at_ms * MS);
        safety = next;
        (safety, output.answer)
    };
    let order =
        |kind| BridgeEvent::Order(Order { kind, token: token(9), deadman: false, fresh: token(9) });
    let arm = OrderKind::Arm { moving: false, controller: BootId::NONE };
    let still = BridgeEvent::State(State::default(), 2);
    tell(still, 900);
    tell(still, 1000);
    tell(BridgeEvent::Setup(CONTROLLER, rules.setup), 1000);
    tell(BridgeEvent::Heartbeat(OTHER), 1000);
    tell(BridgeEvent::Heartbeat(CONTROLLER), 1000);
    let two = Denied::Controllers(CONTROLLER, OTHER);
    assert_eq!(tell(order(arm), 1000).1, Answer::Denied(two), "of two, none by itself");
    let chosen = |controller| order(OrderKind::Arm { moving: false, controller });
    let other = Denied::OtherController { wanted: BootId::new(5), heard: CONTROLLER };
    assert_eq!(tell(chosen(BootId::new(5)), 1000).1, Answer::Denied(other));
    assert_eq!(tell(chosen(OTHER), 1000).1, Answer::Denied(Denied::NoSetup));
    assert_eq!(tell(chosen(CONTROLLER), 1000).1, Answer::Accepted);
    let refused = Answer::Rejected(Reject::Boot);
    for (n, at_ms) in (1010..=1150).step_by(10).enumerate() {
        tell(still, at_ms);
        let (safety, answer) = tell(BridgeEvent::Heartbeat(OTHER), at_ms);
        assert_eq!((safety.bridge_state(), answer), (BridgeState::Armed, refused));
        assert_eq!(
            safety.counts(),
            CommandCounts { old: n as i64 + 1, ..CommandCounts::default() }
        );
    }
    // The armed controller's are missed as without it.
    let (safety, answer) = tell(BridgeEvent::Heartbeat(OTHER), 1151);
    assert_eq!(
        (safety.bridge_state(), safety.stop_reason()),
        (BridgeState::Idle, StopReason::Heartbeat)
    );
    assert_eq!(answer, Answer::None, "in IDLE each is taken");
    tell(BridgeEvent::Setup(OTHER, rules.setup), 1152);
    let arm = OrderKind::Arm { moving: false, controller: OTHER };
    assert_eq!(tell(order(arm), 1152).1, Answer::Accepted);
    assert_eq!(tell(order(OrderKind::Start), 1153).1, Answer::Accepted);
    assert_eq!(tell(BridgeEvent::Heartbeat(CONTROLLER), 1154).1, refused, "nor while it drives");
    assert_eq!(tell(BridgeEvent::Heartbeat(OTHER), 1155).1, Answer::None);
}

#[test]
fn a_state_is_called_by_its_number() {
    use BridgeState::{Armed, Boot, Estop, Fault, Idle, Running, SafeStop};
    let names = ["BOOT", "IDLE", "ARMED", "RUNNING", "SAFE_STOP", "FAULT", "ESTOP"];
    let phases = [Boot, Idle, Armed, Running, SafeStop, Fault, Estop];
    for (bridge_state, name) in phases.into_iter().zip(names) {
        assert_eq!((bridge_state.name(), BridgeState::name_of(bridge_state as i8)), (name, name));
    }
    assert_eq!(BridgeState::name_of(i8::MAX), "unknown");
}

/// A core that runs by the token 9, deadline of commands far away.
fn running(rules: &Rules) -> Safety {
    let mut safety = Safety::default();
    let order =
        |kind| BridgeEvent::Order(Order { kind, token: token(0), deadman: false, fresh: token(9) });
    let start = Order { kind: OrderKind::Start, token: token(9), deadman: false, fresh: token(9) };
    let still = BridgeEvent::State(State::default(), 2);
    for (event, at_ms) in [
        (still, 900),
        (still, 1000),
        (BridgeEvent::Heartbeat(CONTROLLER), 1000),
        (BridgeEvent::Setup(CONTROLLER, rules.setup), 1000),
        (order(OrderKind::Arm { moving: false, controller: BootId::NONE }), 1000),
        (BridgeEvent::Order(start), 1000),
    ] {
        safety = step(rules, &safety, &event, at_ms * MS).0;
    }
    assert_eq!(safety.bridge_state(), BridgeState::Running);
    safety
}

#[test]
fn a_dead_mans_switch_claimed_after_the_start_is_in_force() {
    let rules = rules();
    let mut safety = running(&rules);
    let start = |deadman| {
        BridgeEvent::Order(Order {
            kind: OrderKind::Start,
            token: token(9),
            deadman,
            fresh: token(9),
        })
    };
    let mut tell = |event: BridgeEvent<'_>, at_ms: i64| {
        let (next, output) = step(&rules, &safety, &event, at_ms * MS);
        safety = next;
        (safety.bridge_state(), safety.stop_reason(), output.answer)
    };
    let still = BridgeEvent::State(State::default(), 2);
    assert_eq!(tell(start(false), 1010).0, BridgeState::Running, "repeated");
    assert_eq!(tell(start(true), 1020), (BridgeState::Running, StopReason::None, Answer::Accepted));
    tell(still, 1100);
    assert_eq!(tell(still, 1120).0, BridgeState::Running);
    assert_eq!(tell(still, 1121), (BridgeState::SafeStop, StopReason::Deadman, Answer::Accepted));
}

#[test]
fn a_bridge_that_ends_stops_the_car_first() {
    let rules = rules();
    let safety = running(&rules);
    let ended = step(&rules, &safety, &BridgeEvent::End, 1010 * MS).0;
    assert_eq!(
        (ended.bridge_state(), ended.stop_reason()),
        (BridgeState::SafeStop, StopReason::End)
    );
    assert_eq!((ended.token().get(), ended.counts().stops), (0, 1));
    let order =
        |kind| BridgeEvent::Order(Order { kind, token: token(0), deadman: false, fresh: token(9) });
    let idle = step(&rules, &ended, &BridgeEvent::Tick, 1011 * MS).0;
    assert_eq!(idle.bridge_state(), BridgeState::Idle, "it stands");
    let armed = step(
        &rules,
        &idle,
        &order(OrderKind::Arm { moving: false, controller: BootId::NONE }),
        1012 * MS,
    )
    .0;
    assert_eq!(armed.bridge_state(), BridgeState::Armed);
    assert_eq!(
        step(&rules, &armed, &BridgeEvent::End, 1013 * MS).0.bridge_state(),
        BridgeState::Idle
    );
    let stopped = step(&rules, &armed, &order(OrderKind::Estop), 1013 * MS).0;
    assert_eq!(step(&rules, &stopped, &BridgeEvent::End, 1014 * MS).0, stopped, "it stays latched");
}

#[test]
fn a_controller_is_armed_only_with_the_bridges_own_setup() {
    let mut rules = rules();
    rules.setup.config_id = 4;
    let mut idle = Safety::default();
    let still = BridgeEvent::State(State::default(), 2);
    for (event, at_ms) in [(still, 900), (still, 1000), (BridgeEvent::Heartbeat(CONTROLLER), 1000)]
    {
        idle = step(&rules, &idle, &event, at_ms * MS).0;
    }
    let arm = OrderKind::Arm { moving: false, controller: BootId::NONE };
    let arm =
        BridgeEvent::Order(Order { kind: arm, token: token(0), deadman: false, fresh: token(9) });
    let armed = |setup: Setup| {
        let told = step(&rules, &idle, &BridgeEvent::Setup(CONTROLLER, setup), 1000 * MS).0;
        match step(&rules, &told, &arm, 1000 * MS).1.answer {
            Answer::Denied(denied) => word(&denied),
            answer => word(&answer),
        }
    };
    let ours = rules.setup;
    assert_eq!(armed(ours), "Accepted");
    assert_eq!(armed(Setup { track_id: ours.track_id + 1, ..ours }), "Track");
    assert_eq!(armed(Setup { track_id: 0, ..ours }), "Track", "which track is always compared");
    assert_eq!(armed(Setup { car_id: ours.car_id + 1, ..ours }), "Car");
    assert_eq!(armed(Setup { period_ns: ours.period_ns + 1, ..ours }), "Period");
    assert_eq!(armed(Setup { config_id: ours.config_id + 1, ..ours }), "Config");
    let unknown = Setup { car_id: 0, period_ns: 0, config_id: 0, ..ours };
    assert_eq!(armed(unknown), "Accepted", "what a controller does not know is not compared");
}
