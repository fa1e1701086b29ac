//! What can go wrong with a network.

use std::io;

use super::MAX_MESSAGE;

/// Why a network cannot be reached or a message cannot be sent.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The URL is none, or has an option no one knows.
    #[error("LCM URL `{url}`: {reason}")]
    Url {
        /// The URL.
        url: String,
        /// What was found and expected.
        reason: String,
    },
    /// The system refuses a socket or one of its options.
    #[error("{step} for {target}: {source}{hint}")]
    Socket {
        /// What was tried.
        step: &'static str,
        /// Group and port.
        target: String,
        /// The system's answer.
        source: io::Error,
        /// What would help, or nothing.
        hint: &'static str,
    },
    /// A channel name that is empty, too long, or holds spaces or control characters.
    #[error("channel {found:?}, expected 1 to 63 bytes without spaces and control characters")]
    Channel {
        /// The name.
        found: String,
    },
    /// A message above the limit.
    #[error("message of {found} bytes, expected at most {MAX_MESSAGE}")]
    TooLarge {
        /// Its size. \[B\]
        found: usize,
    },
    /// A message could not be sent.
    #[error("sending on `{channel}`: {source}")]
    Send {
        /// Channel.
        channel: String,
        /// The system's answer.
        source: io::Error,
    },
    /// liblcm takes its URL from the environment of the process alone, and finds another there.
    #[error("liblcm reads its URL from LCM_DEFAULT_URL, which is {found:?}, expected {expected:?}")]
    Environment {
        /// What the variable holds.
        found: String,
        /// The URL to be opened.
        expected: String,
    },
    /// Not in this build, or not with this implementation.
    #[error("{what}")]
    Unsupported {
        /// What, and why not.
        what: String,
    },
    /// The receiving thread has ended.
    #[error("the connection is closed")]
    Closed,
}
