//! The rules of `docs/safety.md` a second time, from what was said and when: what the core has to
//! answer, and in which state it has to be.

use std::collections::BTreeMap;

use super::*;

/// What the rules demand so far.
#[derive(Default)]
pub(super) struct Model {
    pub(super) bridge_state: BridgeState,
    pub(super) stop_reason: StopReason,
    pub(super) token: ArmToken,
    pub(super) counts: CommandCounts,
    /// The command in force.
    pub(super) command: Option<DecodedCommand>,
    /// Cap ordered. \[m/s\]
    pub(super) cap: Option<f64>,
    /// Last state: when, and its speed. \[ns, m/s\]
    pub(super) state: Option<(i64, f64)>,
    pub(super) tick: Option<i64>,
    /// When the car had the last input. \[ns\]
    pub(super) sent: Option<i64>,
    /// Who has the grant.
    holder: BootId,
    last_seq: Option<SeqNumber>,
    started: i64,
    /// When the dead man's switch was last said to be held. \[ns\]
    held: Option<i64>,
    good_since: Option<i64>,
    /// Heartbeat and setup of each controller, and when anything of it came last.
    heard: BTreeMap<BootId, (Option<i64>, Option<Setup>, i64)>,
    /// States that went out, and when.
    published: BTreeMap<SeqNumber, i64>,
    said: BTreeMap<BootId, (i64, u32)>,
}

impl Model {
    /// Takes an event; `damage` is what was done to the command on purpose.
    pub(super) fn take(
        &mut self,
        rules: &Rules,
        event: &BridgeEvent<'_>,
        damage: Option<Reject>,
        now: i64,
    ) -> Answer {
        self.let_time_pass(rules, event, now);
        match event {
            BridgeEvent::State(x, quality) => {
                if *quality < 1 || !x.v_x.is_finite() {
                    self.counts.bad += 1;
                    return Answer::Rejected(Reject::NotFinite);
                }
                if *quality < 2 {
                    self.good_since = None;
                } else if self.good_since.is_none() || !self.fresh(rules, now) {
                    self.good_since = Some(now);
                }
                self.state = Some((now, x.v_x.hypot(x.v_y)));
                if self.bridge_state == BridgeState::Boot {
                    self.bridge_state = BridgeState::Idle;
                }
                Answer::Accepted
            }
            BridgeEvent::Command(offer) => self.hear(rules, offer, damage, now),
            BridgeEvent::Heartbeat(sender) => {
                let granted =
                    matches!(self.bridge_state, BridgeState::Armed | BridgeState::Running);
                if granted && *sender != self.holder {
                    self.counts.old += 1;
                    return Answer::Rejected(Reject::Boot);
                }
                self.entry(*sender, now).0 = Some(now);
                Answer::None
            }
            BridgeEvent::Setup(sender, setup) => {
                self.entry(*sender, now).1 = Some(*setup);
                Answer::None
            }
            BridgeEvent::Published(seq) => {
                self.published.insert(*seq, now);
                Answer::None
            }
            BridgeEvent::End => {
                match self.bridge_state {
                    BridgeState::Running => self.end(BridgeState::SafeStop, StopReason::End),
                    BridgeState::Armed => self.end(BridgeState::Idle, StopReason::End),
                    _ => {}
                }
                Answer::None
            }
            BridgeEvent::Order(order) => match self.on_order(rules, order, now) {
                None => Answer::Accepted,
                Some(denied) => Answer::Denied(denied),
            },
            BridgeEvent::CarFailed => {
                let to = if self.bridge_state == BridgeState::Estop {
                    BridgeState::Estop
                } else {
                    BridgeState::Fault
                };
                self.end(to, StopReason::Car);
                Answer::None
            }
            BridgeEvent::Tick => {
                if self.bridge_state == BridgeState::SafeStop && self.stands(rules, now) {
                    self.bridge_state = BridgeState::Idle;
                }
                self.tick = Some(now);
                Answer::None
            }
            BridgeEvent::Sent => {
                self.sent = Some(now);
                Answer::None
            }
        }
    }

    fn entry(&mut self, sender: BootId, now: i64) -> &mut (Option<i64>, Option<Setup>, i64) {
        let entry = self.heard.entry(sender).or_insert((None, None, now));
        entry.2 = now;
        entry
    }

    fn fresh(&self, rules: &Rules, now: i64) -> bool {
        self.state.is_some_and(|(at, _)| now - at <= silence(rules, rules.state_ns))
    }

    /// By the last state; between two of them the car may have begun to move or come to a stand.
    pub(super) fn stands(&self, rules: &Rules, now: i64) -> bool {
        self.fresh(rules, now) && self.state.is_some_and(|(_, speed)| speed < rules.still)
    }

    fn end(&mut self, to: BridgeState, why: StopReason) {
        self.counts.stops += i64::from(self.bridge_state == BridgeState::Running);
        (self.bridge_state, self.stop_reason, self.token) = (to, why, ArmToken::NONE);
        (self.command, self.last_seq, self.held) = (None, None, None);
    }

    fn let_time_pass(&mut self, rules: &Rules, event: &BridgeEvent<'_>, now: i64) {
        let to = match self.bridge_state {
            BridgeState::Armed => BridgeState::Idle,
            BridgeState::Running => BridgeState::SafeStop,
            _ => return,
        };
        let patience = rules.tick_ns + rules.timeout_ns;
        let is_state = matches!(event, BridgeEvent::State(..));
        let beat = self.heard.get(&self.holder).and_then(|(beat, ..)| *beat);
        let pulse = beat.unwrap_or(i64::MIN / 2);
        let begun = self.bridge_state == BridgeState::Running;
        let late = self.command.map_or(now - self.started > rules.start_ns, |c| {
            time(now).ns_since(c.arrival) > silence(rules, rules.period_ns)
        });
        let dead = self.command.is_some_and(|c| time(now).ns_since(c.arrival) > c.valid_for_ns);
        let causes = [
            (self.tick.is_some_and(|at| now - at > patience), StopReason::Gap),
            (!is_state && !self.fresh(rules, now), StopReason::States),
            (!begun && now - pulse > rules.pulse_ns, StopReason::Heartbeat),
            (begun && self.held.is_some_and(|at| now - at > rules.timeout_ns), StopReason::Deadman),
            (begun && late, StopReason::Commands),
            (begun && dead, StopReason::Validity),
        ];
        if let Some((_, why)) = causes.into_iter().find(|(is, _)| *is) {
            self.end(to, why);
        }
    }

    fn hear(
        &mut self,
        rules: &Rules,
        offer: &DecodedCommand,
        damage: Option<Reject>,
        now: i64,
    ) -> Answer {
        let (begun, count) = self.said.entry(offer.boot_id).or_insert((now, 0));
        if now - *begun >= 100 * MS {
            (*begun, *count) = (now, 0);
        }
        *count += 1;
        let much = *count > 100;
        let granted = matches!(self.bridge_state, BridgeState::Armed | BridgeState::Running);
        let reject = if much {
            Some(Reject::Rate)
        } else if damage.is_some_and(|d| (d as u8) < Reject::Boot as u8) {
            damage
        } else if !granted || offer.boot_id != self.holder {
            Some(Reject::Boot)
        } else {
            damage.filter(|d| *d != Reject::Boot && *d != Reject::Unanswered)
        };
        let patience = rules.max_age_ns.min(offer.valid_for_ns);
        let recent = |seq| self.published.get(&seq).is_some_and(|at| now - at <= patience);
        let unanswered = offer.drives && !offer.answers.is_some_and(recent);
        let reject = reject.or(unanswered.then_some(Reject::Unanswered));
        if let Some(reject) = reject {
            match reject {
                Reject::Stale => self.counts.stale += 1,
                Reject::Boot | Reject::Sequence | Reject::Token | Reject::Unanswered => {
                    self.counts.old += 1;
                }
                _ => self.counts.bad += 1,
            }
            if much && self.bridge_state == BridgeState::Running && offer.boot_id == self.holder {
                self.end(BridgeState::SafeStop, StopReason::Flood);
            }
            return Answer::Rejected(reject);
        }
        self.counts.ok += 1;
        self.counts.lost += self.last_seq.map_or(0, |last| offer.seq.get() - last.get() - 1);
        self.last_seq = Some(offer.seq);
        match (self.bridge_state, offer.estop, offer.drives) {
            (_, true, _) => self.end(BridgeState::Estop, StopReason::Controller),
            (BridgeState::Running, _, true) => self.command = Some(*offer),
            (BridgeState::Running, _, false) if self.command.is_some() => {
                self.end(BridgeState::SafeStop, StopReason::Controller);
            }
            _ => {}
        }
        Answer::Accepted
    }

    fn on_order(&mut self, rules: &Rules, order: &Order, now: i64) -> Option<Denied> {
        use OrderKind::{Arm, Disarm, Estop, Reset, SpeedCap, Start, Stop, Unknown};
        let (bridge_state, name) = (self.bridge_state, self.bridge_state.name());
        let latched = matches!(bridge_state, BridgeState::Estop | BridgeState::Fault);
        let seen = match self.state {
            None => Some(Denied::NoState),
            Some(_) if !self.fresh(rules, now) => Some(Denied::NotFresh),
            Some((_, speed)) if speed >= rules.still => Some(Denied::Moves { speed }),
            Some(_) => None,
        };
        match order.kind {
            Estop => self.end(BridgeState::Estop, StopReason::Operator),
            Reset if latched && seen.is_some() => return seen,
            Reset if latched => self.bridge_state = BridgeState::Idle,
            Reset => return Some(Denied::NothingToReset),
            Unknown(n) => return Some(Denied::Unknown(n)),
            SpeedCap(found) if !(0.0..=1000.0).contains(&found) => {
                return Some(Denied::Cap { found });
            }
            SpeedCap(cap) => self.cap = Some(cap).filter(|cap| *cap > 0.0),
            _ if latched => return Some(Denied::Latched(name)),
            Stop | Disarm if bridge_state == BridgeState::Running => {
                self.end(BridgeState::SafeStop, StopReason::Operator);
            }
            Stop | Disarm if bridge_state == BridgeState::Armed => {
                self.end(BridgeState::Idle, StopReason::Operator)
            }
            Stop | Disarm => {}
            Arm { .. } if bridge_state == BridgeState::Armed => {}
            Arm { .. } if bridge_state == BridgeState::Boot => return Some(Denied::NoState),
            Arm { .. } if bridge_state != BridgeState::Idle => {
                return Some(Denied::BridgeState(name));
            }
            Arm { moving, controller } => {
                let good_ns = self.good_since.map_or(0, |since| now - since);
                match seen {
                    Some(Denied::Moves { .. }) if moving => {}
                    Some(denied) => return Some(denied),
                    None => {}
                }
                if good_ns < rules.ready_ns {
                    return Some(Denied::NotGood { good_s: good_ns as f64 * 1e-9 });
                }
                let live: Vec<BootId> = self
                    .heard
                    .iter()
                    .filter(|(_, (beat, ..))| beat.is_some_and(|at| now - at <= rules.pulse_ns))
                    .map(|(sender, _)| *sender)
                    .collect();
                let holder = match live[..] {
                    [] => return Some(Denied::NoController),
                    _ if live.contains(&controller) => controller,
                    [heard, ..] if !controller.is_none() => {
                        return Some(Denied::OtherController { wanted: controller, heard });
                    }
                    [one] => one,
                    [one, two, ..] => return Some(Denied::Controllers(one, two)),
                };
                let Some(setup) = self.heard[&holder].1 else { return Some(Denied::NoSetup) };
                if let Some(denied) = mismatch(&setup, &rules.setup) {
                    return Some(denied);
                }
                (self.bridge_state, self.token, self.stop_reason) =
                    (BridgeState::Armed, order.fresh, StopReason::None);
                self.holder = holder;
            }
            Start if self.token.is_none() => return Some(Denied::NotArmed(name)),
            Start if order.token != self.token => {
                return Some(Denied::Token { found: order.token });
            }
            Start if bridge_state == BridgeState::Armed => {
                (self.bridge_state, self.started) = (BridgeState::Running, now);
                self.held = order.deadman.then_some(now);
            }
            Start if order.deadman => self.held = Some(now),
            Start if self.held.is_none() => {}
            Start => self.end(BridgeState::SafeStop, StopReason::Deadman),
        }
        None
    }

    /// Since when the car has its input: its tick's, if nobody said that it came later. \[ns\]
    pub(super) fn held_since(&self) -> Option<i64> {
        self.sent.into_iter().chain(self.tick).max()
    }

    /// Number of the last command believed. \[-\]
    pub(super) fn last_seq(&self) -> Option<i64> {
        self.last_seq.map(SeqNumber::get)
    }
}

fn mismatch(theirs: &Setup, ours: &Setup) -> Option<Denied> {
    let ms = |ns: i64| ns as f64 * 1e-6;
    let one = |controller: i64, bridge: i64| controller * bridge != 0 && controller != bridge;
    if theirs.track_id != ours.track_id {
        return Some(Denied::Track { controller: theirs.track_id, car: ours.track_id });
    }
    let (car, period, config) = (
        one(theirs.car_id, ours.car_id),
        one(theirs.period_ns, ours.period_ns),
        one(theirs.config_id, ours.config_id),
    );
    match (car, period, config) {
        (true, ..) => Some(Denied::Car { controller: theirs.car_id, bridge: ours.car_id }),
        (_, true, _) => {
            let (controller_ms, bridge_ms) = (ms(theirs.period_ns), ms(ours.period_ns));
            Some(Denied::Period { controller_ms, bridge_ms })
        }
        (.., true) => Some(Denied::Config { controller: theirs.config_id, bridge: ours.config_id }),
        _ => None,
    }
}

/// Longest silence of what comes every `every` \[ns\]: until the timeout, or, where that is at least as
/// long as `every`, until half of it after the second one that is due. \[ns\]
pub(super) fn silence(rules: &Rules, every: i64) -> i64 {
    let usual = every + rules.timeout_ns;
    if rules.timeout_ns < every { usual } else { usual.max(2 * every + rules.timeout_ns / 2) }
}
