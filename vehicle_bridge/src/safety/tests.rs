//! A million random events against invariants that an oracle of its own keeps.
#![allow(clippy::unwrap_used, clippy::panic, reason = "code of tests")]

use std::sync::Arc;

use rand::{RngExt as _, SeedableRng as _};
use rand_pcg::Pcg64;
use vehicle_model::{CarParams, Input, State, Track};

use super::*;

const MS: i64 = 1_000_000;
const CONTROLLER: i64 = 77;
const EVENTS: u64 = 1_000_000;
/// Steering angle of every command with a fault: it may never be asked of the car. \[rad\]
const MARK: f64 = 0.123_456;

fn rules() -> Rules {
    let mut car = CarParams::builtin("barc").unwrap();
    (car.a_rate_max, car.delta_rate_max) = (Some(20.0), Some(3.0));
    Rules::new(&car, &Arc::new(Track::builtin("l").unwrap()), 10 * MS)
}

/// What the oracle knows: only what was said, and the answers, never the core's memory.
#[derive(Default)]
struct Oracle {
    token: i64,
    last_good_ns: i64,
    last_seq: i64,
    before: Input,
    tick_ns: i64,
    phase: Phase,
    started_ns: i64,
    driving: u64,
    stops: u64,
}

/// A command; `fault` 0 is none.
fn command(random: &mut Pcg64, (seq, last): (i64, i64), token: i64, now: i64, fault: u32) -> Offer {
    let mut input =
        Input { a: random.random_range(-2.0..2.0), delta: random.random_range(-0.4..0.4) };
    if fault != 0 {
        input.delta = MARK;
    }
    let mut offer = Offer {
        boot_id: CONTROLLER,
        seq,
        arrival_ns: now,
        since_ns: now - random.random_range(0..20) * MS,
        token,
        drives: true,
        input,
        valid_for_ns: 250 * MS,
        plan: [input; PLAN],
        n_plan: 3,
        plan_dt: 0.01,
        ..Offer::default()
    };
    match fault {
        1 => offer.input.a = f64::NAN,
        2 => offer.input.delta = 3.0,
        3 => offer.since_ns = now - 300 * MS,
        4 => offer.boot_id = 78,
        5 if last > 0 => offer.seq = last - random.random_range(0..5),
        6 if last > 0 => offer.seq = last + 101 + random.random_range(0..50),
        5..=7 => offer.token = token.wrapping_add(1),
        8 => offer.plan[1].a = f64::INFINITY,
        9 => offer.input.a = -1e9,
        _ => {}
    }
    offer
}

#[test]
fn a_million_random_events_break_no_rule() {
    let rules = rules();
    let mut random = Pcg64::seed_from_u64(5);
    let (mut safety, mut oracle) = (Safety::default(), Oracle::default());
    let (mut now, mut seq) = (10_000 * MS, 0);
    let mut seen = [0_u64; 7];
    for n in 0..EVENTS {
        // Long good stretches, so that arming succeeds, and short bad ones.
        let trouble = (n / 4000) % 2 == 1;
        now += match random.random_range(0..if trouble { 3000 } else { 40_000 }) {
            0 => random.random_range(50..400) * MS,
            _ => random.random_range(1..6) * MS,
        };
        let kind = random.random_range(0..1000);
        let (mut offered, mut ordered) = (None, None);
        let quality = if random.random_range(0..5000) == 0 { 1 } else { 2 };
        let speed = if random.random_range(0..3) > 0 { 0.0 } else { random.random_range(0.0..3.0) };
        let x = State { v_x: speed, s: random.random_range(0.0..10.0), ..State::default() };
        let old = safety;
        let event = match kind {
            0..250 => Event::Tick,
            250..450 => Event::State(x, quality),
            450..550 => Event::Pulse(CONTROLLER),
            550..600 => Event::Track(CONTROLLER, rules.track_id),
            600..970 => {
                seq += 1;
                let fault =
                    if random.random_range(0..4) == 0 { random.random_range(1..10) } else { 0 };
                offered = Some((
                    command(&mut random, (seq, oracle.last_seq), safety.token(), now, fault),
                    fault,
                ));
                Event::Tick
            }
            970..999 => {
                let kind = match random.random_range(0..if trouble { 40 } else { 24 }) {
                    0..10 => OrderKind::Arm { moving: false },
                    10..20 => OrderKind::Start,
                    20..24 => OrderKind::Reset,
                    24..28 => OrderKind::Stop,
                    28..31 => OrderKind::Estop,
                    31..34 => OrderKind::Disarm,
                    34..37 => OrderKind::SpeedCap(random.random_range(-1.0..5.0)),
                    _ => OrderKind::Unknown(99),
                };
                let right = random.random_range(0..5) > 0;
                let token = if right { safety.token() } else { random.random_range(0..9) };
                let fresh = random.random_range(1000..i64::MAX);
                ordered = Some(kind);
                Event::Order(Order { kind, token, deadman: false, fresh })
            }
            _ if trouble => Event::CarFailed,
            _ => Event::Tick,
        };
        let (next, output) = match &offered {
            Some((offer, _)) => step(&rules, &safety, &Event::Command(offer), now),
            None => step(&rules, &safety, &event, now),
        };
        // Pure: the same again is the same.
        if n % 1000 == 0 && offered.is_none() {
            assert_eq!(step(&rules, &old, &event, now).0, next, "{n}");
        }
        safety = next;
        let (was, is) = (oracle.phase, safety.phase());
        seen[is as usize] += 1;
        if let Some((offer, fault)) = offered {
            let accepted = output.answer == Answer::Accepted;
            if fault != 0 {
                assert!(!accepted, "{n}: fault {fault} believed");
            }
            if accepted {
                assert!(offer.token != 0 && offer.token == oracle.token, "{n}");
                assert!(offer.seq > oracle.last_seq || oracle.last_seq == 0, "{n}");
                (oracle.last_good_ns, oracle.last_seq) = (now, offer.seq);
            }
        }
        match (was, is) {
            (a, b) if a == b => {}
            (Phase::Boot, Phase::Idle) => assert!(matches!(event, Event::State(..)), "{n}"),
            (Phase::Idle, Phase::Armed) => {
                assert!(matches!(ordered, Some(OrderKind::Arm { .. })), "{n}");
                assert!(safety.token() != 0);
                (oracle.token, oracle.last_seq) = (safety.token(), 0);
            }
            (Phase::Armed, Phase::Running) => {
                assert_eq!(ordered, Some(OrderKind::Start), "{n}");
                (oracle.started_ns, oracle.last_good_ns) = (now, 0);
            }
            (Phase::Estop | Phase::Fault, Phase::Idle) => {
                assert_eq!(ordered, Some(OrderKind::Reset), "{n}: latched");
            }
            (Phase::Running, Phase::SafeStop) => oracle.stops += 1,
            (Phase::SafeStop | Phase::Armed, Phase::Idle) | (_, Phase::Fault | Phase::Estop) => {}
            (a, b) => panic!("{n}: {a:?} became {b:?}"),
        }
        if ordered == Some(OrderKind::Estop) {
            assert_eq!(is, Phase::Estop, "{n}: at once");
        }
        if !matches!(is, Phase::Armed | Phase::Running) {
            assert_eq!(safety.token(), 0, "{n}");
            oracle.token = 0;
        }
        oracle.phase = is;
        if event == Event::Tick && offered.is_none() {
            let sent = output.applied.sent;
            let l = rules.limiter;
            assert!((l.a_min..=l.a_max).contains(&sent.a) && sent.delta.abs() <= l.delta_max);
            if oracle.tick_ns > 0 {
                let dt = ((now - oracle.tick_ns).min(10 * rules.tick_ns)) as f64 * 1e-9 + 1e-9;
                let change = (sent.a - oracle.before.a, sent.delta - oracle.before.delta);
                assert!(change.0.abs() <= l.a_rate_max * dt, "{n}: {change:?} in {dt}");
                assert!(change.1.abs() <= l.delta_rate_max * dt, "{n}: {change:?} in {dt}");
            }
            (oracle.before, oracle.tick_ns) = (sent, now);
            let drives = matches!(output.source, Source::Command | Source::Plan);
            if drives {
                oracle.driving += 1;
                assert_eq!(is, Phase::Running, "{n}");
                let silent = now - oracle.last_good_ns;
                assert!(silent <= rules.period_ns + rules.timeout_ns, "{n}: {silent} ns");
                let asked = output.applied.asked;
                assert!(asked.delta.to_bits() != MARK.to_bits(), "{n}: a faulty command applied");
                assert!((-2.0..2.0).contains(&asked.a) && asked.delta.abs() <= 0.4, "{n}");
            } else {
                // Held or stopping: the brake is asked for, whatever the limits make of it.
                assert!(output.applied.asked.a <= 0.0, "{n}: {output:?}");
            }
        }
    }
    // Every state but BOOT, which is left once.
    assert!(seen.iter().skip(1).all(|&count| count > 500), "{seen:?}");
    assert!(oracle.driving > 5_000 && oracle.stops > 100, "{} {}", oracle.driving, oracle.stops);
}
