//! Fragments to messages, in bounded memory.

use std::net::SocketAddrV4;

use lcm_types::MonoTime;

use super::datagram::Fragment;

/// Messages in pieces at one time; the least recently touched gives way to a new one. [-]
pub const MAX_PARTIAL: usize = 8;
/// Largest message. \[B\]
pub const MAX_MESSAGE: usize = 1 << 20;
/// A message not whole this long after its first fragment is given up. \[ns\]
pub const EXPIRY_NS: i64 = 200_000_000;
/// Most fragments of a message: parts of 512 bytes, far below what any sender uses. [-]
const MAX_FRAGMENTS: usize = MAX_MESSAGE / 512;

/// What became of a fragment.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Outcome<'a> {
    /// The message is whole.
    Complete { channel: &'a str, payload: &'a [u8] },
    /// Parts are missing.
    Incomplete,
    /// This part was here already.
    Duplicate,
    /// Larger than is taken, or at odds with the parts before it.
    Refused,
}

/// Messages given up. [-]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct GivenUp {
    pub(super) expired: u64,
    pub(super) evicted: u64,
}

/// A message in pieces. Its memory is kept for the next one.
#[derive(Debug)]
struct Partial {
    active: bool,
    source: SocketAddrV4,
    sequence: u32,
    count: u16,
    started: MonoTime,
    touched: u64,
    channel: String,
    /// Size of the message. \[B\]
    size: usize,
    /// At least `size` bytes; what is behind them, and what has not come, is of earlier messages.
    payload: Vec<u8>,
    /// One bit for each fragment received.
    seen: Vec<u64>,
    /// Offset and length of each fragment received.
    spans: Vec<(usize, usize)>,
    missing: u16,
}

/// All messages in pieces, of all senders.
#[derive(Debug, Default)]
pub(super) struct Reassembly {
    partials: Vec<Partial>,
    given_up: GivenUp,
    /// Counts fragments: orders partial messages by use without a clock.
    tick: u64,
}

impl Reassembly {
    pub(super) fn given_up(&self) -> GivenUp {
        self.given_up
    }

    /// True while a message in pieces waits for the rest.
    pub(super) fn is_waiting(&self) -> bool {
        self.partials.iter().any(|partial| partial.active)
    }

    /// Adds a fragment that arrived at `now`.
    pub(super) fn insert(
        &mut self,
        source: SocketAddrV4,
        fragment: &Fragment<'_>,
        now: MonoTime,
    ) -> Outcome<'_> {
        self.expire(now);
        self.tick += 1;
        let size = fragment.size as usize;
        let count = usize::from(fragment.count);
        if size > MAX_MESSAGE || count > MAX_FRAGMENTS || count > size.max(1) {
            return Outcome::Refused;
        }
        let known = self
            .partials
            .iter()
            .position(|p| p.active && p.source == source && p.sequence == fragment.sequence);
        let index = known.unwrap_or_else(|| self.begin(source, fragment, now));
        let partial = &mut self.partials[index];
        partial.touched = self.tick;
        if partial.size != size || partial.count != fragment.count {
            return Outcome::Refused;
        }
        let (word, bit) = (usize::from(fragment.number) / 64, 1 << (fragment.number % 64));
        if partial.seen[word] & bit != 0 {
            return Outcome::Duplicate;
        }
        partial.seen[word] |= bit;
        partial.missing -= 1;
        // `Datagram::Fragment` ends within the message's size.
        let offset = fragment.offset as usize;
        partial.payload[offset..offset + fragment.part.len()].copy_from_slice(fragment.part);
        partial.spans[usize::from(fragment.number)] = (offset, fragment.part.len());
        if let Some(channel) = fragment.channel {
            partial.channel.push_str(channel);
        }
        if partial.missing > 0 {
            return Outcome::Incomplete;
        }
        partial.active = false;
        if !partial.is_contiguous() {
            return Outcome::Refused;
        }
        Outcome::Complete { channel: &partial.channel, payload: &partial.payload[..partial.size] }
    }

    /// Gives up what is too old at `now`.
    pub(super) fn expire(&mut self, now: MonoTime) {
        for partial in self.partials.iter_mut().filter(|p| p.active) {
            if now.ns_since(partial.started) > EXPIRY_NS {
                partial.active = false;
                self.given_up.expired += 1;
            }
        }
    }

    /// Makes room for a message and returns its place.
    fn begin(&mut self, source: SocketAddrV4, fragment: &Fragment<'_>, now: MonoTime) -> usize {
        let index = self.free_place(source);
        let partial = &mut self.partials[index];
        partial.active = true;
        partial.source = source;
        partial.sequence = fragment.sequence;
        partial.count = fragment.count;
        partial.missing = fragment.count;
        partial.started = now;
        partial.channel.clear();
        partial.size = fragment.size as usize;
        // Not cleared: a flood of beginnings would keep the receiver busy with that alone, and only a
        // message whose every byte has come is handed on.
        if partial.payload.len() < partial.size {
            partial.payload.resize(partial.size, 0);
        }
        partial.seen.clear();
        partial.seen.resize(usize::from(fragment.count).div_ceil(64), 0);
        partial.spans.clear();
        partial.spans.resize(usize::from(fragment.count), (0, 0));
        index
    }

    fn free_place(&mut self, source: SocketAddrV4) -> usize {
        if let Some(index) = self.partials.iter().position(|p| !p.active) {
            return index;
        }
        if self.partials.len() < MAX_PARTIAL {
            self.partials.push(Partial::new(source));
            return self.partials.len() - 1;
        }
        self.given_up.evicted += 1;
        // From the sender with the most messages in pieces, so that a flood of one sender's
        // beginnings does not take the places of the others.
        let held = |s: SocketAddrV4| self.partials.iter().filter(|p| p.source == s).count();
        let rank = |p: &Partial| (std::cmp::Reverse(held(p.source)), p.touched);
        let victim = self.partials.iter().enumerate().min_by_key(|(_, p)| rank(p));
        victim.map_or(0, |(index, _)| index)
    }
}

impl Partial {
    fn new(source: SocketAddrV4) -> Self {
        Self {
            active: false,
            source,
            sequence: 0,
            count: 0,
            started: MonoTime::default(),
            touched: 0,
            channel: String::new(),
            size: 0,
            payload: Vec::new(),
            seen: Vec::new(),
            spans: Vec::new(),
            missing: 0,
        }
    }

    /// True if the parts follow each other without gap or overlap: a message is never torn.
    fn is_contiguous(&self) -> bool {
        let end = self
            .spans
            .iter()
            .try_fold(0, |end, (offset, length)| (*offset == end).then_some(end + length));
        end == Some(self.size)
    }
}

#[cfg(test)]
#[path = "reassembly_tests.rs"]
mod tests;
