//! Lies of sensors and faults of actuators in simulated drives, and drives that must not be stopped.

use rand_distr::{Distribution as _, Normal};
use vehicle_model::{Plant, PlantParams};

use super::*;

const TICK: f64 = 0.01;

/// What is wrong from a moment on.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Fault {
    Nothing,
    Frozen,
    PositionFrozen,
    Jump(f64),
    Speed(f64),
    Yaw(f64),
    Drift(f64),
    ThrottleStuck,
    ThrottleBias(f64),
    SteeringStuck,
    SteeringBias(f64),
    NoStates,
}

/// What became of a drive.
#[derive(Debug)]
struct Drive {
    /// Time from the fault to the stop. \[s\]
    detected: Option<f64>,
    why: StopReason,
    /// How far a corner of the body was beyond the edge, at most. \[m\]
    beyond: f64,
    /// Worst level before the fault. \[-\]
    before: f64,
    /// It moved on against the brake that holds it.
    creeps: bool,
}

fn follow(rules: &Rules, x: &State, speed: f64) -> Input {
    let brake = rules.tracker.brake(x, &rules.track);
    let a = ((speed - x.v_x) / 0.4).clamp(rules.limiter.a_min, rules.limiter.a_max);
    Input { a, ..brake }
}

/// An order that the core obeys.
fn order(kind: OrderKind) -> BridgeEvent<'static> {
    BridgeEvent::Order(Order { kind, token: token(9), deadman: false, fresh: token(9) })
}

/// The controller's command on state `n`.
fn answer(n: i64, input: Input, now: i64) -> DecodedCommand {
    DecodedCommand {
        boot_id: CONTROLLER,
        seq: number(n),
        arrival: time(now),
        since: time(now),
        answers: Some(number(n)),
        token: token(9),
        drives: true,
        input,
        valid_for_ns: 100 * MS,
        ..DecodedCommand::default()
    }
}

/// A lap at `speed`, with the fault from `s` on until the car stands.
fn drive(fault: Fault, speed: f64, from_s: f64, seed: u64) -> Drive {
    drive_as(&CarParams::builtin("barc").unwrap(), 0.001, fault, speed, from_s, seed)
}

/// The same with another car than the bridge knows, and other noise.
fn drive_as(
    real: &CarParams,
    noise: f64,
    fault: Fault,
    speed: f64,
    from_s: f64,
    seed: u64,
) -> Drive {
    let car = CarParams::builtin("barc").unwrap();
    let track = Arc::new(Track::builtin("l").unwrap());
    let mut rules = Rules::new(&car, &track, 10 * MS);
    rules.ready_ns = 0;
    let mut plant =
        Plant::new(PlantParams::new(real.clone()), Arc::clone(&track), State::default()).unwrap();
    let mut random = Pcg64::seed_from_u64(seed);
    let noise = Normal::new(0.0, noise).unwrap();
    let mut safety = Safety::default();
    let mut now = MS;
    let mut tell = |event: &BridgeEvent<'_>, now: i64| {
        let (next, output) = step(&rules, &safety, event, now);
        safety = next;
        (safety, output)
    };
    tell(&BridgeEvent::State(State::default(), 2), now);
    tell(&BridgeEvent::Heartbeat(CONTROLLER), now);
    tell(&BridgeEvent::Setup(CONTROLLER, rules.setup), now);
    tell(&order(OrderKind::Arm { moving: false, controller: BootId::NONE }), now);
    tell(&order(OrderKind::Start), now);
    let mut held = Input::default();
    let mut seen = State::default();
    let (mut begun, mut stuck) = (None, Input::default());
    let (why, beyond) = (StopReason::None, f64::MIN);
    let mut drive = Drive { detected: None, why, beyond, before: 0.0, creeps: false };
    let mut running = true;
    for n in 0..4000 {
        let mut u = held;
        if begun.is_some() {
            match fault {
                Fault::ThrottleStuck => u.a = stuck.a.max(0.5),
                Fault::ThrottleBias(by) => u.a += by,
                Fault::SteeringStuck => u.delta = stuck.delta,
                Fault::SteeringBias(by) => u.delta += by,
                _ => {}
            }
        }
        plant.apply(u, TICK);
        now += 10 * MS;
        let truth = plant.truth();
        let mut x = truth;
        for place in [&mut x.v_x, &mut x.v_y, &mut x.omega_z, &mut x.e_psi, &mut x.s, &mut x.e_y] {
            *place += noise.sample(&mut random);
        }
        x.s = track.wrap(x.s);
        if begun.is_none() && plant.progress() > from_s {
            (begun, stuck) = (Some((now, seen)), u);
        }
        if let Some((at, first)) = begun {
            let since = (now - at) as f64 * 1e-9;
            match fault {
                Fault::Frozen => x = first,
                Fault::PositionFrozen => (x.s, x.e_y) = (first.s, first.e_y),
                Fault::Jump(by) => x.e_y += by,
                Fault::Speed(share) => x.v_x *= share,
                Fault::Yaw(by) => x.e_psi += by,
                Fault::Drift(rate) => x.e_y += rate * since,
                _ => {}
            }
            drive.beyond = drive.beyond.max(crate::doubt::beyond(&rules, &truth));
        }
        seen = x;
        let silent = begun.is_some() && fault == Fault::NoStates;
        if !silent {
            tell(&BridgeEvent::State(x, 2), now);
            tell(&BridgeEvent::Published(number(n)), now);
            let input = follow(&rules, &x, speed);
            tell(&BridgeEvent::Command(&answer(n, input, now)), now);
        }
        let (safety, output) = tell(&BridgeEvent::Tick, now);
        held = output.applied.sent;
        drive.creeps = safety.creeps();
        if begun.is_none() {
            drive.before = drive.before.max(safety.finding().level);
        }
        if running && safety.bridge_state() != BridgeState::Running {
            running = false;
            drive.why = safety.stop_reason();
            drive.detected = begun.map(|(at, _)| (now - at) as f64 * 1e-9);
        }
        if truth.v_x < 0.05 && n > 200 {
            break;
        }
    }
    drive
}

/// How far the body was beyond the edge, at most. \[m\]
fn stopped_by(fault: Fault, what: &[Suspicion], most_s: f64) -> f64 {
    let (mut slowest, mut farthest, mut level) = (0.0_f64, f64::MIN, 0.0_f64);
    for (seed, s) in (0..10).map(|i| (i, 4.0 + 1.7 * i as f64)) {
        for speed in [2.0, 3.0] {
            let drive = drive(fault, speed, s, seed);
            let detected = drive.detected.unwrap_or(f64::INFINITY);
            let named = what.iter().any(|w| drive.why == StopReason::Doubt(*w));
            assert!(named && detected <= most_s, "{fault:?} at s {s}, {speed} m/s: {drive:?}");
            slowest = slowest.max(detected);
            farthest = farthest.max(drive.beyond);
            level = level.max(drive.before);
        }
    }
    #[allow(clippy::print_stdout, reason = "figures, seen with --nocapture")]
    {
        println!(
            "{fault:?}: stopped within {slowest:.2} s, body at most {farthest:.2} m out; level before {level:.2}"
        );
    }
    farthest
}

#[test]
fn a_drive_without_a_fault_is_not_stopped() {
    for (seed, speed) in [1.0, 2.0, 3.0, 3.5].into_iter().enumerate() {
        let drive = drive(Fault::Nothing, speed, 1e9, seed as u64);
        assert_eq!(drive.why, StopReason::None, "{speed} m/s: {drive:?}");
        assert!(drive.before < 0.75 && !drive.creeps, "{speed} m/s: {drive:?}");
    }
}

#[test]
fn another_grip_lag_or_noise_than_known_is_no_fault() {
    let known = CarParams::builtin("barc").unwrap();
    let (mut level, mut seed) = (0.0_f64, 0);
    for (mu, fastest) in [(0.6, 2.2), (0.9, 3.0), (1.2, 3.0)] {
        for lag in [0.0, 0.05, 0.1] {
            for noise in [0.001, 0.01] {
                let real = CarParams { actuator_lag: lag, ..known.clone().with_mu(mu) };
                for speed in [1.2, fastest] {
                    seed += 1;
                    let drive = drive_as(&real, noise, Fault::Nothing, speed, 1e9, seed);
                    let about = format!("mu {mu}, lag {lag} s, noise {noise}, {speed} m/s");
                    assert_eq!(drive.why, StopReason::None, "{about}: {drive:?}");
                    level = level.max(drive.before);
                }
            }
        }
    }
    #[allow(clippy::print_stdout, reason = "figures, seen with --nocapture")]
    {
        println!("another car than known: level at most {level:.2}");
    }
}

#[test]
fn lies_about_the_position_are_found() {
    use Suspicion::{Drive, Heading, OffTrack, Position, Steering};
    stopped_by(Fault::Frozen, &[Position, Heading], 0.5);
    stopped_by(Fault::PositionFrozen, &[Position, Heading], 0.5);
    stopped_by(Fault::Jump(0.3), &[Position, OffTrack], 0.2);
    stopped_by(Fault::Speed(0.7), &[Position, Heading, Drive, Steering], 1.0);
    stopped_by(Fault::Yaw(0.087), &[Position, Heading], 3.0);
}

#[test]
fn faults_of_the_actuators_are_found() {
    use Suspicion::{Drive, OffTrack, Steering};
    // From 3 m/s the brakes take 2.25 m.
    assert!(stopped_by(Fault::SteeringStuck, &[Steering, OffTrack], 3.0) < 1.75);
    assert!(stopped_by(Fault::SteeringBias(0.15), &[Steering, OffTrack], 3.0) < 0.75);
    assert!(stopped_by(Fault::ThrottleStuck, &[Drive, OffTrack], 12.0) < 0.1);
}

#[test]
fn a_car_whose_throttle_is_doubted_is_held_with_all_the_brake_from_the_first() {
    for (seed, s) in [(1, 4.0), (2, 9.0), (3, 14.0)] {
        let found = drive(Fault::ThrottleBias(1.2), 2.0, s, seed);
        assert_eq!(found.why, StopReason::Doubt(Suspicion::Drive), "{found:?}");
        assert!(!found.creeps && found.beyond < 0.0, "{found:?}");
    }
}

#[test]
fn a_slow_drift_of_the_position_is_found_by_the_bends() {
    // 20 mm/s across the track is a heading error of half a degree at 2 m/s, which is allowed; but
    // a car that is farther out in a bend than it says takes longer through it.
    for (seed, s) in [(1, 4.0), (2, 9.0), (3, 14.0)] {
        let found = drive(Fault::Drift(0.02), 2.0, s, seed);
        assert!(matches!(found.why, StopReason::Doubt(_)) && found.beyond < 0.0, "{found:?}");
    }
}

#[test]
fn a_stop_without_states_stays_on_the_track() {
    let mut worst = f64::MIN;
    for i in 0..20_u32 {
        for speed in [3.0, 3.5] {
            let drive = drive(Fault::NoStates, speed, 18.0 + 0.95 * f64::from(i), i.into());
            // Without states the controller is silent, too: whichever is missed first.
            assert!(matches!(drive.why, StopReason::States | StopReason::Validity), "{drive:?}");
            worst = worst.max(drive.beyond);
        }
    }
    #[allow(clippy::print_stdout, reason = "figures, seen with --nocapture")]
    {
        println!("without states: body at most {worst:.2} m out");
    }
    // At the edge of what braking along the track can do, with a last state that was noisy.
    assert!(worst < 0.05, "{worst:.2} m out");
}

/// What is sent of a full throttle to a car that rolls at `speed` across the track. \[m/s^2\]
fn throttle_across_the_track(speed: f64) -> f64 {
    let car = CarParams::builtin("barc").unwrap();
    let track = Arc::new(Track::builtin("l").unwrap());
    let rules = Rules { ready_ns: 0, ..Rules::new(&car, &track, 10 * MS) };
    let mut safety = Safety::default();
    let mut now = MS;
    let across = |at: f64| State { v_x: speed, e_psi: 1.45, s: 1.0, e_y: at, ..State::default() };
    for event in [
        BridgeEvent::State(across(0.0), 2),
        BridgeEvent::Heartbeat(CONTROLLER),
        BridgeEvent::Setup(CONTROLLER, rules.setup),
        order(OrderKind::Arm { moving: true, controller: BootId::NONE }),
        order(OrderKind::Start),
        BridgeEvent::Published(number(1)),
    ] {
        safety = step(&rules, &safety, &event, now).0;
    }
    now += 10 * MS;
    let offer = answer(1, Input { a: car.a_max, delta: 0.0 }, now);
    for event in [
        BridgeEvent::State(across(speed * TICK), 2),
        BridgeEvent::Published(number(2)),
        BridgeEvent::Command(&offer),
    ] {
        safety = step(&rules, &safety, &event, now).0;
    }
    assert_eq!(safety.finding().what, Suspicion::WrongWay);
    assert_eq!(safety.finding().reaction(), Reaction::SlowDown);
    let (safety, output) = step(&rules, &safety, &BridgeEvent::Tick, now);
    assert_eq!(safety.bridge_state(), BridgeState::Running);
    output.applied.sent.a
}

#[test]
fn a_doubted_car_is_accelerated_up_to_a_crawl_and_no_further() {
    let car = CarParams::builtin("barc").unwrap();
    let crawl = DoubtLimits::new(&car, &Track::builtin("l").unwrap()).crawl;
    assert!((0.5 * crawl * crawl / -car.a_min - 0.5 * car.width).abs() < 1e-12, "{crawl} m/s");
    for standing in [0.0, 0.99 * crawl] {
        assert!(throttle_across_the_track(standing) > 0.5, "{standing} m/s");
    }
    assert!(throttle_across_the_track(1.01 * crawl) <= 0.0);
}
