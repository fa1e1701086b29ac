//! The state machine.

use lcm_types::{ArmToken, BootId, MonoTime, SeqNumber};
use vehicle_model::{Input, Limited, State};

use super::command::{DecodedCommand, Reject};
use super::controllers::Controllers;
use super::doubt::{Doubt, Reaction, Steering};
use super::hold::Hold;
use super::published::Published;
use super::rate::Rate;
use super::rules::Rules;
use super::stop;
use super::stop_reason::StopReason;
use super::types::{Answer, BridgeEvent, BridgeState, CommandCounts, InputSource, Output};

/// The car's state as last heard.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Seen {
    pub(super) at: MonoTime,
    pub(super) good_since: Option<MonoTime>,
    pub(super) x: State,
}

/// Everything the core remembers.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Safety {
    pub(super) bridge_state: BridgeState,
    pub(super) token: ArmToken,
    pub(super) armed: Option<BootId>,
    pub(super) seq: Option<SeqNumber>,
    pub(super) command: Option<DecodedCommand>,
    pub(super) started: MonoTime,
    pub(super) deadman: Option<MonoTime>,
    pub(super) seen: Option<Seen>,
    pub(super) estimate: State,
    pub(super) estimated: MonoTime,
    /// The input as the actuators have it.
    pub(super) acting: Input,
    pub(super) controllers: Controllers,
    pub(super) published: Published,
    pub(super) doubt: Doubt,
    /// The stop is driven by reckoning: the states are doubted.
    pub(super) blind: bool,
    /// The stop is driven with a steering that does not follow its commands.
    pub(super) steering: Option<Steering>,
    /// The brake that holds the car.
    pub(super) hold: Hold,
    pub(super) speed_cap: Option<f64>,
    pub(super) applied: Option<Limited>,
    pub(super) source: InputSource,
    pub(super) tick: Option<MonoTime>,
    pub(super) sent: Option<MonoTime>,
    pub(super) rate: Rate,
    pub(super) stop_reason: StopReason,
    pub(super) counts: CommandCounts,
}

/// One event at `now`.
#[must_use]
pub fn step(
    rules: &Rules,
    safety: &Safety,
    event: &BridgeEvent<'_>,
    now: MonoTime,
) -> (Safety, Output) {
    let mut next = *safety;
    next.expire(rules, event, now);
    let answer = match event {
        BridgeEvent::State(x, quality) => next.on_state(rules, x, *quality, now),
        BridgeEvent::Command(offer) => match next.on_command(rules, offer, now) {
            Ok(()) => Answer::Accepted,
            Err(reject) => Answer::Rejected(reject),
        },
        // Another's is no sign of the controller that holds the grant.
        BridgeEvent::Heartbeat(boot_id) if next.armed.is_some_and(|armed| armed != *boot_id) => {
            Answer::Rejected(Reject::Boot)
        }
        BridgeEvent::Heartbeat(boot_id) => {
            next.controllers.on_heartbeat(*boot_id, now);
            Answer::None
        }
        BridgeEvent::Setup(boot_id, setup) => {
            next.controllers.on_setup(*boot_id, *setup, now);
            Answer::None
        }
        BridgeEvent::Published(seq) => {
            next.published.note(*seq, now);
            Answer::None
        }
        BridgeEvent::End => {
            match next.bridge_state {
                BridgeState::Running => next.leave(BridgeState::SafeStop, StopReason::End),
                BridgeState::Armed => next.leave(BridgeState::Idle, StopReason::End),
                _ => {}
            }
            Answer::None
        }
        BridgeEvent::Order(order) => match next.on_order(rules, order, now) {
            Ok(()) => Answer::Accepted,
            Err(denied) => Answer::Denied(denied),
        },
        BridgeEvent::CarFailed => {
            next.leave(
                if next.bridge_state == BridgeState::Estop {
                    BridgeState::Estop
                } else {
                    BridgeState::Fault
                },
                StopReason::Car,
            );
            Answer::None
        }
        BridgeEvent::Tick => {
            next.on_tick(rules, now);
            Answer::None
        }
        BridgeEvent::Sent => {
            next.sent = Some(now);
            Answer::None
        }
    };
    if let Answer::Rejected(reject) = answer {
        next.count(reject);
    }
    let held = Limited { asked: Input::default(), sent: Input::default(), bits: 0 };
    let applied = next.applied.unwrap_or(held);
    let source = next.source;
    (next, Output { applied, source, answer })
}

impl Safety {
    /// State of the machine.
    #[must_use]
    pub fn bridge_state(&self) -> BridgeState {
        self.bridge_state
    }

    /// The grant in force, if any.
    #[must_use]
    pub fn token(&self) -> ArmToken {
        self.token
    }

    /// Counts so far.
    #[must_use]
    pub fn counts(&self) -> CommandCounts {
        self.counts
    }

    /// Why the grant ended last.
    #[must_use]
    pub fn stop_reason(&self) -> StopReason {
        self.stop_reason
    }

    /// The command in force: start and number of its sender.
    #[must_use]
    pub fn command(&self) -> Option<(BootId, SeqNumber)> {
        self.command.map(|command| (command.boot_id, command.seq))
    }

    /// Counts a refusal; the host calls it for what never became an event.
    pub fn count(&mut self, reject: Reject) {
        match reject {
            Reject::Boot | Reject::Sequence | Reject::Token | Reject::Unanswered => {
                self.counts.old += 1;
            }
            Reject::Stale => self.counts.stale += 1,
            _ => self.counts.bad += 1,
        }
        self.counts.wrong_type += i64::from(reject == Reject::Fingerprint);
    }

    /// Ends the grant.
    pub(super) fn leave(&mut self, to: BridgeState, why: StopReason) {
        self.counts.stops += i64::from(self.bridge_state == BridgeState::Running);
        self.bridge_state = to;
        self.stop_reason = why;
        (self.token, self.armed, self.seq, self.deadman) = (ArmToken::NONE, None, None, None);
        self.command = None;
    }

    pub(super) fn is_fresh(&self, rules: &Rules, now: MonoTime) -> bool {
        let patience = rules.patience_ns(rules.state_ns);
        self.seen.is_some_and(|seen| now.ns_since(seen.at) <= patience)
    }

    /// The last instants at which what the grant needs is still in time, and what is missing after
    /// each; the first one that has passed tells why.
    fn limits(&self, rules: &Rules) -> [(MonoTime, StopReason); 6] {
        const NEVER: MonoTime = MonoTime::NEVER;
        let from = |then: Option<MonoTime>, patience: i64| {
            then.map_or(NEVER, |then| then.plus_ns(patience))
        };
        let (late, silent) = (rules.tick_ns + rules.timeout_ns, rules.patience_ns(rules.state_ns));
        let beat = self.armed.and_then(|boot_id| self.controllers.beat(boot_id));
        let heard = from(beat, rules.pulse_ns);
        let running = self.bridge_state == BridgeState::Running;
        let (due, valid) = match self.command {
            Some(c) => (
                c.arrival.plus_ns(rules.patience_ns(rules.period_ns)),
                c.arrival.plus_ns(c.valid_for_ns),
            ),
            None => (from(Some(self.started), rules.start_ns), NEVER),
        };
        let only = |is: bool, limit: MonoTime| if is { limit } else { NEVER };
        [
            (from(self.tick, late), StopReason::Gap),
            (
                self.seen.map_or(MonoTime::EARLIEST, |seen| seen.at.plus_ns(silent)),
                StopReason::States,
            ),
            (only(!running, heard), StopReason::Heartbeat),
            (only(running, from(self.deadman, rules.timeout_ns)), StopReason::Deadman),
            (only(running, due), StopReason::Commands),
            (only(running, valid), StopReason::Validity),
        ]
    }

    /// When the grant ends if nothing more comes; `None` without one. A host that ticks at the
    /// next nanosecond stops the car without waiting for its beat.
    #[must_use]
    pub fn deadline(&self, rules: &Rules) -> Option<MonoTime> {
        let granted = matches!(self.bridge_state, BridgeState::Armed | BridgeState::Running);
        granted.then(|| self.limits(rules).map(|(until, _)| until).into_iter().min()).flatten()
    }

    /// What time alone ends, before anything else is looked at.
    fn expire(&mut self, rules: &Rules, event: &BridgeEvent<'_>, now: MonoTime) {
        if !matches!(self.bridge_state, BridgeState::Armed | BridgeState::Running) {
            return;
        }
        let in_time =
            |why: StopReason| why == StopReason::States && matches!(event, BridgeEvent::State(..));
        let mut limits = self.limits(rules).into_iter();
        if let Some((_, why)) = limits.find(|(until, why)| now > *until && !in_time(*why)) {
            let to = if self.bridge_state == BridgeState::Armed {
                BridgeState::Idle
            } else {
                BridgeState::SafeStop
            };
            self.leave(to, why);
        }
    }

    /// A command's checks after its form, in order.
    fn on_command(
        &mut self,
        rules: &Rules,
        offer: &DecodedCommand,
        now: MonoTime,
    ) -> Result<(), Reject> {
        let ours = self.armed == Some(offer.boot_id);
        if !self.rate.admit(offer.boot_id, now) {
            if ours && self.bridge_state == BridgeState::Running {
                self.leave(BridgeState::SafeStop, StopReason::Flood);
            }
            return Err(Reject::Rate);
        }
        if !offer.is_finite() {
            return Err(Reject::NotFinite);
        }
        if !offer.in_range(&rules.limiter) {
            return Err(Reject::Range);
        }
        let oldest = offer.since.min(offer.arrival);
        if now.ns_since(oldest) > rules.max_age_ns.min(offer.valid_for_ns) {
            return Err(Reject::Stale);
        }
        if !ours {
            return Err(Reject::Boot);
        }
        if !offer.follows(self.seq) {
            return Err(Reject::Sequence);
        }
        if offer.token != self.token || self.token.is_none() {
            return Err(Reject::Token);
        }
        let answers = |seq: SeqNumber| {
            self.published.is_recent(seq, now, rules.max_age_ns.min(offer.valid_for_ns))
        };
        if offer.drives && !offer.answers.is_some_and(answers) {
            return Err(Reject::Unanswered);
        }
        if let Some(last) = self.seq {
            self.counts.lost += offer.seq.missing_after(last);
        }
        self.seq = Some(offer.seq);
        self.counts.ok += 1;
        if offer.estop {
            self.leave(BridgeState::Estop, StopReason::Controller);
        } else if self.bridge_state == BridgeState::Running {
            if offer.drives {
                self.command = Some(*offer);
            } else if self.command.is_some() {
                // Before the first command that drives, the controller has not heard the START.
                self.leave(BridgeState::SafeStop, StopReason::Controller);
            }
        }
        Ok(())
    }

    fn on_tick(&mut self, rules: &Rules, now: MonoTime) {
        let since = |then: Option<MonoTime>| match then {
            Some(then) => now.ns_since(then).clamp(0, 10 * rules.tick_ns) as f64 * 1e-9,
            None => rules.tick_ns as f64 * 1e-9,
        };
        let (dt, held) = (since(self.tick), since(self.tick.max(self.sent)));
        let before = self.applied.map(|applied| applied.sent).unwrap_or_default();
        let ahead = now.ns_since(self.estimated).max(0) as f64 * 1e-9;
        let ahead = ahead.min(dt);
        let acting = stop::follow(rules, self.acting, before, dt - ahead);
        (self.estimate, self.acting) = stop::reckon(rules, &self.estimate, (acting, before), ahead);
        self.estimated = now;
        self.tick = Some(now);
        if self.bridge_state == BridgeState::SafeStop && self.standstill(rules, now).is_ok() {
            (self.bridge_state, self.blind, self.steering) = (BridgeState::Idle, false, None);
        }
        let driven = match self.bridge_state {
            BridgeState::Running => {
                self.command.and_then(|command| command.input_at(now, rules.period_ns))
            }
            _ => None,
        };
        let stopped = matches!(
            self.bridge_state,
            BridgeState::SafeStop | BridgeState::Fault | BridgeState::Estop
        );
        let (asked, source) = match driven {
            Some((input, false)) => (input, InputSource::Command),
            Some((input, true)) => (input, InputSource::Plan),
            None => {
                let source = if stopped { InputSource::Stop } else { InputSource::None };
                let (x, hold) = (&self.estimate, self.hold);
                let brake = match self.steering.filter(|_| stopped) {
                    Some(steering) => stop::brake_without_steering(rules, x, hold, steering),
                    None => stop::brake(rules, x, hold),
                };
                (brake, source)
            }
        };
        let crawls = rules.doubt.is_none_or(|limits| self.estimate.v_x < limits.crawl);
        let doubted = self.doubt.finding.reaction() >= Reaction::SlowDown;
        let slow = driven.is_some() && doubted && !crawls;
        let asked = if slow { Input { a: asked.a.min(0.0), ..asked } } else { asked };
        let cap = self.speed_cap.unwrap_or(f64::INFINITY).min(rules.limiter.speed_cap);
        let limiter = vehicle_model::Limiter { speed_cap: cap, ..rules.limiter };
        let applied = limiter.limit(asked, before, self.estimate.v_x, held);
        self.counts.limited += i64::from(applied.bits != 0);
        (self.applied, self.source) = (Some(applied), source);
    }
}
