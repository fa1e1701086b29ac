//! One channel: how often, how old, how much is missing.

use std::collections::{BTreeMap, VecDeque};

use lcm_types::Header;

use super::ChannelSeen;

/// Rates are of this time. \[ns\]
const WINDOW_NS: i64 = 2_000_000_000;
/// Arrivals kept for a rate; a storm is counted by the newest of them. \[-\]
const ARRIVALS: usize = 4096;
/// Starts of programs told apart. \[-\]
const SENDERS: usize = 64;

/// A channel so far.
#[derive(Debug, Clone, Default)]
pub(super) struct Stream {
    arrivals: VecDeque<i64>,
    bytes: usize,
    count: u64,
    lost: u64,
    unreadable: u64,
    /// Last number of each start.
    senders: BTreeMap<i64, i64>,
}

impl Stream {
    /// A message came; without a header it is of another's type, or not readable.
    pub(super) fn take(&mut self, bytes: usize, arrival_ns: i64) {
        self.arrivals.push_back(arrival_ns);
        if self.arrivals.len() > ARRIVALS {
            self.arrivals.pop_front();
        }
        (self.bytes, self.count) = (bytes, self.count + 1);
    }

    /// It is of the channel's type.
    pub(super) fn read(&mut self, h: &Header) {
        if self.senders.len() >= SENDERS && !self.senders.contains_key(&h.boot_id) {
            self.senders.clear();
        }
        if let Some(last) = self.senders.insert(h.boot_id, h.seq) {
            let missing = h.seq.saturating_sub(last).saturating_sub(1);
            self.lost += u64::try_from(missing).unwrap_or(0);
        }
    }

    /// It is not of the channel's type.
    pub(super) fn puzzle(&mut self) {
        self.unreadable += 1;
    }

    pub(super) fn seen(&self, name: &str, now_ns: i64) -> ChannelSeen {
        let last = self.arrivals.back().copied().unwrap_or(now_ns);
        let recent = |at: &&i64| now_ns.saturating_sub(**at) <= WINDOW_NS;
        let within = self.arrivals.iter().filter(recent).count();
        let first = self.arrivals.iter().find(recent).copied().unwrap_or(last);
        // Between the first and the last of n messages are n - 1 gaps.
        let span = last.saturating_sub(first) as f64 * 1e-9;
        let rate_hz = if span > 0.0 { (within - 1) as f64 / span } else { 0.0 };
        ChannelSeen {
            name: name.to_owned(),
            rate_hz,
            age_s: now_ns.saturating_sub(last).max(0) as f64 * 1e-9,
            bytes: self.bytes,
            count: self.count,
            lost: self.lost,
            senders: self.senders.len(),
            unreadable: self.unreadable,
        }
    }
}
