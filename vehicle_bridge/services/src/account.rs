//! The bridge's status as text for people. Numbers until a heartbeat is sent: words are not made
//! at every tick.

use std::fmt;
use std::sync::Arc;

use vehicle_model::Limited;

use super::car_clock::ClockFinding;
use auth::Seal;
use safety::{DoubtFinding, Reaction, Reject};

/// What was not taken, last.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Refused {
    /// A command.
    Command(Reject),
    /// A heartbeat.
    Heartbeat(Reject),
    /// A step or a message, by the car's side.
    Car(Arc<str>),
}

impl fmt::Display for Refused {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Command(reject) => write!(f, "a command was refused: {reject}"),
            Self::Heartbeat(reject) => write!(f, "a heartbeat was refused: {reject}"),
            Self::Car(why) => f.write_str(why),
        }
    }
}

/// The bridge's account; its words are the text of `HB/bridge`.
#[derive(Debug, Clone, Default)]
pub(super) struct Account {
    /// Known from the start.
    pub(super) notes: Arc<[String]>,
    /// Ticks with an input that a limit moved. \[-\]
    pub(super) limited: i64,
    /// The last input.
    pub(super) applied: Option<Limited>,
    /// Ticks that never came. \[-\]
    pub(super) missed: u64,
    /// Messages the network refused. \[-\]
    pub(super) unsent: u64,
    /// The worst doubt.
    pub(super) doubt: DoubtFinding,
    /// The car moved on though the brake held it.
    pub(super) creeps: bool,
    /// Programs on the network that should not be there.
    pub(super) neighbours: Option<Arc<str>>,
    /// Why the relay gets no sign of life.
    pub(super) relay: Option<Arc<str>>,
    /// Before the network.
    pub(super) seal: Option<Seal>,
    /// A real car's messages.
    pub(super) car: Option<mapping::CarMessageCounts>,
    /// A real car's clock, if it drifts from this host's.
    pub(super) clock: Option<ClockFinding>,
    /// Last refusal.
    pub(super) refused: Option<Refused>,
}

impl fmt::Display for Account {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut between = "";
        let mut say = |words: fmt::Arguments<'_>| {
            let separator = std::mem::replace(&mut between, "; ");
            write!(f, "{separator}{words}")
        };
        for note in &*self.notes {
            say(format_args!("{note}"))?;
        }
        if let Some(Limited { asked, sent, bits }) = self.applied.filter(|_| self.limited > 0) {
            say(format_args!(
                "{} inputs limited; now asked {:.2} m/s^2, {:.3} rad, sent {:.2}, {:.3}, limits {bits:#x}",
                self.limited, asked.a, asked.delta, sent.a, sent.delta
            ))?;
        }
        if self.missed > 0 {
            say(format_args!("{} ticks missed", self.missed))?;
        }
        if self.unsent > 0 {
            say(format_args!("{} messages could not be sent", self.unsent))?;
        }
        if let Some(complaint) = self.seal.as_ref().and_then(Seal::complaint) {
            say(format_args!("{complaint}"))?;
        }
        if let Some(relay) = &self.relay {
            say(format_args!("{relay}"))?;
        }
        if self.doubt.reaction() >= Reaction::Report {
            let DoubtFinding { what, level } = self.doubt;
            say(format_args!("doubt: {what} ({level:.1} of its limit)"))?;
        }
        if self.creeps {
            say(format_args!(
                "the car moved on though the brake held it (throttle off, or a slope): it is held \
                 with all the brake there is"
            ))?;
        }
        if let Some(neighbours) = &self.neighbours {
            say(format_args!("{neighbours}"))?;
        }
        if let Some(counts) = self.car {
            say(format_args!("{counts}"))?;
        }
        if let Some(clock) = self.clock {
            say(format_args!("{clock}"))?;
        }
        if let Some(refused) = &self.refused {
            say(format_args!("{refused}"))?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use vehicle_model::Input;

    use super::*;

    #[test]
    fn the_account_says_what_there_is_to_say() {
        assert_eq!(Account::default().to_string(), "");
        let account = Account {
            notes: Arc::new(["a note".to_owned()]),
            limited: 3,
            applied: Some(Limited { asked: Input::default(), sent: Input::default(), bits: 4 }),
            missed: 1,
            unsent: 2,
            car: Some(mapping::CarMessageCounts::default()),
            clock: Some(ClockFinding { late: 0.0211, drift: 6e-4 }),
            doubt: DoubtFinding::default(),
            creeps: true,
            neighbours: Some("another bridge".into()),
            refused: Some(Refused::Heartbeat(Reject::Boot)),
            seal: None,
            relay: None,
        };
        assert_eq!(
            account.to_string(),
            "a note; 3 inputs limited; now asked 0.00 \
             m/s^2, 0.000 rad, sent 0.00, 0.000, limits 0x4; 1 ticks missed; 2 messages could not \
             be sent; the car moved on though the brake held it (throttle off, or a slope): it is \
             held with all the brake there is; another bridge; car: 0 states, 0 bad, 0 old, 0 incomplete; states of the car arrive 21 ms \
             later than their stamps say, +600 us/s since the first; expected at most 20 ms, and a \
             drift of at most 500 us/s: compare the car's clock with this host's, and look for a \
             network that has become slower; a heartbeat was refused: not from \
             the controller that was armed"
        );
    }
}
