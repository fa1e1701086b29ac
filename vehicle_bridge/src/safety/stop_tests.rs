//! The safe stop with a dead controller, on tracks, with a clock of the test's own.
#![allow(clippy::unwrap_used, clippy::panic, reason = "code of tests")]

use std::sync::Arc;

use vehicle_model::{CarParams, Input, Plant, PlantParams, State, Track};

use super::*;

const TICK_NS: i64 = 10_000_000;
const POINTS: u32 = 20;

/// Drives into a silence at `speed` and `s`; the least distance to the edge until it stands.
fn least_margin(car: &CarParams, track: &Arc<Track>, s: f64, speed: f64) -> f64 {
    let kappa = track.kappa(s);
    let mut rules = Rules::new(car, track, 10 * TICK_NS);
    rules.ready_ns = 0;
    let wheelbase = car.l_f + car.l_r;
    let start = State { v_x: speed, omega_z: speed * kappa, s, ..State::default() };
    let mut plant = Plant::new(PlantParams::new(car.clone()), Arc::clone(track), start).unwrap();
    let mut safety = Safety::default();
    let mut now = TICK_NS;
    let tell = |safety: &mut Safety, event: &Event<'_>, now: i64| {
        let (next, output) = step(&rules, safety, event, now);
        *safety = next;
        output
    };
    let moving = OrderKind::Arm { moving: true };
    let order = |kind| Event::Order(Order { kind, token: 9, deadman: false, fresh: 9 });
    for event in [
        Event::State(start, 2),
        Event::Pulse(7),
        Event::Track(7, rules.track_id),
        order(moving),
        order(OrderKind::Start),
    ] {
        let answer = tell(&mut safety, &event, now).answer;
        assert!(!matches!(answer, Answer::Denied(_)), "{answer:?}");
    }
    let input = Input { a: 0.0, delta: (wheelbase * kappa).atan() };
    let offer = Offer {
        boot_id: 7,
        seq: 1,
        arrival_ns: now,
        since_ns: now,
        token: 9,
        drives: true,
        input,
        valid_for_ns: 10 * TICK_NS,
        ..Offer::default()
    };
    assert_eq!(tell(&mut safety, &Event::Command(&offer), now).answer, Answer::Accepted);
    let mut least = f64::INFINITY;
    for _ in 0..6000 {
        let output = tell(&mut safety, &Event::Tick, now);
        plant.apply(output.applied.sent, TICK_NS as f64 * 1e-9);
        now += TICK_NS;
        let x = plant.measure();
        tell(&mut safety, &Event::State(x, 2), now);
        let truth = plant.truth();
        let edge =
            (track.width_left(truth.s) - truth.e_y).min(track.width_right(truth.s) + truth.e_y);
        least = least.min(edge);
        if safety.phase() == Phase::Idle {
            assert!(truth.v_x < 0.1, "{truth:?}");
            return least;
        }
    }
    panic!("{} m/s at {s} m: did not stop: {:?} {:?}", speed, safety.phase(), plant.truth());
}

/// Twenty points of the lap; `wanted` where the corner allows it.
fn stops(car: &str, track: &str, wanted: f64) {
    let car = CarParams::builtin(car).unwrap();
    let track = Arc::new(Track::builtin(track).unwrap());
    let grip = 9.81 * car.tyre_front.mu.min(car.tyre_rear.mu);
    let (mut slower, mut worst) = (0, f64::INFINITY);
    for point in 0..POINTS {
        let s = track.length() * f64::from(point) / f64::from(POINTS);
        // What a racing controller could have at this point and ahead, braking at 0.6 of the grip.
        let brake = 0.6 * grip.min(-car.a_min);
        let speed = (0..400).fold(wanted, |least, i| {
            let ahead = f64::from(i) * 0.5;
            let corner = 0.7 * grip / track.kappa(track.wrap(s + ahead)).abs().max(1e-9);
            least.min((corner + 2.0 * brake * ahead).sqrt())
        });
        slower += u32::from(speed < wanted);
        let margin = least_margin(&car, &track, s, speed);
        worst = worst.min(margin);
        #[allow(clippy::print_stdout, reason = "figures, seen with --nocapture")]
        {
            println!("s {s:7.1} m  {speed:5.2} m/s  least margin {margin:6.3} m");
        }
    }
    #[allow(clippy::print_stdout, reason = "figures, seen with --nocapture")]
    {
        println!("{slower} of {POINTS} points slower than {wanted} m/s; least margin {worst:.3} m");
    }
    assert!(worst > 0.0, "least margin {worst:.3} m");
}

#[test]
fn the_small_car_stops_inside_the_l_track_from_everywhere() {
    stops("barc", "l", 3.5);
}

#[test]
fn the_iac_car_stops_inside_the_road_course_from_everywhere() {
    stops("iac", "road_course", 50.0);
}
