//! Errors of construction. At run time there are none: see [`crate::Status`].

use crate::config::Problem;

/// Why a controller or its configuration could not be made.
#[derive(Debug, thiserror::Error)]
pub enum ConfigError {
    /// No TOML, an unknown key, or a wrong type; the message shows line and column.
    #[error("the configuration cannot be read:\n{0}")]
    Syntax(String),
    /// Values out of range, all of them.
    #[error("the configuration has values out of range:{}", list(.0))]
    Values(Vec<Problem>),
    /// Configuration, car and track do not fit together.
    #[error("{0}")]
    Mismatch(String),
}

impl ConfigError {
    pub(crate) fn syntax(error: toml::de::Error) -> Self {
        Self::Syntax(error.to_string())
    }

    pub(crate) fn merge(error: toml::ser::Error) -> Self {
        Self::Syntax(error.to_string())
    }
}

fn list(problems: &[Problem]) -> String {
    problems.iter().map(|p| format!("\n  {}: {}", p.key, p.message)).collect()
}
