//! Doubt of well-formed states and of the actuators: each rule compares two sources that must agree.
//!
//! A rule gives a level: 0 is agreement, 1 its limit. The worst level decides what is done about it:
//! report, slow down, safe stop.

mod bank;
mod limits;
mod motion;
pub(super) mod response;
mod room;
#[cfg(test)]
pub(crate) use room::beyond;

pub(super) use bank::Steering;
pub use limits::{DoubtLimitError, DoubtLimits};

use lcm_types::Heartbeat;
use vehicle_model::{Input, State};

use super::rules::Rules;
use bank::Bank;
use motion::Motion;
use response::ResponseModels;

/// What is doubted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, thiserror::Error)]
pub enum Suspicion {
    /// Nothing.
    #[default]
    #[error("nothing")]
    None,
    /// A corner of the body is beyond the edge of the track.
    #[error("the car's body is off the track")]
    OffTrack,
    /// The car faces against the direction of driving.
    #[error("the car faces the wrong way")]
    WrongWay,
    /// A safe stop that begins now would leave the track.
    #[error("the car is too fast to be stopped on the track")]
    Overspeed,
    /// The position moves less or more than the velocity of the same states.
    #[error("the position moves otherwise than its own velocity")]
    Position,
    /// The heading turns less or more than the yaw rate of the same states.
    #[error("the heading turns otherwise than its own yaw rate")]
    Heading,
    /// The speed does not follow the acceleration that was sent.
    #[error("the speed does not follow throttle and brake")]
    Drive,
    /// The yaw rate does not follow the steering angle that was sent, whatever the grip.
    #[error("the yaw rate does not follow the steering")]
    Steering,
}

/// Doubts with their codes in [`Heartbeat`].
const CODES: [(Suspicion, i8); 8] = [
    (Suspicion::None, Heartbeat::DOUBT_NONE),
    (Suspicion::OffTrack, Heartbeat::DOUBT_OFF_TRACK),
    (Suspicion::WrongWay, Heartbeat::DOUBT_WRONG_WAY),
    (Suspicion::Overspeed, Heartbeat::DOUBT_OVERSPEED),
    (Suspicion::Position, Heartbeat::DOUBT_POSITION),
    (Suspicion::Heading, Heartbeat::DOUBT_HEADING),
    (Suspicion::Drive, Heartbeat::DOUBT_DRIVE),
    (Suspicion::Steering, Heartbeat::DOUBT_STEERING),
];

impl Suspicion {
    /// `stop_doubt` of [`Heartbeat`].
    pub(super) fn code(self) -> i8 {
        let known = CODES.iter().find(|(what, _)| *what == self);
        known.map_or(Heartbeat::DOUBT_NONE, |(_, code)| *code)
    }

    /// The doubt behind a code; `None` for one of another version.
    pub(super) fn of_code(code: i8) -> Option<Self> {
        CODES.iter().find(|(_, known)| *known == code).map(|(what, _)| *what)
    }
}

/// What is done about a doubt.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub enum Reaction {
    /// Nothing.
    #[default]
    None,
    /// It is named in status and logs.
    Report,
    /// The car is not accelerated above a crawl, [`DoubtLimits::crawl`].
    SlowDown,
    /// The car is stopped.
    Stop,
}

/// The worst doubt after a state.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct DoubtFinding {
    /// What.
    pub what: Suspicion,
    /// 0 agreement, 1 the limit. \[-\]
    pub level: f64,
}

impl DoubtFinding {
    /// What is done about it.
    #[must_use]
    pub fn reaction(&self) -> Reaction {
        match self.level {
            level if level >= 1.0 => Reaction::Stop,
            level if level >= 0.75 => Reaction::SlowDown,
            level if level >= 0.5 => Reaction::Report,
            _ => Reaction::None,
        }
    }

    fn or(self, other: Self) -> Self {
        if other.level > self.level { other } else { self }
    }
}

/// What the rules remember.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Doubt {
    motion: Motion,
    response: ResponseModels,
    bank: Bank,
    /// Reckoned on while the states are doubted, else the last state.
    trusted: Option<State>,
    pub(super) finding: DoubtFinding,
}

impl Doubt {
    /// Compares a state with the one `dt` \[s\] before, over which `applied` was in force.
    pub(super) fn on_state(
        &mut self,
        rules: &Rules,
        limits: &DoubtLimits,
        (before, x): (&State, &State),
        applied: Input,
        dt: f64,
    ) -> DoubtFinding {
        let acting = self.response.acting();
        let motion = self.motion.on_state(rules, limits, before, x, dt);
        let response = self.response.on_state(rules, limits, x, applied, dt);
        let bank = self.bank.on_state(rules, limits, (before, x), &self.response, dt);
        let room = room::finding(rules, limits, x);
        let trusted = self.trusted.unwrap_or(*before);
        self.trusted = Some(if motion.level < TRUSTED {
            *x
        } else {
            super::stop::reckon(rules, &trusted, (acting, applied), dt).0
        });
        self.finding = motion.or(response).or(bank).or(room);
        self.finding
    }

    /// Goes on to learn what is wrong with the steering, while the car is being stopped for it.
    pub(super) fn on_stop(
        &mut self,
        rules: &Rules,
        limits: &DoubtLimits,
        (before, x): (&State, &State),
        applied: Input,
        dt: f64,
    ) {
        self.response.follow(rules, applied, dt);
        self.bank.on_state(rules, limits, (before, x), &self.response, dt);
    }

    /// What is wrong with a steering that is doubted.
    pub(super) fn steering(&self) -> Steering {
        self.bank.steering()
    }

    /// The last state that agreed with those before it, reckoned on to the present.
    pub(super) fn trusted(&self) -> Option<State> {
        self.trusted
    }
}

/// Below this level a state is taken as it is. \[-\]
const TRUSTED: f64 = 0.3;

/// What would refuse arming or starting here.
pub(super) fn place(rules: &Rules, x: &State) -> Option<Suspicion> {
    let limits = rules.doubt?;
    let finding = room::here(rules, &limits, x);
    (finding.level >= 1.0).then_some(finding.what)
}
