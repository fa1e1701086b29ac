//! The signature behind a message: who sent it, which of its messages it is, and a code over both
//! and the message that only holders of a key can make.
//!
//! It stands behind the encoded message, where decoders of LCM stop reading: programs that know
//! nothing of it decode the message as before. This module knows its form; the key and the code are
//! the sender's and the receiver's matter.
//!
//! | bytes | content |
//! |---|---|
//! | 8 | [`MAGIC`] |
//! | 8 | start: random number of the sender's start, big-endian |
//! | 8 | number of the message among all of this start, big-endian |
//! | 16 | code: HMAC-SHA-256, its first 128 bits |

/// What a signature begins with.
pub const MAGIC: [u8; 8] = *b"LMPCMAC1";
/// Bytes of the code. \[B\]
pub const TAG: usize = 16;
/// Bytes of a signature. \[B\]
pub const SIZE: usize = 24 + TAG;

/// A signature.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Signature {
    /// Random number of the sender's start. \[-\]
    pub start: i64,
    /// Number of the message among all of this start. \[-\]
    pub seq: i64,
    /// The code.
    pub tag: [u8; TAG],
}

impl Signature {
    /// Appends it to an encoded message.
    pub fn append_to(&self, bytes: &mut Vec<u8>) {
        bytes.extend_from_slice(&MAGIC);
        bytes.extend_from_slice(&self.start.to_be_bytes());
        bytes.extend_from_slice(&self.seq.to_be_bytes());
        bytes.extend_from_slice(&self.tag);
    }
}

/// The message, and the signature behind it if there is one.
///
/// ```
/// use lcm_types::signature::{Signature, split};
/// let signature = Signature { start: 7, seq: 1, tag: [3; 16] };
/// let mut bytes = b"message".to_vec();
/// signature.append_to(&mut bytes);
/// assert_eq!(split(&bytes), (&b"message"[..], Some(signature)));
/// assert_eq!(split(b"message"), (&b"message"[..], None));
/// ```
#[must_use]
pub fn split(bytes: &[u8]) -> (&[u8], Option<Signature>) {
    let found = bytes.split_last_chunk::<SIZE>().and_then(|(message, end)| {
        let (magic, end) = end.split_first_chunk()?;
        let (start, end) = end.split_first_chunk()?;
        let (seq, end) = end.split_first_chunk()?;
        let tag = end.first_chunk().copied()?;
        let signature =
            Signature { start: i64::from_be_bytes(*start), seq: i64::from_be_bytes(*seq), tag };
        (*magic == MAGIC).then_some((message, signature))
    });
    match found {
        Some((message, signature)) => (message, Some(signature)),
        None => (bytes, None),
    }
}
