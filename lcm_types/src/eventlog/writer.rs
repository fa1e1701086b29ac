//! Writing a log.

use std::io::Write;

use super::{HEADER, MAX_CHANNEL, MAX_MESSAGE, SYNC};
use crate::Error;

/// Appends events to anything that takes bytes; wrap files in a `BufWriter`.
#[derive(Debug)]
pub struct EventWriter<W> {
    out: W,
    next: i64,
    bytes: Vec<u8>,
}

impl<W: Write> EventWriter<W> {
    /// A log on `out`, whose first event is number 0.
    pub fn new(out: W) -> Self {
        Self { out, next: 0, bytes: Vec::new() }
    }

    /// Appends one event, received at `utime` \[us since 1970\].
    ///
    /// # Errors
    /// [`Error::LogSize`] for a channel or message no log holds, [`Error::Io`].
    pub fn write(&mut self, utime: i64, channel: &str, data: &[u8]) -> Result<(), Error> {
        let channel_length = size("channel", channel.len(), 1, MAX_CHANNEL)?;
        let data_length = size("message", data.len(), 0, MAX_MESSAGE)?;
        // In one piece: a buffer in front of a full disk takes all of an event or nothing.
        self.bytes.clear();
        self.bytes.reserve(HEADER + channel.len() + data.len());
        self.bytes.extend(SYNC.to_be_bytes());
        self.bytes.extend(self.next.to_be_bytes());
        self.bytes.extend(utime.to_be_bytes());
        self.bytes.extend(channel_length.to_be_bytes());
        self.bytes.extend(data_length.to_be_bytes());
        self.bytes.extend(channel.as_bytes());
        self.bytes.extend(data);
        self.out.write_all(&self.bytes)?;
        self.next += 1;
        Ok(())
    }

    /// Hands everything on to the operating system.
    ///
    /// # Errors
    /// [`Error::Io`].
    pub fn flush(&mut self) -> Result<(), Error> {
        Ok(self.out.flush()?)
    }

    /// The bytes' destination, as it is.
    pub fn into_inner(self) -> W {
        self.out
    }
}

fn size(what: &'static str, found: usize, least: usize, limit: usize) -> Result<i32, Error> {
    let fits = (least..=limit).contains(&found);
    i32::try_from(found).ok().filter(|_| fits).ok_or(Error::LogSize { what, found, limit })
}
