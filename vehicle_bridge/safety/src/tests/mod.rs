//! A million random events against a model of the rules, and single cases.
#![allow(clippy::unwrap_used, clippy::panic, reason = "code of tests")]

mod boundaries;
mod decode;
mod doubt;
mod edges;
mod generator;
mod hold;
mod model;
mod stop;

use std::collections::BTreeMap;
use std::sync::Arc;

use generator::{Generator, Said};
use lcm_types::{ArmToken, BootId, MonoTime, SeqNumber};
use model::Model;
use rand::{RngExt as _, SeedableRng as _};
use rand_pcg::Pcg64;
use vehicle_model::{CarParams, Input, Limit, State, Track};

use super::*;

const MS: i64 = 1_000_000;
const CONTROLLER: BootId = BootId::new(77);
const OTHER: BootId = BootId::new(78);
const EVENTS: u32 = 1_000_000;
/// Events from one BOOT to the next: it is left only once.
const EPISODE: u32 = 2_500;

/// Every way from state to state there is. RUNNING becomes IDLE at once where the car stands.
const WAYS: &str = "BOOT>IDLE BOOT>ESTOP BOOT>FAULT IDLE>ARMED IDLE>ESTOP IDLE>FAULT ARMED>IDLE \
                    ARMED>RUNNING ARMED>ESTOP ARMED>FAULT RUNNING>SAFE_STOP RUNNING>IDLE \
                    RUNNING>ESTOP RUNNING>FAULT SAFE_STOP>IDLE SAFE_STOP>ESTOP SAFE_STOP>FAULT \
                    FAULT>IDLE FAULT>ESTOP ESTOP>IDLE";
/// Every end of a grant there is.
const ENDS: &str = "ARMED:Gap ARMED:States ARMED:Heartbeat ARMED:Operator ARMED:Controller ARMED:Car ARMED:End \
                    RUNNING:Commands RUNNING:Validity RUNNING:States RUNNING:Gap RUNNING:Deadman \
                    RUNNING:End RUNNING:Controller RUNNING:Flood RUNNING:Operator RUNNING:Car";
const REJECTS: &str = "NotFinite Range Rate Stale Boot Sequence Token Unanswered";
const DENIALS: &str = "NoState NotFresh NotGood NoController Controllers OtherController NoSetup Track \
                       Car Period Config Moves NotArmed BridgeState \
                       Token Latched NothingToReset Cap Unknown";
/// Each of them is reached at least this often.
const OFTEN: u32 = 10;

/// A time of the tests: nanoseconds, with which they reckon.
fn time(ns: i64) -> MonoTime {
    MonoTime::from_ns(ns)
}

fn number(seq: i64) -> SeqNumber {
    SeqNumber::new(seq)
}

fn token(number: i64) -> ArmToken {
    ArmToken::new(number)
}

/// [`super::step`] at a time of the tests. \[ns\]
fn step(rules: &Rules, safety: &Safety, event: &BridgeEvent<'_>, now_ns: i64) -> (Safety, Output) {
    super::step(rules, safety, event, time(now_ns))
}

fn rules() -> Rules {
    let mut car = CarParams::builtin("barc").unwrap();
    (car.a_rate_max, car.delta_rate_max) = (Some(20.0), Some(3.0));
    let mut rules = Rules::new(&car, &Arc::new(Track::builtin("l").unwrap()), 50 * MS);
    rules.setup.config_id = 4;
    // Random states agree with nothing; `doubt` has the tests of these rules.
    rules.doubt = None;
    // Shorter than in life, so that a drive begins more often.
    (rules.ready_ns, rules.start_ns, rules.pulse_ns) = (100 * MS, 200 * MS, 150 * MS);
    rules
}

/// What was reached.
#[derive(Default)]
struct Seen {
    ways: BTreeMap<String, u32>,
    ends: BTreeMap<String, u32>,
    rejects: BTreeMap<String, u32>,
    denials: BTreeMap<String, u32>,
    sources: [u32; 4],
    limits: [u32; 6],
}

/// What something is, without its numbers.
fn word(of: &impl std::fmt::Debug) -> String {
    format!("{of:?}").split([' ', '(']).next().unwrap_or_default().to_owned()
}

/// An answer, without the speed that the core reckons and the model does not.
fn gist(answer: &Answer) -> String {
    match answer {
        Answer::Denied(Denied::Moves { .. }) => "Moves".to_owned(),
        other => format!("{other:?}"),
    }
}

impl Seen {
    fn note(&mut self, answer: &Answer) {
        match answer {
            Answer::Rejected(reject) => *self.rejects.entry(word(reject)).or_default() += 1,
            Answer::Denied(denied) => *self.denials.entry(word(denied)).or_default() += 1,
            Answer::None | Answer::Accepted => {}
        }
    }
}

/// What a tick may put out: the command in force, its plan, or the brake, inside all limits.
fn check(rules: &Rules, model: &Model, output: &Output, before: (Input, f64), now: i64) {
    let (sent, asked, l) = (output.applied.sent, output.applied.asked, &rules.limiter);
    let (was, dt) = before;
    assert!((l.a_min..=l.a_max).contains(&sent.a) && sent.delta.abs() <= l.delta_max);
    assert!((sent.a - was.a).abs() <= l.a_rate_max * dt + 1e-9, "{sent:?} after {was:?}, {dt}");
    assert!((sent.delta - was.delta).abs() <= l.delta_rate_max * dt + 1e-9);
    if let (Some(cap), Some((at, v_x))) = (model.cap, model.state)
        && at == now
    {
        let most = ((cap - v_x) / 0.5).max(was.a - l.a_rate_max * dt).max(l.a_min);
        assert!(sent.a <= most + 1e-9, "{sent:?} at {v_x}, cap {cap}");
    }
    assert!(model.cap.is_some() || !output.applied.by(Limit::SpeedCap), "no cap is ordered");
    let command = model.command.filter(|_| model.bridge_state == BridgeState::Running);
    let Some(command) = command else {
        let held = !matches!(
            model.bridge_state,
            BridgeState::SafeStop | BridgeState::Fault | BridgeState::Estop
        );
        assert_eq!(output.source, if held { InputSource::None } else { InputSource::Stop });
        let standing = model.state.is_some_and(|(at, v_x)| at == now && v_x < 0.5);
        assert!(asked.a <= if standing { 0.2 * l.a_min } else { 0.0 }, "{output:?}");
        return;
    };
    let age = time(now).ns_since(command.arrival);
    assert!(age <= command.valid_for_ns.min(model::silence(rules, rules.period_ns)), "{age}");
    if age <= rules.period_ns {
        assert_eq!((output.source, asked), (InputSource::Command, command.input));
    } else {
        let plan = &command.plan[..command.n_plan];
        let step = if command.plan_dt > 0.0 { age as f64 * 1e-9 / command.plan_dt } else { 0.0 };
        // At a step's very end both are right.
        let near = |x: f64| plan.get((x.max(0.0) as usize).min(plan.len().max(1) - 1));
        let right = [near(step - 1e-6), near(step + 1e-6)].map(|u| u.copied());
        let asked = Some(asked);
        assert_eq!(output.source, InputSource::Plan);
        if plan.is_empty() {
            assert_eq!(asked, Some(command.input));
        } else {
            assert!(right.contains(&asked), "{asked:?}, not {right:?}");
        }
    }
}

/// At its deadline the grant is still there, a nanosecond later not, if nothing more comes.
fn check_deadline(rules: &Rules, safety: &Safety, now: i64, context: &dyn Fn() -> String) {
    let granted = !safety.token().is_none();
    let deadline = safety.deadline(rules);
    assert_eq!(deadline.is_some(), granted, "{}", context());
    if let Some(until) = deadline.map(MonoTime::as_ns).filter(|until| *until >= now) {
        let token_at = |at: i64| step(rules, safety, &BridgeEvent::Tick, at).0.token();
        assert_eq!(token_at(until), safety.token(), "{}", context());
        assert_eq!(token_at(until + 1), ArmToken::NONE, "{}", context());
    }
}

/// From BOOT on.
fn episode(rules: &Rules, seed: u64, seen: &mut Seen) {
    let mut generator = Generator::new(seed);
    let (mut safety, mut model) = (Safety::default(), Model::default());
    let (mut now, mut before) = (10_000 * MS, Input::default());
    for n in 0..EPISODE {
        let (said, at) = generator.next(rules, &model, now);
        now = at;
        let (event, damage) = match &said {
            Said::Command(offer, damage) => (BridgeEvent::Command(offer), *damage),
            Said::Other(event) => (*event, None),
        };
        let context = || format!("seed {seed}, event {n}: {event:?}");
        let (next, output) = step(rules, &safety, &event, now);
        // Pure: the same again is the same, but that a NaN is not itself.
        if n % 50 == 0 && !matches!(event, BridgeEvent::Command(_)) {
            let again = step(rules, &safety, &event, now).0;
            assert_eq!(format!("{again:?}"), format!("{next:?}"), "{}", context());
        }
        safety = next;
        if n % 10 == 0 {
            check_deadline(rules, &safety, now, &context);
        }
        let (was, token, held) = (model.bridge_state, model.token, model.held_since());
        let answer = model.take(rules, &event, damage, now);
        assert_eq!(gist(&output.answer), gist(&answer), "{}", context());
        seen.note(&answer);
        // Between two states, whether the car stands is reckoned, which the model does not.
        let reckoned = model.state.is_none_or(|(at, _)| at != now);
        let (stop, stand) = (BridgeState::SafeStop, BridgeState::Idle);
        if reckoned
            && [(stop, stand), (stand, stop)].contains(&(model.bridge_state, safety.bridge_state()))
        {
            model.bridge_state = safety.bridge_state();
        }
        assert_eq!(safety.bridge_state(), model.bridge_state, "{}", context());
        assert_eq!(safety.stop_reason(), model.stop_reason, "{}", context());
        assert_eq!(safety.token(), model.token, "{}", context());
        assert_eq!(
            !safety.token().is_none(),
            matches!(model.bridge_state, BridgeState::Armed | BridgeState::Running)
        );
        assert_eq!(safety.command(), model.command.map(|c| (c.boot_id, c.seq)), "{}", context());
        if model.bridge_state != was || model.token != token {
            let way = format!("{}>{}", was.name(), model.bridge_state.name());
            *seen.ways.entry(way).or_default() += 1;
        }
        if !token.is_none() && model.token != token {
            let end = format!("{}:{:?}", was.name(), model.stop_reason);
            *seen.ends.entry(end).or_default() += 1;
        }
        if event == BridgeEvent::Tick {
            let held_ns = held.map_or(rules.tick_ns, |since| now - since);
            let dt = held_ns.clamp(0, 10 * rules.tick_ns) as f64 * 1e-9;
            check(rules, &model, &output, (before, dt), now);
            model.counts.limited += i64::from(output.applied.bits != 0);
            before = output.applied.sent;
            seen.sources[output.source as usize] += 1;
            for (bit, count) in seen.limits.iter_mut().enumerate() {
                *count += u32::from(output.applied.bits & 1 << bit != 0);
            }
        }
        assert_eq!(safety.counts(), model.counts, "{}", context());
    }
}

#[test]
fn a_million_random_events_break_no_rule() {
    let (rules, mut seen) = (rules(), Seen::default());
    for seed in 0..EVENTS / EPISODE {
        episode(&rules, seed.into(), &mut seen);
    }
    for (expected, seen) in
        [(WAYS, &seen.ways), (ENDS, &seen.ends), (REJECTS, &seen.rejects), (DENIALS, &seen.denials)]
    {
        let rare = |name: &&str| seen.get(*name).is_none_or(|count| *count < OFTEN);
        let missed: Vec<_> = expected.split_whitespace().filter(rare).collect();
        assert!(missed.is_empty(), "hardly reached: {missed:?} of {seen:?}");
        let known: Vec<_> = expected.split_whitespace().collect();
        let other: Vec<_> = seen.keys().filter(|name| !known.contains(&name.as_str())).collect();
        assert!(other.is_empty(), "there is no such way: {other:?}");
    }
    assert!(seen.sources.iter().all(|count| *count > 1000), "{:?}", seen.sources);
    // Steering and what is no number are refused before, see `decode`.
    for limit in [Limit::SteeringRate, Limit::Acceleration, Limit::Jerk, Limit::SpeedCap] {
        let bit = (limit as i32).trailing_zeros() as usize;
        assert!(seen.limits[bit] > 1000, "{limit:?}: {:?}", seen.limits);
    }
}
