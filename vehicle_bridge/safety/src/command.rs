//! A command as the core sees it, and what it must be to be believed.

use lcm_types::{ArmToken, BootId, MonoTime, SeqNumber, plan_step};
use vehicle_model::{Input, Limiter};

/// Steps of a fallback plan that are kept; more are cut off. \[-\]
pub const PLAN: usize = 32;
/// Solvers keep bounds to their tolerance, plans are in single precision. \[m/s^2, rad\]
const TOLERANCE: f64 = 1e-4;

/// Why a command is refused, in the order of the checks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum Reject {
    /// Longer than any command, or too short for one.
    #[error("wrong size")]
    Size,
    /// Another type, or another version of it.
    #[error("wrong fingerprint")]
    Fingerprint,
    /// Checksum, or contents that do not decode.
    #[error("checksum or contents damaged")]
    Crc,
    /// The sender exceeded its rate limit.
    #[error("rate limit exceeded")]
    Rate,
    /// Not a number, or infinite.
    #[error("not finite")]
    NotFinite,
    /// Outside the car's box, or a time that cannot be.
    #[error("out of range")]
    Range,
    /// Too old on arrival.
    #[error("too old")]
    Stale,
    /// Not the controller that was armed.
    #[error("not from the controller that was armed")]
    Boot,
    /// Repeated, out of order, or far ahead.
    #[error("number out of sequence")]
    Sequence,
    /// Not the grant in force.
    #[error("wrong arm token")]
    Token,
    /// It answers no state of this bridge, or an old one.
    #[error("it answers no recent state of this bridge: is another car on this network?")]
    Unanswered,
}

/// A decoded command: fixed size, nothing checked yet but its form.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct DecodedCommand {
    /// Start of its sender.
    pub boot_id: BootId,
    /// Its number.
    pub seq: SeqNumber,
    /// When it was received, this host's clock.
    pub arrival: MonoTime,
    /// Oldest time on this host's clock that it is known to stem from: its own stamp if its sender
    /// is on this host, the state it answers if that was ours.
    pub since: MonoTime,
    /// Sequence number of the state of this bridge it answers, if it is one.
    pub answers: Option<SeqNumber>,
    /// Echo of the grant.
    pub token: ArmToken,
    /// Whether it asks for driving.
    pub drives: bool,
    /// Whether it asks for an emergency stop.
    pub estop: bool,
    /// What to apply.
    pub input: Input,
    /// Dead after this. \[ns\]
    pub valid_for_ns: i64,
    /// Fallback plan.
    pub plan: [Input; PLAN],
    /// Steps of the plan. \[-\]
    pub n_plan: usize,
    /// Length of one step. \[s\]
    pub plan_dt: f64,
}

impl DecodedCommand {
    /// Whether every number is one.
    pub(super) fn is_finite(&self) -> bool {
        self.input.is_finite()
            && self.plan_dt.is_finite()
            && self.plan().iter().all(Input::is_finite)
    }

    /// Whether everything asked is in the car's box.
    pub(super) fn in_range(&self, limiter: &Limiter) -> bool {
        let box_of = |u: &Input| {
            (limiter.a_min - TOLERANCE..=limiter.a_max + TOLERANCE).contains(&u.a)
                && u.delta.abs() <= limiter.delta_max + TOLERANCE
        };
        box_of(&self.input)
            && self.plan().iter().all(box_of)
            && self.plan_dt >= 0.0
            && self.valid_for_ns > 0
    }

    /// Whether its number may follow the last one believed.
    pub(super) fn follows(&self, last: Option<SeqNumber>) -> bool {
        last.is_none_or(|last| self.seq.follows(last))
    }

    /// The fallback plan.
    #[must_use]
    pub fn plan(&self) -> &[Input] {
        self.plan.get(..self.n_plan).unwrap_or(&self.plan)
    }

    /// What it asks for at `now`, and whether that is the fallback plan: its input until the
    /// next command is due, then its plan. `None` when it is dead.
    pub(super) fn input_at(&self, now: MonoTime, period_ns: i64) -> Option<(Input, bool)> {
        let age_ns = now.ns_since(self.arrival);
        if !self.drives || age_ns > self.valid_for_ns {
            return None;
        }
        let Some(step) = plan_step(age_ns, period_ns, self.plan_dt, self.plan().len()) else {
            return Some((self.input, false));
        };
        Some((self.plan().get(step).copied().unwrap_or(self.input), true))
    }
}
