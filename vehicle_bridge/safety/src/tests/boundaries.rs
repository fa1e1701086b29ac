//! One unit on either side of each limit: a nanosecond, a message, the next floating-point number.

use super::*;
use crate::command::PLAN;
use crate::order::MAX_CAP;

/// A core in IDLE with good states since `since_ns` and one now; another tick is due in 10 ms.
struct Core {
    rules: Rules,
    safety: Safety,
}

impl Core {
    fn new() -> Self {
        let mut rules = rules();
        (rules.ready_ns, rules.start_ns, rules.pulse_ns) = (1000 * MS, 1000 * MS, 500 * MS);
        Self { rules, safety: Safety::default() }
    }

    fn on(&mut self, event: BridgeEvent<'_>, at_ns: i64) -> Output {
        let (next, output) = step(&self.rules, &self.safety, &event, at_ns);
        self.safety = next;
        output
    }

    fn order(&mut self, kind: OrderKind, at_ns: i64) -> Answer {
        let order = Order { kind, token: token(9), deadman: false, fresh: token(9) };
        self.on(BridgeEvent::Order(order), at_ns).answer
    }

    fn arm(&mut self, at_ns: i64) -> Answer {
        self.order(OrderKind::Arm { moving: false, controller: BootId::NONE }, at_ns)
    }

    /// Good states from 0 on, each 50 ms, the last one at this time.
    fn states(&mut self, until_ns: i64) {
        let still = BridgeEvent::State(State::default(), 2);
        for at_ns in (0..until_ns).step_by(50 * MS as usize).chain([until_ns]) {
            self.on(still, at_ns);
        }
    }

    /// The controller's heartbeat and setup.
    fn controller(&mut self, at_ns: i64) {
        self.on(BridgeEvent::Heartbeat(CONTROLLER), at_ns);
        self.on(BridgeEvent::Setup(CONTROLLER, self.rules.setup), at_ns);
    }

    /// RUNNING at 2 s, the state with number 3 published then.
    fn running() -> Self {
        let mut core = Self::new();
        core.states(NOW);
        core.controller(NOW);
        core.on(BridgeEvent::Published(number(3)), NOW);
        assert_eq!(core.arm(NOW), Answer::Accepted);
        assert_eq!(core.order(OrderKind::Start, NOW), Answer::Accepted);
        core
    }
}

const NOW: i64 = 2_000 * MS;

fn command() -> DecodedCommand {
    DecodedCommand {
        boot_id: CONTROLLER,
        seq: number(1),
        arrival: time(NOW),
        since: time(NOW),
        answers: Some(number(3)),
        token: token(9),
        drives: true,
        valid_for_ns: 80 * MS,
        plan: [Input::default(); PLAN],
        ..DecodedCommand::default()
    }
}

fn answer(change: impl FnOnce(&mut DecodedCommand), at_ns: i64) -> Answer {
    let (mut core, mut offer) = (Core::running(), command());
    change(&mut offer);
    core.on(BridgeEvent::Command(&offer), at_ns).answer
}

#[test]
fn commands() {
    let (ok, refused) = (Answer::Accepted, |reject| Answer::Rejected(reject));
    assert_eq!(answer(|_| {}, NOW), ok);
    // Age: by its validity, and by the oldest that is believed.
    assert_eq!(answer(|c| c.since = time(NOW - 80 * MS), NOW), ok);
    assert_eq!(answer(|c| c.since = time(NOW - 80 * MS - 1), NOW), refused(Reject::Stale));
    let long = |since_ns| answer(|c| (c.valid_for_ns, c.since) = (i64::MAX, time(since_ns)), NOW);
    let most = rules().max_age_ns;
    assert_eq!([long(NOW - most), long(NOW - most - 1)], [ok, refused(Reject::Stale)]);
    assert_eq!(answer(|c| c.valid_for_ns = 1, NOW), ok);
    assert_eq!(answer(|c| c.valid_for_ns = 0, NOW), refused(Reject::Range));
    // The state it answers, in a command that came later.
    let later =
        |by: i64| answer(|c| (c.arrival, c.since) = (time(NOW + by), time(NOW + by)), NOW + by);
    assert_eq!([later(80 * MS), later(80 * MS + 1)], [ok, refused(Reject::Unanswered)]);
    assert_eq!(answer(|c| c.answers = Some(number(4)), NOW), refused(Reject::Unanswered));
    assert_eq!(answer(|c| c.answers = Some(number(2)), NOW), refused(Reject::Unanswered));
    // Start and token.
    for by in [-1, 1] {
        assert_eq!(
            answer(|c| c.boot_id = BootId::new(CONTROLLER.get() + by), NOW),
            refused(Reject::Boot)
        );
        assert_eq!(answer(|c| c.token = token(9 + by), NOW), refused(Reject::Token));
    }
}

#[test]
fn the_box_of_inputs_to_the_last_bit() {
    let limiter = rules().limiter;
    let tolerance = 1e-4;
    let of = |a: f64, delta: f64| answer(|c| c.input = Input { a, delta }, NOW);
    let refused = Answer::Rejected(Reject::Range);
    let (least, most) = (limiter.a_min - tolerance, limiter.a_max + tolerance);
    let angle = limiter.delta_max + tolerance;
    for (inside, outside) in [
        ((least, 0.0), (least.next_down(), 0.0)),
        ((most, 0.0), (most.next_up(), 0.0)),
        ((0.0, angle), (0.0, angle.next_up())),
        ((0.0, -angle), (0.0, -angle.next_up())),
    ] {
        assert_eq!(of(inside.0, inside.1), Answer::Accepted, "{inside:?}");
        assert_eq!(of(outside.0, outside.1), refused, "{outside:?}");
    }
    let step = |dt: f64| answer(|c| c.plan_dt = dt, NOW);
    assert_eq!([step(0.0), step(-f64::MIN_POSITIVE)], [Answer::Accepted, refused]);
}

#[test]
fn numbers_of_commands_and_their_rate() {
    let mut core = Core::running();
    let mut say = |seq: i64| {
        let offer = DecodedCommand { seq: number(seq), ..command() };
        core.on(BridgeEvent::Command(&offer), NOW).answer
    };
    let sequence = Answer::Rejected(Reject::Sequence);
    assert_eq!(say(10), Answer::Accepted);
    assert_eq!([say(10), say(111), say(110)], [sequence, sequence, Answer::Accepted]);
    // The hundredth in a window is believed, the next one stops the car.
    for seq in 111..207 {
        assert_eq!(say(seq), Answer::Accepted, "{seq}");
    }
    assert_eq!(say(207), Answer::Rejected(Reject::Rate));
    assert_eq!(core.safety.stop_reason(), StopReason::Flood);
}

#[test]
fn arming_waits_for_good_states_and_a_heartbeat() {
    let denied = |answer: Answer| match answer {
        Answer::Denied(denied) => word(&denied),
        answer => word(&answer),
    };
    let ready = |good_ns: i64| {
        let mut core = Core::new();
        core.states(good_ns);
        core.controller(good_ns);
        denied(core.arm(good_ns))
    };
    assert_eq!([ready(1000 * MS - 1), ready(1000 * MS)], ["NotGood", "Accepted"]);
    let heard = |ago_ns: i64| {
        let mut core = Core::new();
        core.states(NOW - ago_ns);
        core.controller(NOW - ago_ns);
        core.states(NOW);
        denied(core.arm(NOW))
    };
    assert_eq!([heard(500 * MS), heard(500 * MS + 1)], ["Accepted", "NoController"]);
    // The last state: a period of states and a timeout ago.
    let fresh = |ago_ns: i64| {
        let mut core = Core::new();
        core.states(NOW - ago_ns);
        core.controller(NOW);
        denied(core.arm(NOW))
    };
    assert_eq!([fresh(110 * MS), fresh(110 * MS + 1)], ["Accepted", "NotFresh"]);
}

#[test]
fn a_start_without_commands_ends() {
    let after = |by_ns: i64| {
        let mut core = Core::running();
        core.states(NOW + by_ns);
        for at_ns in [NOW + by_ns - 1, NOW + by_ns] {
            core.on(BridgeEvent::Tick, at_ns);
        }
        core.safety.bridge_state()
    };
    // It stands: SAFE_STOP ends at once.
    assert_eq!([after(1000 * MS), after(1000 * MS + 1)], [BridgeState::Running, BridgeState::Idle]);
}

/// What a core of these times is in `by_ns` after the only command, with states each 10 ms until
/// `states_ns`.
fn after_a_command(period_ms: i64, timeout_ms: i64, states_ns: i64, by_ns: i64) -> Safety {
    let mut core = Core::running();
    (core.rules.period_ns, core.rules.state_ns) = (period_ms * MS, period_ms * MS);
    core.rules.timeout_ns = timeout_ms * MS;
    let offer = DecodedCommand { valid_for_ns: 1000 * MS, ..command() };
    assert_eq!(core.on(BridgeEvent::Command(&offer), NOW).answer, Answer::Accepted);
    for at_ns in (0..by_ns).step_by(10 * MS as usize).chain([by_ns]) {
        if at_ns <= states_ns {
            core.on(BridgeEvent::State(State { v_x: 1.0, ..State::default() }, 2), NOW + at_ns);
        }
        core.on(BridgeEvent::Tick, NOW + at_ns);
    }
    core.safety
}

#[test]
fn a_timeout_as_long_as_the_period_bridges_one_message_and_no_more() {
    let cases = [
        // Period, timeout: how long after the last one the car is stopped. [ms]
        (10, 100, 110),
        (50, 100, 150),
        (60, 100, 170),
        // The second command after a lost one comes after 200 ms, at the earliest.
        (100, 100, 250),
        (100, 99, 199),
        (100, 60, 160),
        (100, 200, 300),
    ];
    for (period, timeout, most) in cases {
        let case = format!("period {period} ms, timeout {timeout} ms");
        let commands = |by_ns| after_a_command(period, timeout, i64::MAX, by_ns);
        assert_eq!(commands(most * MS).bridge_state(), BridgeState::Running, "{case}");
        let late = commands(most * MS + 1);
        assert_eq!(late.bridge_state(), BridgeState::SafeStop, "{case}");
        assert_eq!(late.stop_reason(), StopReason::Commands, "{case}");
        // States alike: the last one now, and a command still in time.
        let states = |by_ns| after_a_command(period, timeout, 0, by_ns);
        assert_eq!(states(most * MS).bridge_state(), BridgeState::Running, "{case}");
        assert_eq!(states(most * MS + 1).stop_reason(), StopReason::States, "{case}");
    }
}

#[test]
fn a_speed_cap_from_zero_to_the_greatest() {
    let of = |cap: f64| Core::running().order(OrderKind::SpeedCap(cap), NOW);
    for cap in [0.0, f64::MIN_POSITIVE, MAX_CAP] {
        assert_eq!(of(cap), Answer::Accepted, "{cap}");
    }
    for cap in [-f64::MIN_POSITIVE, MAX_CAP.next_up()] {
        assert_eq!(of(cap), Answer::Denied(Denied::Cap { found: cap }));
    }
}

#[test]
fn what_is_sent_changes_by_a_ticks_share_and_no_more() {
    let sent = |a: f64, delta: f64| {
        let mut core = Core::running();
        // The brake that holds the car is let go first.
        core.on(BridgeEvent::Tick, NOW);
        for (n, input) in [(1, Input::default()), (2, Input::default()), (3, Input { a, delta })] {
            let at_ns = NOW + n * 10 * MS;
            core.on(BridgeEvent::State(State::default(), 2), at_ns);
            core.on(BridgeEvent::Published(number(3 + n)), at_ns);
            let (seq, answers, at) = (number(n), Some(number(3 + n)), time(at_ns));
            let offer = DecodedCommand { seq, answers, arrival: at, since: at, input, ..command() };
            assert_eq!(core.on(BridgeEvent::Command(&offer), at_ns).answer, Answer::Accepted);
            let output = core.on(BridgeEvent::Tick, at_ns);
            if n == 2 {
                assert_eq!(output.applied.sent, Input::default(), "from rest");
            }
            if n == 3 {
                return output.applied;
            }
        }
        unreachable!()
    };
    // 20 m/s^3 and 3 rad/s for 10 ms; the limiter names what moves an input by more than 1e-6.
    let (jerk, rate) = (20.0 * 0.01, 3.0 * 0.01);
    for (sign, bit) in [(1.0, Limit::Jerk), (-1.0, Limit::Jerk)] {
        let within = sent(sign * jerk, 0.0);
        assert_eq!((within.sent.a, within.bits), (sign * jerk, 0));
        let beyond = sent(sign * (jerk + 2e-6), 0.0);
        assert!(beyond.by(bit) && (beyond.sent.a - sign * jerk).abs() < 1e-12, "{beyond:?}");
        let within = sent(0.0, sign * rate);
        assert_eq!((within.sent.delta, within.bits), (sign * rate, 0));
        let beyond = sent(0.0, sign * (rate + 2e-6));
        assert!(beyond.by(Limit::SteeringRate), "{beyond:?}");
        assert!((beyond.sent.delta - sign * rate).abs() < 1e-12, "{beyond:?}");
    }
}
