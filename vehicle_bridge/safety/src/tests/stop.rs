//! The safe stop with a dead controller, on tracks, with a clock of the test's own.
#![allow(clippy::unwrap_used, reason = "code of tests")]

use std::sync::Arc;

use vehicle_model::{CarParams, Input, Plant, PlantParams, State, Track};

use super::*;

const TICK_NS: i64 = 10_000_000;
const POINTS: u32 = 20;

/// What is silent from the first command on.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Silent {
    Controller,
    /// The car's states too: the stop is driven by reckoning.
    States,
}

/// Drives into a silence at `speed` and `s`; the least distance to the edge until it stands.
fn least_margin(car: &CarParams, track: &Arc<Track>, s: f64, speed: f64, silent: Silent) -> f64 {
    let kappa = track.kappa(s);
    let mut rules = Rules::new(car, track, 10 * TICK_NS);
    (rules.ready_ns, rules.doubt) = (0, None);
    let wheelbase = car.l_f + car.l_r;
    let start = State { v_x: speed, omega_z: speed * kappa, s, ..State::default() };
    let mut plant = Plant::new(PlantParams::new(car.clone()), Arc::clone(track), start).unwrap();
    let mut safety = Safety::default();
    let mut now = TICK_NS;
    let tell = |safety: &mut Safety, event: &BridgeEvent<'_>, now: i64| {
        let (next, output) = step(&rules, safety, event, now);
        *safety = next;
        output
    };
    let moving = OrderKind::Arm { moving: true, controller: BootId::NONE };
    let order =
        |kind| BridgeEvent::Order(Order { kind, token: token(9), deadman: false, fresh: token(9) });
    for event in [
        BridgeEvent::State(start, 2),
        BridgeEvent::Heartbeat(CONTROLLER),
        BridgeEvent::Setup(CONTROLLER, rules.setup),
        BridgeEvent::Published(number(1)),
        order(moving),
        order(OrderKind::Start),
    ] {
        let answer = tell(&mut safety, &event, now).answer;
        assert!(!matches!(answer, Answer::Denied(_)), "{answer:?}");
    }
    let input = Input { a: 0.0, delta: (wheelbase * kappa).atan() };
    let offer = DecodedCommand {
        boot_id: CONTROLLER,
        seq: number(1),
        arrival: time(now),
        since: time(now),
        token: token(9),
        answers: Some(number(1)),
        drives: true,
        input,
        valid_for_ns: 10 * TICK_NS,
        ..DecodedCommand::default()
    };
    assert_eq!(tell(&mut safety, &BridgeEvent::Command(&offer), now).answer, Answer::Accepted);
    let mut least = f64::INFINITY;
    for _ in 0..6000 {
        let output = tell(&mut safety, &BridgeEvent::Tick, now);
        plant.apply(output.applied.sent, TICK_NS as f64 * 1e-9);
        now += TICK_NS;
        if silent == Silent::Controller {
            tell(&mut safety, &BridgeEvent::State(plant.measure(), 2), now);
        }
        let truth = plant.truth();
        let edge =
            (track.width_left(truth.s) - truth.e_y).min(track.width_right(truth.s) + truth.e_y);
        least = least.min(edge);
        if silent == Silent::States && truth.v_x < 0.05 {
            assert_eq!(safety.bridge_state(), BridgeState::SafeStop, "nobody knows that it stands");
            let why = safety.stop_reason();
            // The controller has nothing to answer: whichever is missed first.
            assert!(matches!(why, StopReason::States | StopReason::Validity), "{why:?}");
            return least;
        }
        if safety.bridge_state() == BridgeState::Idle {
            assert!(truth.v_x < 0.1, "{truth:?}");
            return least;
        }
    }
    // It never stood: worse than any margin.
    f64::NEG_INFINITY
}

/// What a car may have at `s`, up to `wanted` \[m/s\], that takes corners with the first share of its
/// grip and brakes for those ahead with the second.
fn speed_at(car: &CarParams, track: &Track, s: f64, wanted: f64, shares: (f64, f64)) -> f64 {
    let grip = 9.81 * car.tyre_front.mu.min(car.tyre_rear.mu);
    let brake = shares.1 * grip.min(-car.a_min);
    (0..400).fold(wanted, |least, i| {
        let ahead = f64::from(i) * 0.5;
        let corner = shares.0 * grip / track.kappa(track.wrap(s + ahead)).abs().max(1e-9);
        least.min((corner + 2.0 * brake * ahead).sqrt())
    })
}

/// Drives into a silence at each of `points` and stops inside the track.
fn stops_from(
    points: &[f64],
    car: &CarParams,
    track: &Arc<Track>,
    wanted: f64,
    shares: (f64, f64),
    silent: Silent,
) {
    let (mut slower, mut worst) = (0, f64::INFINITY);
    for &s in points {
        let speed = speed_at(car, track, s, wanted, shares);
        slower += u32::from(speed < wanted);
        worst = least_margin(car, track, s, speed, silent).min(worst);
    }
    #[allow(clippy::print_stdout, reason = "figures, seen with --nocapture")]
    {
        let count = points.len();
        println!(
            "{silent:?} {shares:?}: {slower} of {count} points below {wanted} m/s; margin {worst:.3} m"
        );
    }
    assert!(worst > 0.0, "least margin {worst:.3} m");
}

/// Twenty points, evenly spread over the lap.
fn over_the_lap(track: &Track) -> Vec<f64> {
    (0..POINTS).map(|i| track.length() * f64::from(i) / f64::from(POINTS)).collect()
}

#[test]
fn the_small_car_stops_inside_the_l_track_from_everywhere() {
    let car = CarParams::builtin("barc").unwrap();
    let track = Arc::new(Track::builtin("l").unwrap());
    let shares = (f64::INFINITY, f64::INFINITY);
    stops_from(&over_the_lap(&track), &car, &track, 3.5, shares, Silent::Controller);
}

/// 50 m/s at every point is no state of the IAC car: it could not have braked for the hairpins.
const IAC: (f64, (f64, f64)) = (50.0, (0.85, 0.75));

#[test]
fn the_iac_car_stops_inside_the_road_course_from_everywhere() {
    let car = CarParams::builtin("iac").unwrap();
    let track = Arc::new(Track::builtin("road_course").unwrap());
    stops_from(&over_the_lap(&track), &car, &track, IAC.0, IAC.1, Silent::Controller);
}

#[test]
fn the_iac_car_stops_inside_the_road_course_wherever_it_may_have_50_mps() {
    let car = CarParams::builtin("iac").unwrap();
    let track = Arc::new(Track::builtin("road_course").unwrap());
    let (wanted, shares) = IAC;
    let allowed: Vec<f64> = (0..)
        .map(f64::from)
        .take_while(|&s| s < track.length())
        .filter(|&s| speed_at(&car, &track, s, wanted, shares) >= wanted)
        .collect();
    // Evenly spread over these parts of the lap; then every metre of them.
    let count = POINTS as usize;
    let twenty: Vec<f64> = (1..=count).map(|i| allowed[allowed.len() * i / count - 1]).collect();
    for points in [&twenty, &allowed] {
        for silent in [Silent::Controller, Silent::States] {
            stops_from(points, &car, &track, wanted, shares, silent);
        }
    }
}

#[test]
fn without_states_the_iac_car_stops_inside_the_road_course_from_everywhere() {
    let car = CarParams::builtin("iac").unwrap();
    let track = Arc::new(Track::builtin("road_course").unwrap());
    stops_from(&over_the_lap(&track), &car, &track, IAC.0, IAC.1, Silent::States);
}
