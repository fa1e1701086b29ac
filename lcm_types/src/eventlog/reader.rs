//! Reading a log, damaged or not.

use std::io::{self, Read};

use super::{Event, HEADER, MAX_CHANNEL, MAX_MESSAGE, SYNC};
use crate::Error;

const CHUNK: usize = 64 << 10;
/// Most bytes before the first event: what begins with more is no log, or a device without end. \[B\]
const MOST_BEFORE: u64 = 256 << 20;

/// What was skipped so far.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Damage {
    /// Places where the log did not go on with an event. [-]
    pub places: u64,
    /// Bytes skipped there. \[B\]
    pub bytes: u64,
}

/// Events of a log, in the order of the file. Bytes that are no event are skipped and counted.
#[derive(Debug)]
pub struct EventReader<R> {
    input: R,
    /// Bytes read and not yet used: `buffer[start..]`.
    buffer: Vec<u8>,
    start: usize,
    ended: bool,
    in_sync: bool,
    any: bool,
    damage: Damage,
}

/// The lengths of an event whose header can be one.
struct Header {
    number: i64,
    utime: i64,
    channel: usize,
    data: usize,
}

impl<R: Read> EventReader<R> {
    /// Reads `input` from where it stands.
    pub fn new(input: R) -> Self {
        let damage = Damage::default();
        Self {
            input,
            buffer: Vec::new(),
            start: 0,
            ended: false,
            in_sync: true,
            any: false,
            damage,
        }
    }

    /// What was skipped so far.
    #[must_use]
    pub fn damage(&self) -> Damage {
        self.damage
    }

    /// The next whole event; `None` at the end.
    ///
    /// # Errors
    /// [`Error::Io`] only: of the input, or of one that begins with 256 MiB without an event.
    pub fn next_event(&mut self) -> Result<Option<Event>, Error> {
        loop {
            if !self.fill(HEADER)? {
                self.skip(self.held());
                return Ok(None);
            }
            let Some(header) = self.header_at(self.start) else {
                self.skip_to_sync(1)?;
                continue;
            };
            let size = HEADER + header.channel + header.data;
            let whole = self.fill(size)?;
            // A length is believed only if the next event, or the end, stands where it says.
            let believed = (whole && self.continues_at(size)?) || self.next_sync_is_behind(size)?;
            if !believed {
                self.skip_to_sync(1)?;
                continue;
            }
            if let Some(event) = self.event(&header) {
                self.start += size;
                self.in_sync = true;
                self.any = true;
                return Ok(Some(event));
            }
            self.skip_to_sync(1)?;
        }
    }

    fn held(&self) -> usize {
        self.buffer.len() - self.start
    }

    /// Reads until `size` bytes are held; false if the input ends before.
    fn fill(&mut self, size: usize) -> Result<bool, Error> {
        if self.held() >= size {
            return Ok(true);
        }
        self.buffer.drain(..self.start);
        self.start = 0;
        while self.buffer.len() < size && !self.ended {
            // Grows with what is really there, not with what a header claims.
            let taken = self.input.by_ref().take(CHUNK as u64).read_to_end(&mut self.buffer)?;
            self.ended = taken == 0;
        }
        Ok(self.buffer.len() >= size)
    }

    fn header_at(&self, at: usize) -> Option<Header> {
        let bytes: &[u8; HEADER] = self.buffer.get(at..)?.first_chunk()?;
        let (sync, rest) = bytes.split_first_chunk::<4>()?;
        let (number, rest) = rest.split_first_chunk::<8>()?;
        let (utime, rest) = rest.split_first_chunk::<8>()?;
        let (channel, rest) = rest.split_first_chunk::<4>()?;
        let data = rest.first_chunk::<4>()?;
        let channel = usize::try_from(i32::from_be_bytes(*channel)).ok()?;
        let data = usize::try_from(i32::from_be_bytes(*data)).ok()?;
        let possible = u32::from_be_bytes(*sync) == SYNC
            && (1..=MAX_CHANNEL).contains(&channel)
            && data <= MAX_MESSAGE;
        let (number, utime) = (i64::from_be_bytes(*number), i64::from_be_bytes(*utime));
        possible.then_some(Header { number, utime, channel, data })
    }

    /// True if an event, or the end of the log, follows `size` bytes from here.
    fn continues_at(&mut self, size: usize) -> Result<bool, Error> {
        if self.fill(size + HEADER)? {
            return Ok(self.header_at(self.start + size).is_some());
        }
        // A rest too short for a header: the end, or the beginning of a cut event.
        let rest = &self.buffer[self.start + size..];
        let sync = SYNC.to_be_bytes();
        let common = rest.len().min(sync.len());
        Ok(rest[..common] == sync[..common])
    }

    /// If no event follows this one: true if it holds no other event's beginning. Then either what
    /// follows is damaged, or the length is, and the message with it; without a checksum in the
    /// format the two cannot be told apart here, but the message's decoder sees the second.
    fn next_sync_is_behind(&mut self, size: usize) -> Result<bool, Error> {
        if !self.fill(size)? {
            return Ok(false);
        }
        let inside = self.start + 4..self.start + size;
        Ok(inside.into_iter().all(|at| self.header_at(at).is_none()))
    }

    fn event(&self, header: &Header) -> Option<Event> {
        let body = self.start + HEADER;
        let channel = self.buffer.get(body..body + header.channel)?;
        let data = self.buffer.get(body + header.channel..body + header.channel + header.data)?;
        let channel = std::str::from_utf8(channel).ok()?.to_owned();
        let plausible = !channel.chars().any(char::is_control);
        let (number, utime) = (header.number, header.utime);
        plausible.then(|| Event { number, utime, channel, data: data.to_vec() })
    }

    fn skip(&mut self, bytes: usize) {
        if bytes > 0 {
            self.damage.places += u64::from(self.in_sync);
            self.damage.bytes += bytes as u64;
            self.in_sync = false;
            self.start += bytes;
        }
    }

    /// Skips at least `least` bytes, up to the next sync word.
    fn skip_to_sync(&mut self, least: usize) -> Result<(), Error> {
        self.skip(least);
        loop {
            let sync = SYNC.to_be_bytes();
            let held = &self.buffer[self.start..];
            if let Some(at) = held.windows(sync.len()).position(|w| w == sync) {
                self.skip(at);
                return Ok(());
            }
            self.skip(self.held().saturating_sub(sync.len() - 1));
            if !self.any && self.damage.bytes > MOST_BEFORE {
                let most = MOST_BEFORE >> 20;
                let what =
                    format!("no event in the first {most} MiB; expected an event log of LCM");
                return Err(io::Error::new(io::ErrorKind::InvalidData, what).into());
            }
            if !self.fill(sync.len())? {
                self.skip(self.held());
                return Ok(());
            }
        }
    }
}

impl<R: Read> Iterator for EventReader<R> {
    type Item = Result<Event, Error>;

    fn next(&mut self) -> Option<Self::Item> {
        self.next_event().transpose()
    }
}
