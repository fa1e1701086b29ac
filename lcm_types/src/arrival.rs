//! The two clocks of a received message.

use crate::MonoTime;

/// When a message arrived.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Arrival {
    /// Wall clock, since 1970: for logs. \[us\]
    pub utime: i64,
    /// `CLOCK_MONOTONIC` of this host: for ages.
    pub mono: MonoTime,
}
