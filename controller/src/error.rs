//! Errors of construction. At run time there are none: see [`crate::Status`].

use crate::config::ConfigProblem;
use vehicle_model::explain_unknown_key;

/// Why a controller or its configuration could not be made.
#[derive(Debug, thiserror::Error)]
pub enum ConfigError {
    /// No TOML, an unknown key, or a wrong type; the message shows line and column.
    #[error("the configuration cannot be read:\n{0}")]
    Syntax(String),
    /// Values out of range, all of them.
    #[error("the configuration has values out of range:{}", list(.0))]
    Values(Vec<ConfigProblem>),
    /// Configuration, car and track do not fit together.
    #[error("{0}")]
    Mismatch(String),
}

impl ConfigError {
    pub(crate) fn syntax(error: toml::de::Error) -> Self {
        Self::Syntax(explain_unknown_key(&error.to_string()))
    }

    pub(crate) fn merge(error: toml::ser::Error) -> Self {
        Self::Syntax(error.to_string())
    }
}

fn list(problems: &[ConfigProblem]) -> String {
    problems.iter().map(|p| format!("\n  {}: {}", p.key, p.message)).collect()
}

/// Why learned data were refused. Nothing is changed then.
#[derive(Debug, thiserror::Error, PartialEq, Eq)]
pub enum DataError {
    /// Not a file of learned data.
    #[error("no learned data: the file begins with {found:02x?}, expected \"LMPCDATA\"")]
    Magic {
        /// First bytes found.
        found: Vec<u8>,
    },
    /// Written by another version.
    #[error("learned data of format {found}; this version reads format {expected}")]
    Version {
        /// Version found.
        found: u32,
        /// Version expected.
        expected: u32,
    },
    /// Cut short or grown.
    #[error("learned data are damaged: {found} bytes of content, the header says {expected}")]
    Length {
        /// Bytes found behind the header.
        found: usize,
        /// Bytes announced.
        expected: u64,
    },
    /// Content and checksum differ.
    #[error("learned data are damaged: checksum {found:08x}, the header says {expected:08x}")]
    Checksum {
        /// CRC-32 of the content.
        found: u32,
        /// CRC-32 announced.
        expected: u32,
    },
    /// Intact but unreadable.
    #[error("learned data cannot be decoded: {0}")]
    Content(String),
    /// Of another car, track or configuration.
    #[error("learned data of another {what}: {detail}")]
    Mismatch {
        /// "car", "track" or "configuration".
        what: &'static str,
        /// What differs.
        detail: String,
    },
}
