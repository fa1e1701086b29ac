//! Messages for the host's log.

use crate::status::FmiStatus;

/// Names and meanings of the log categories every FMU here declares.
pub const CATEGORIES: [(&str, &str); 6] = [
    ("logEvents", "Events worth a line: a file loaded, a lap finished"),
    ("logStatusWarning", "Why a call returned warning"),
    ("logStatusDiscard", "Why a step was discarded"),
    ("logStatusError", "Why a call returned error"),
    ("logStatusFatal", "Why a call returned fatal"),
    ("logAll", "All of the above"),
];

/// One message.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LogMessage {
    /// What the message explains.
    pub status: FmiStatus,
    /// The message in words.
    pub text: String,
}

/// Messages of the call under way. They reach the host after the call has let go of the
/// instance, so a host's log function may call the FMU again.
#[derive(Debug, Default)]
pub struct CallLog {
    pub(crate) messages: Vec<LogMessage>,
}

impl CallLog {
    /// Notes an event; the call still returns *ok*.
    pub fn event(&mut self, text: impl Into<String>) {
        self.messages.push(LogMessage { status: FmiStatus::Ok, text: text.into() });
    }

    /// Warns; a call that would return *ok* returns *warning*.
    pub fn warn(&mut self, text: impl Into<String>) {
        self.messages.push(LogMessage { status: FmiStatus::Warning, text: text.into() });
    }

    pub(crate) fn worst(&self) -> FmiStatus {
        self.messages.iter().map(|m| m.status).max().unwrap_or(FmiStatus::Ok)
    }
}

/// Which messages the host wants.
#[derive(Clone, Debug)]
pub(crate) struct Filter {
    pub(crate) on: bool,
    wanted: [bool; CATEGORIES.len()],
}

impl Filter {
    pub(crate) fn new(on: bool) -> Self {
        Self { on, wanted: [true; CATEGORIES.len()] }
    }

    /// Chooses categories; none means all.
    pub(crate) fn choose(on: bool, names: &[&str]) -> Result<Self, String> {
        let mut wanted = [names.is_empty(); CATEGORIES.len()];
        for name in names {
            let Some(i) = CATEGORIES.iter().position(|(known, _)| known == name) else {
                let known: Vec<&str> = CATEGORIES.iter().map(|c| c.0).collect();
                return Err(format!("unknown log category '{name}'; known: {}", known.join(", ")));
            };
            wanted[i] = true;
        }
        Ok(Self { on, wanted })
    }

    /// Reasons for error and fatal always pass: a host that shows nothing else needs them.
    pub(crate) fn passes(&self, status: FmiStatus) -> bool {
        let all = self.wanted[CATEGORIES.len() - 1];
        let place = CATEGORIES.iter().position(|(name, _)| *name == status.category());
        status >= FmiStatus::Error || (self.on && (all || place.is_some_and(|i| self.wanted[i])))
    }
}
