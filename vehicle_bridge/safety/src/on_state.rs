//! What each state of the car changes.

use lcm_types::{MonoTime, VehicleState};
use vehicle_model::State;

use super::command::Reject;
use super::doubt::{DoubtFinding, Reaction, Suspicion};
use super::rules::Rules;
use super::step::{Safety, Seen};
use super::stop_reason::StopReason;
use super::types::{Answer, BridgeState};

impl Safety {
    pub(super) fn on_state(
        &mut self,
        rules: &Rules,
        x: &State,
        quality: i8,
        now: MonoTime,
    ) -> Answer {
        if quality < VehicleState::DEGRADED || !x.is_finite() {
            return Answer::Rejected(Reject::NotFinite);
        }
        // After a gap they have not been good for long, whatever they were before it.
        let unbroken = self.seen.filter(|_| self.is_fresh(rules, now));
        let since = unbroken.and_then(|seen| seen.good_since).unwrap_or(now);
        let good_since = (quality >= rules.quality).then_some(since);
        let before = self.seen.replace(Seen { at: now, good_since, x: *x });
        if !self.blind {
            (self.estimate, self.estimated) = (*x, now);
        }
        if self.bridge_state != BridgeState::Running {
            self.hold.on_state(rules, x, now);
        }
        if let Some(before) = before.filter(|_| self.bridge_state == BridgeState::Running) {
            self.question(rules, &before, x, now);
        }
        if let (Some(before), Some(_)) = (before, self.steering) {
            self.learn_steering(rules, &before, x, now);
        }
        if self.bridge_state == BridgeState::Boot {
            self.bridge_state = BridgeState::Idle;
        }
        Answer::Accepted
    }

    /// Doubts a state, and stops the car if it must not be believed.
    fn question(&mut self, rules: &Rules, before: &Seen, x: &State, now: MonoTime) {
        let Some(limits) = &rules.doubt else { return };
        let dt = now.ns_since(before.at) as f64 * 1e-9;
        if dt <= 0.0 {
            return;
        }
        let applied = self.applied.map(|applied| applied.sent).unwrap_or_default();
        let finding = self.doubt.on_state(rules, limits, (&before.x, x), applied, dt);
        if finding.reaction() == Reaction::Stop {
            let doubted = matches!(finding.what, Suspicion::Position | Suspicion::Heading);
            if let Some(trusted) = self.doubt.trusted().filter(|_| doubted) {
                (self.estimate, self.estimated, self.blind) = (trusted, now, true);
            }
            if finding.what == Suspicion::Steering {
                self.steering = Some(self.doubt.steering());
            }
            if finding.what == Suspicion::Drive {
                self.hold.press();
            }
            self.leave(BridgeState::SafeStop, StopReason::Doubt(finding.what));
        }
    }

    /// While the car is stopped for its steering, what is wrong with it becomes clearer.
    fn learn_steering(&mut self, rules: &Rules, before: &Seen, x: &State, now: MonoTime) {
        let Some(limits) = &rules.doubt else { return };
        let dt = now.ns_since(before.at) as f64 * 1e-9;
        let applied = self.applied.map(|applied| applied.sent).unwrap_or_default();
        self.doubt.on_stop(rules, limits, (&before.x, x), applied, dt);
        self.steering = Some(self.doubt.steering());
    }

    /// The worst doubt of the present drive.
    #[must_use]
    pub fn finding(&self) -> DoubtFinding {
        self.doubt.finding
    }

    /// Whether the car moved on though the brake held it, since the last START.
    #[must_use]
    pub fn creeps(&self) -> bool {
        self.hold.creeps()
    }
}
