//! What a connection counts.

use std::collections::BTreeMap;
use std::net::SocketAddrV4;

use lcm_types::MonoTime;

/// Senders kept apart; beyond that the one silent for longest is forgotten. [-]
pub const MAX_SENDERS: usize = 64;

/// Counts since the connection was opened.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Statistics {
    /// Messages sent. [-]
    pub sent: u64,
    /// Messages that could not be sent. [-]
    pub send_errors: u64,
    /// Messages received whole, subscribed to or not. [-]
    pub received: u64,
    /// Bytes of those messages. \[B\]
    pub bytes: u64,
    /// Datagrams that are no LCM, and fragments at odds with their message. [-]
    pub malformed: u64,
    /// Fragments received. [-]
    pub fragments: u64,
    /// Fragments received again. [-]
    pub duplicate_fragments: u64,
    /// Messages given up because parts were missing after 200 ms. [-]
    pub expired: u64,
    /// Messages given up because others needed the room. [-]
    pub evicted: u64,
    /// Datagrams the kernel dropped because the receive buffer was full. [-]
    pub kernel_drops: u64,
    /// Errors of receiving; the receiver goes on. [-]
    pub receive_errors: u64,
    /// Sinks taken out because they panicked. [-]
    pub sink_panics: u64,
    /// Messages missing by the sequence numbers of all senders, forgotten ones included. [-]
    pub lost: u64,
    /// Each sender's messages, by address and port.
    pub senders: BTreeMap<SocketAddrV4, SenderStatistics>,
}

/// One sender's messages.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct SenderStatistics {
    /// Messages received whole. [-]
    pub received: u64,
    /// Messages missing by the sequence numbers; one that comes late is taken off again. [-]
    pub lost: u64,
    /// Messages that came after a later one. [-]
    pub late: u64,
    /// Sequence number expected next.
    next: u32,
    /// When the last message came.
    pub last: MonoTime,
}

impl Statistics {
    /// Counts a whole message.
    pub(super) fn count(
        &mut self,
        sender: SocketAddrV4,
        sequence: u32,
        size: usize,
        now: MonoTime,
    ) {
        self.received += 1;
        self.bytes += size as u64;
        if self.senders.len() >= MAX_SENDERS && !self.senders.contains_key(&sender) {
            let silent = self.senders.iter().min_by_key(|(_, s)| s.last).map(|(k, _)| *k);
            silent.and_then(|key| self.senders.remove(&key));
        }
        let first = SenderStatistics { next: sequence, ..SenderStatistics::default() };
        let known = self.senders.entry(sender).or_insert(first);
        known.received += 1;
        known.last = now;
        // The numbers wrap: a difference in the upper half is one backwards.
        let ahead = sequence.wrapping_sub(known.next);
        if ahead < u32::MAX / 2 {
            known.lost += u64::from(ahead);
            self.lost += u64::from(ahead);
            known.next = sequence.wrapping_add(1);
        } else {
            known.late += 1;
            let counted_as_lost = known.lost > 0;
            known.lost -= u64::from(counted_as_lost);
            self.lost = self.lost.saturating_sub(u64::from(counted_as_lost));
        }
    }
}

#[cfg(test)]
mod tests {
    use std::net::Ipv4Addr;

    use super::*;

    fn sender(port: u16) -> SocketAddrV4 {
        SocketAddrV4::new(Ipv4Addr::LOCALHOST, port)
    }

    #[test]
    fn gaps_are_counted_and_late_messages_taken_off() {
        let mut statistics = Statistics::default();
        for sequence in [u32::MAX - 1, u32::MAX, 0, 3, 1, 4] {
            statistics.count(sender(1), sequence, 10, MonoTime::default());
        }
        statistics.count(sender(2), 1_000_000, 10, MonoTime::default());
        let one = statistics.senders[&sender(1)];
        assert_eq!((one.received, one.lost, one.late), (6, 1, 1));
        assert_eq!((statistics.lost, statistics.received, statistics.bytes), (1, 7, 70));
    }

    #[test]
    fn the_number_of_senders_is_bounded() {
        let mut statistics = Statistics::default();
        for port in 1..=1000 {
            statistics.count(sender(port), 0, 1, MonoTime::from_ns(port.into()));
        }
        assert_eq!(statistics.senders.len(), MAX_SENDERS);
        assert!(statistics.senders.contains_key(&sender(1000)));
    }
}
