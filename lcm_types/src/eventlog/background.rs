//! A log written by a thread of its own, so that a slow disk never holds up the sender.

use std::io::Write;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread::{Builder, JoinHandle};

use super::{Event, Writer};
use crate::Error;

/// What became of the events of a log.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Totals {
    /// Events written. [-]
    pub written: u64,
    /// Events dropped because the queue was full or the disk failed. [-]
    pub dropped: u64,
}

/// Queues events for a writing thread; a full queue drops the event and counts it.
#[derive(Debug)]
pub struct BackgroundWriter {
    queue: Option<SyncSender<Event>>,
    thread: Option<JoinHandle<Result<u64, Error>>>,
    dropped: Arc<AtomicU64>,
}

impl BackgroundWriter {
    /// Writes to `out` from a thread of its own, with room for `capacity` waiting events.
    ///
    /// # Errors
    /// [`Error::Io`] if the thread cannot be started.
    pub fn new(out: impl Write + Send + 'static, capacity: usize) -> Result<Self, Error> {
        let (queue, events) = sync_channel(capacity);
        let thread = Builder::new()
            .name("lcm-log".to_owned())
            .spawn(move || write_all(Writer::new(out), &events))?;
        Ok(Self { queue: Some(queue), thread: Some(thread), dropped: Arc::default() })
    }

    /// Queues one event, received at `utime` \[us since 1970\]; never blocks.
    pub fn push(&self, utime: i64, channel: &str, data: &[u8]) {
        let event = Event { number: 0, utime, channel: channel.to_owned(), data: data.to_vec() };
        let taken = self.queue.as_ref().is_some_and(|queue| queue.try_send(event).is_ok());
        if !taken {
            self.dropped.fetch_add(1, Ordering::Relaxed);
        }
    }

    /// Events dropped so far. [-]
    #[must_use]
    pub fn dropped(&self) -> u64 {
        self.dropped.load(Ordering::Relaxed)
    }

    /// Writes what waits, flushes, and ends the thread.
    ///
    /// # Errors
    /// The first error of writing; events after it were dropped and counted.
    pub fn finish(mut self) -> Result<Totals, Error> {
        self.queue = None;
        let written = match self.thread.take().map(JoinHandle::join) {
            Some(Ok(result)) => result?,
            _ => return Err(std::io::Error::other("the writing thread is gone").into()),
        };
        Ok(Totals { written, dropped: self.dropped() })
    }
}

impl Drop for BackgroundWriter {
    fn drop(&mut self) {
        self.queue = None;
        if let Some(thread) = self.thread.take() {
            // The result was not asked for: `finish` is the way to have it.
            let _ = thread.join();
        }
    }
}

fn write_all<W: Write>(mut log: Writer<W>, events: &Receiver<Event>) -> Result<u64, Error> {
    let mut written = 0;
    while let Ok(event) = events.recv() {
        log.write(event.utime, &event.channel, &event.data)?;
        written += 1;
    }
    log.flush()?;
    Ok(written)
}
