//! Event logs of LCM: what `lcm-logger` writes and `lcm-logplayer` reads.
//!
//! Each event, big-endian: sync word, event number (i64), time stamp (i64, µs since 1970), length
//! of the channel (i32), length of the message (i32), channel, message. There is no checksum and no
//! index; after damage the reader goes on at the next event that can be one.

mod background;
mod reader;
#[cfg(test)]
mod tests;
mod writer;

pub use background::{BackgroundWriter, Totals};
pub use reader::{Damage, EventReader};
pub use writer::EventWriter;

/// What every event begins with.
pub const SYNC: u32 = 0xEDA1_DA01;
/// Bytes before the channel. \[B\]
pub const HEADER: usize = 28;
/// Longest channel in a log. \[B\]
pub const MAX_CHANNEL: usize = 255;
/// Largest message in a log; a larger length is taken for damage. \[B\]
pub const MAX_MESSAGE: usize = 64 << 20;

/// One message of a log.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Event {
    /// Number of the event, as written by the logger. [-]
    pub number: i64,
    /// When the logger received it, since 1970. \[us\]
    pub utime: i64,
    /// Channel.
    pub channel: String,
    /// The encoded message.
    pub data: Vec<u8>,
}
