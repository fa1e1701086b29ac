//! What each order of the operator does.

use lcm_types::{ArmToken, BootId, MonoTime};

use super::doubt::{self, Doubt};
use super::hold::Hold;
use super::order::{Denied, MAX_CAP, Order, OrderKind};
use super::rules::Rules;
use super::step::Safety;
use super::stop_reason::StopReason;
use super::types::BridgeState;

impl Safety {
    /// Whether the car stands, by a fresh state.
    pub(super) fn standstill(&self, rules: &Rules, now: MonoTime) -> Result<(), Denied> {
        if self.seen.is_none() {
            return Err(Denied::NoState);
        }
        if !self.is_fresh(rules, now) {
            return Err(Denied::NotFresh);
        }
        let speed = self.estimate.v_x.hypot(self.estimate.v_y);
        if speed < rules.still { Ok(()) } else { Err(Denied::Moves { speed }) }
    }

    /// Whether the car is known to stand.
    #[must_use]
    pub fn stands(&self, rules: &Rules, now: MonoTime) -> bool {
        self.standstill(rules, now).is_ok()
    }

    /// Obeys an order of the operator.
    pub(super) fn on_order(
        &mut self,
        rules: &Rules,
        order: &Order,
        now: MonoTime,
    ) -> Result<(), Denied> {
        let name = self.bridge_state.name();
        let latched = matches!(self.bridge_state, BridgeState::Estop | BridgeState::Fault);
        match order.kind {
            OrderKind::Estop => self.leave(BridgeState::Estop, StopReason::Operator),
            OrderKind::Reset if !latched => return Err(Denied::NothingToReset),
            OrderKind::Reset => {
                self.standstill(rules, now)?;
                (self.bridge_state, self.blind, self.steering) = (BridgeState::Idle, false, None);
            }
            OrderKind::Unknown(command) => return Err(Denied::Unknown(command)),
            OrderKind::SpeedCap(cap) if (0.0..=MAX_CAP).contains(&cap) => {
                self.speed_cap = (cap > 0.0).then_some(cap);
            }
            OrderKind::SpeedCap(found) => return Err(Denied::Cap { found }),
            _ if latched => return Err(Denied::Latched(name)),
            OrderKind::Stop | OrderKind::Disarm => match self.bridge_state {
                BridgeState::Running => self.leave(BridgeState::SafeStop, StopReason::Operator),
                BridgeState::Armed => self.leave(BridgeState::Idle, StopReason::Operator),
                _ => {}
            },
            OrderKind::Arm { moving, controller } => {
                return self.arm(rules, (moving, controller), order, now);
            }
            OrderKind::Start => return self.start(rules, order, now),
        }
        Ok(())
    }

    fn arm(
        &mut self,
        rules: &Rules,
        (moving, controller): (bool, BootId),
        order: &Order,
        now: MonoTime,
    ) -> Result<(), Denied> {
        match self.bridge_state {
            BridgeState::Boot => return Err(Denied::NoState),
            BridgeState::Idle => {}
            // Said again: the grant stands.
            BridgeState::Armed => return Ok(()),
            bridge_state => return Err(Denied::BridgeState(bridge_state.name())),
        }
        match self.standstill(rules, now) {
            Err(Denied::Moves { .. }) if moving => {}
            other => other?,
        }
        let since = self.seen.and_then(|seen| seen.good_since).unwrap_or(now);
        let good_ns = now.ns_since(since);
        if good_ns < rules.ready_ns {
            return Err(Denied::NotGood { good_s: good_ns as f64 * 1e-9 });
        }
        if let Some(suspicion) = doubt::place(rules, &self.estimate) {
            return Err(Denied::Place(suspicion));
        }
        let since = now.minus_ns(rules.pulse_ns);
        let boot_id = self.controllers.choose(controller, since, &rules.setup)?;
        self.bridge_state = BridgeState::Armed;
        self.token = order.fresh.max(ArmToken::new(1));
        (self.armed, self.seq, self.stop_reason) = (Some(boot_id), None, StopReason::None);
        Ok(())
    }

    fn start(&mut self, rules: &Rules, order: &Order, now: MonoTime) -> Result<(), Denied> {
        if !matches!(self.bridge_state, BridgeState::Armed | BridgeState::Running) {
            return Err(Denied::NotArmed(self.bridge_state.name()));
        }
        if order.token != self.token || self.token.is_none() {
            return Err(Denied::Token { found: order.token });
        }
        if self.bridge_state == BridgeState::Running {
            match (self.deadman, order.deadman) {
                // In force from the first START that holds it, also of a car that drives already.
                (_, true) => self.deadman = Some(now),
                (Some(_), false) => self.leave(BridgeState::SafeStop, StopReason::Deadman),
                (None, false) => {}
            }
            return Ok(());
        }
        if let Some(suspicion) = doubt::place(rules, &self.estimate) {
            return Err(Denied::Place(suspicion));
        }
        (self.doubt, self.blind, self.steering) = (Doubt::default(), false, None);
        self.hold = Hold::default();
        (self.bridge_state, self.started, self.command) = (BridgeState::Running, now, None);
        self.deadman = order.deadman.then_some(now);
        Ok(())
    }
}
