//! What can be wrong with a message or a log.

use std::borrow::Cow;

use crate::schema::SchemaError;

/// Why bytes are no message, a message cannot be encoded, or a log cannot be read.
///
/// `field` is the full name of the field, `package.type.member`; `offset` counts bytes from the
/// first byte of the fingerprint.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The message ends too early.
    #[error("{field}: {needed} bytes needed at offset {offset}, {left} left")]
    Short {
        /// Field being read.
        field: Cow<'static, str>,
        /// Where. \[B\]
        offset: usize,
        /// Bytes the field takes at least. \[B\]
        needed: usize,
        /// Bytes left. \[B\]
        left: usize,
    },
    /// A length is negative or larger than the message accounts for.
    #[error("{field}: length {found} before offset {offset}, expected 0 to {limit}")]
    Length {
        /// Field being read.
        field: Cow<'static, str>,
        /// Where. \[B\]
        offset: usize,
        /// The length. [-]
        found: i64,
        /// Largest length possible here. [-]
        limit: usize,
    },
    /// A boolean is neither 0 nor 1.
    #[error("{field}: boolean {found} at offset {offset}, expected 0 or 1")]
    Boolean {
        /// Field being read.
        field: Cow<'static, str>,
        /// Where. \[B\]
        offset: usize,
        /// The byte found.
        found: u8,
    },
    /// A string is not UTF-8.
    #[error("{field}: string before offset {offset} is not UTF-8")]
    Utf8 {
        /// Field being read.
        field: Cow<'static, str>,
        /// Where. \[B\]
        offset: usize,
    },
    /// A string holds a NUL, or does not end in one.
    #[error("{field}: string before offset {offset}, expected one NUL, at its end")]
    Nul {
        /// Field being read or written.
        field: Cow<'static, str>,
        /// Where. \[B\]
        offset: usize,
    },
    /// The message is of another type, or of another version of it.
    #[error("fingerprint {found:#018x}, expected {expected:#018x} of {name}")]
    Fingerprint {
        /// Type expected.
        name: Cow<'static, str>,
        /// The first eight bytes.
        found: u64,
        /// The type's fingerprint.
        expected: u64,
    },
    /// Bytes follow the last field.
    #[error("{bytes} bytes behind the last field of {name}, expected none")]
    Trailing {
        /// Type being read.
        name: Cow<'static, str>,
        /// Number of bytes. \[B\]
        bytes: usize,
    },
    /// The checksum does not fit the bytes.
    #[error("CRC {found:#010x} of {name}, computed {expected:#010x}")]
    Crc {
        /// Type being read.
        name: &'static str,
        /// CRC in the message.
        found: u32,
        /// CRC of the bytes before it.
        expected: u32,
    },
    /// An array and its length field disagree; nothing was encoded.
    #[error("{field}: {found} elements, expected {expected} by its length field")]
    Count {
        /// Field being written.
        field: Cow<'static, str>,
        /// Elements present. [-]
        found: usize,
        /// Value of the length field. [-]
        expected: i64,
    },
    /// A value does not have the type its schema asks for.
    #[error("{field}: found {found}, expected {expected}")]
    Kind {
        /// Field being written.
        field: Cow<'static, str>,
        /// What was given.
        found: &'static str,
        /// What the schema says.
        expected: String,
    },
    /// A foreign type nests deeper than is read.
    #[error("{field}: more than {limit} structs inside each other")]
    Depth {
        /// Field being read or written.
        field: Cow<'static, str>,
        /// Deepest nesting allowed. [-]
        limit: usize,
    },
    /// No such type.
    #[error("type {name} is in none of the .lcm files given")]
    UnknownType {
        /// Name asked for.
        name: String,
    },
    /// A mistake in a `.lcm` file.
    #[error(transparent)]
    Schema(#[from] SchemaError),
    /// A channel or a message is larger than a log holds.
    #[error("{what} of {found} bytes in a log, expected 1 to {limit}")]
    LogSize {
        /// "channel" or "message".
        what: &'static str,
        /// Its size. \[B\]
        found: usize,
        /// Largest size. \[B\]
        limit: usize,
    },
    /// A log file cannot be read or written.
    #[error("log file: {0}")]
    Io(#[from] std::io::Error),
}

impl Error {
    /// The same error, about the field called `path` if it names none yet.
    #[must_use]
    pub(crate) fn at(mut self, path: impl FnOnce() -> String) -> Self {
        match &mut self {
            Self::Short { field, .. }
            | Self::Length { field, .. }
            | Self::Boolean { field, .. }
            | Self::Utf8 { field, .. }
            | Self::Nul { field, .. }
            | Self::Count { field, .. }
                if field.is_empty() =>
            {
                *field = path().into();
            }
            _ => {}
        }
        self
    }
}
