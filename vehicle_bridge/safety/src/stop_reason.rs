//! Why the car is being stopped.

use lcm_types::Heartbeat;

use super::doubt::Suspicion;

/// What made the core leave RUNNING or ARMED.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, thiserror::Error)]
pub enum StopReason {
    /// Nothing.
    #[default]
    #[error("")]
    None,
    /// No valid command in time.
    #[error("no valid command in time")]
    Commands,
    /// The last command's validity ended.
    #[error("the last command's validity ended")]
    Validity,
    /// No valid state in time.
    #[error("no valid state in time")]
    States,
    /// The bridge itself did not run.
    #[error("the bridge itself stood still")]
    Gap,
    /// The dead man's switch was released, or its holder fell silent.
    #[error("dead man's switch released")]
    Deadman,
    /// The controller asked to stop.
    #[error("the controller asked to stop")]
    Controller,
    /// The controller exceeded the rate limit.
    #[error("the controller sends too much")]
    Flood,
    /// The controller's heartbeats ended.
    #[error("no heartbeat of the controller")]
    Heartbeat,
    /// The operator.
    #[error("the operator's order")]
    Operator,
    /// The state or an actuator is doubted.
    #[error("{0}")]
    Doubt(Suspicion),
    /// The bridge is being ended.
    #[error("the bridge is being ended")]
    End,
    /// The car failed.
    #[error("the car failed")]
    Car,
}

/// Reasons with their codes in [`Heartbeat`]; the doubts have one of their own.
const CODES: [(StopReason, i8); 12] = [
    (StopReason::None, Heartbeat::STOP_NONE),
    (StopReason::Commands, Heartbeat::STOP_COMMANDS),
    (StopReason::Validity, Heartbeat::STOP_VALIDITY),
    (StopReason::States, Heartbeat::STOP_STATES),
    (StopReason::Gap, Heartbeat::STOP_GAP),
    (StopReason::Deadman, Heartbeat::STOP_DEADMAN),
    (StopReason::Controller, Heartbeat::STOP_CONTROLLER),
    (StopReason::Flood, Heartbeat::STOP_FLOOD),
    (StopReason::Heartbeat, Heartbeat::STOP_HEARTBEAT),
    (StopReason::Operator, Heartbeat::STOP_OPERATOR),
    (StopReason::End, Heartbeat::STOP_END),
    (StopReason::Car, Heartbeat::STOP_CAR),
];

impl StopReason {
    /// `stop_reason` and `stop_doubt` of [`Heartbeat`].
    #[must_use]
    pub fn codes(self) -> (i8, i8) {
        if let Self::Doubt(what) = self {
            return (Heartbeat::STOP_DOUBT, what.code());
        }
        let known = CODES.iter().find(|(reason, _)| *reason == self);
        (known.map_or(Heartbeat::STOP_NONE, |(_, code)| *code), Heartbeat::DOUBT_NONE)
    }

    /// The reason behind `stop_reason` and `stop_doubt` of a [`Heartbeat`]; `None` for codes of another
    /// version.
    #[must_use]
    pub fn of_codes(reason: i8, doubt: i8) -> Option<Self> {
        if reason == Heartbeat::STOP_DOUBT {
            return Suspicion::of_code(doubt).map(Self::Doubt);
        }
        CODES.iter().find(|(_, code)| *code == reason).map(|(known, _)| *known)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_reason_has_codes_of_its_own_that_lead_back() {
        let doubts = (0..8).filter_map(Suspicion::of_code).map(StopReason::Doubt);
        let reasons: Vec<_> = CODES.iter().map(|(reason, _)| *reason).chain(doubts).collect();
        assert_eq!(reasons.len(), 20);
        for (i, reason) in reasons.iter().enumerate() {
            let (code, doubt) = reason.codes();
            assert_eq!(StopReason::of_codes(code, doubt), Some(*reason));
            let same = reasons.iter().filter(|other| other.codes() == (code, doubt)).count();
            assert_eq!(same, 1, "{i}: {reason:?}");
        }
        assert_eq!(StopReason::of_codes(i8::MAX, 0), None);
        assert_eq!(StopReason::of_codes(Heartbeat::STOP_DOUBT, i8::MAX), None);
    }
}
