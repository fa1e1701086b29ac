//! A log written by a thread of its own, so that a slow or full disk never holds up the sender.

use std::io::Write;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, TryRecvError, sync_channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::{Builder, JoinHandle};

use super::{Event, EventWriter};
use crate::Error;

/// What became of the events of a log.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Totals {
    /// Events written. [-]
    pub written: u64,
    /// Events dropped because the queue was full or the disk failed. [-]
    pub dropped: u64,
}

/// Queues events for a writing thread; a full queue drops the event and counts it, and so does a
/// disk that takes nothing. Once it does again, writing goes on.
#[derive(Debug)]
pub struct BackgroundWriter {
    queue: Option<SyncSender<Event>>,
    thread: Option<JoinHandle<u64>>,
    losses: Arc<Losses>,
}

/// What the two threads know of losses.
#[derive(Debug, Default)]
struct Losses {
    dropped: AtomicU64,
    trouble: Mutex<Option<String>>,
}

impl Losses {
    fn trouble(&self) -> MutexGuard<'_, Option<String>> {
        self.trouble.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn add(&self, events: u64) {
        self.dropped.fetch_add(events, Ordering::Relaxed);
    }
}

impl BackgroundWriter {
    /// Writes to `out` from a thread of its own, with room for `capacity` waiting events. `out` is
    /// flushed whenever none waits.
    ///
    /// # Errors
    /// [`Error::Io`] if the thread cannot be started.
    pub fn new(out: impl Write + Send + 'static, capacity: usize) -> Result<Self, Error> {
        let (queue, events) = sync_channel(capacity);
        let losses = Arc::<Losses>::default();
        let told = Arc::clone(&losses);
        let thread = Builder::new()
            .name("lcm-log".to_owned())
            .spawn(move || write_all(EventWriter::new(out), &events, &told))?;
        Ok(Self { queue: Some(queue), thread: Some(thread), losses })
    }

    /// Queues one event, received at `utime` \[us since 1970\]; never blocks.
    pub fn push(&self, utime: i64, channel: &str, data: &[u8]) {
        let event = Event { number: 0, utime, channel: channel.to_owned(), data: data.to_vec() };
        let taken = self.queue.as_ref().is_some_and(|queue| queue.try_send(event).is_ok());
        self.losses.add(u64::from(!taken));
    }

    /// Events dropped so far. [-]
    #[must_use]
    pub fn dropped(&self) -> u64 {
        self.losses.dropped.load(Ordering::Relaxed)
    }

    /// Why nothing can be written now, in words; `None` as long as the disk takes it.
    #[must_use]
    pub fn trouble(&self) -> Option<String> {
        self.losses.trouble().clone()
    }

    /// Writes what waits, flushes, and ends the thread.
    ///
    /// # Errors
    /// [`Error::Io`] if the writing thread is gone.
    pub fn finish(mut self) -> Result<Totals, Error> {
        self.queue = None;
        let written = match self.thread.take().map(JoinHandle::join) {
            Some(Ok(written)) => written,
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

/// Events written.
fn write_all<W: Write>(mut log: EventWriter<W>, events: &Receiver<Event>, losses: &Losses) -> u64 {
    let (mut written, mut held) = (0, 0);
    let mut next = events.recv().ok();
    while let Some(event) = next {
        match log.write(event.utime, &event.channel, &event.data) {
            Ok(()) => held += 1,
            Err(error) => {
                losses.add(1);
                *losses.trouble() = Some(error.to_string());
            }
        }
        next = match events.try_recv() {
            Ok(event) => Some(event),
            Err(TryRecvError::Disconnected) => None,
            Err(TryRecvError::Empty) => {
                flush(&mut log, (&mut written, &mut held), losses);
                events.recv().ok()
            }
        };
    }
    flush(&mut log, (&mut written, &mut held), losses);
    losses.add(held);
    written
}

/// What was `held` in front of the disk is written, or stays held.
fn flush<W: Write>(
    log: &mut EventWriter<W>,
    (written, held): (&mut u64, &mut u64),
    losses: &Losses,
) {
    *losses.trouble() = match log.flush() {
        Ok(()) => {
            *written += std::mem::take(held);
            None
        }
        Err(error) => Some(error.to_string()),
    };
}
