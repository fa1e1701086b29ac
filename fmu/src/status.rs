//! What a call may answer, and why.

/// Status codes shared by FMI 2.0 (`fmi2Status`) and FMI 3.0 (`fmi3Status`).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[repr(i32)]
pub enum FmiStatus {
    /// All well.
    Ok = 0,
    /// Done, but the host's user should read the message.
    Warning = 1,
    /// Not done and nothing changed; a smaller step may succeed.
    Discard = 2,
    /// Not done, outputs unchanged.
    Error = 3,
    /// The instance's memory can no longer be trusted; only freeing it is left.
    Fatal = 4,
}

impl FmiStatus {
    /// The log category a message of this status belongs to (names fixed by both standards).
    #[must_use]
    pub fn category(self) -> &'static str {
        match self {
            Self::Ok => "logEvents",
            Self::Warning => "logStatusWarning",
            Self::Discard => "logStatusDiscard",
            Self::Error => "logStatusError",
            Self::Fatal => "logStatusFatal",
        }
    }
}

/// Why a call was not carried out.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum CallError {
    /// The step was not taken and nothing changed; a smaller one may succeed. Status *discard*.
    #[error("{0}")]
    Discard(String),
    /// The call broke the interface's rules and was ignored; the instance is as before it.
    /// Status *error*.
    #[error("{0}")]
    Refused(String),
    /// The model cannot go on: reset, restore an earlier state, or free. Status *error*.
    #[error("{0}")]
    Failed(String),
    /// The instance's memory can no longer be trusted. Status *fatal*.
    #[error("{0}")]
    Fatal(String),
}

impl CallError {
    /// The status the host gets for this fault.
    #[must_use]
    pub fn status(&self) -> FmiStatus {
        match self {
            Self::Discard(_) => FmiStatus::Discard,
            Self::Refused(_) | Self::Failed(_) => FmiStatus::Error,
            Self::Fatal(_) => FmiStatus::Fatal,
        }
    }
}
