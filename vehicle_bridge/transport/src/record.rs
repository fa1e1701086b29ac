//! Event logs: of all messages on a network, or of what one program sends and receives.

use std::fs::{File, OpenOptions};
use std::io::{BufWriter, Write};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use anyhow::{Context as _, Result};
use lcm_types::eventlog::{BackgroundWriter, Totals};

use crate as transport;
use crate::{Error, Filter, ReceivedMessage, Sink, Statistics, Transport};

/// Events that may wait for the disk. \[-\]
const WAITING: usize = 65_536;
/// In front of the disk: more than the largest message of ours. \[B\]
const BUFFER: usize = 1 << 16;

/// Writes every message to `path` until `stop` is set. `say` is called when the disk starts and stops
/// refusing messages.
///
/// # Errors
/// If the file cannot be made, or the network does not distinguish channels.
pub fn record(
    network: &Arc<dyn Transport>,
    path: &Path,
    stop: &AtomicBool,
    say: &mut dyn FnMut(&str),
) -> Result<Totals> {
    let file = File::create_new(path).with_context(|| format!("cannot make {}", path.display()))?;
    let log = Arc::new(Mutex::new(Some(writer(file)?)));
    let entrance = Arc::clone(&log);
    let sink = move |message: &ReceivedMessage<'_>| {
        if let Some(log) = &*lock(&entrance) {
            log.push(message.arrival.utime, message.channel, message.payload);
        }
    };
    network.subscribe(Filter::All, Box::new(sink))?;
    let mut known = None;
    while !stop.load(Ordering::Relaxed) {
        let (trouble, dropped) =
            lock(&log).as_ref().map(|log| (log.trouble(), log.dropped())).unwrap_or_default();
        if trouble != known {
            say(&match &trouble {
                Some(trouble) => format!("{}: {trouble}; messages are dropped", path.display()),
                None => format!("writing again; {dropped} messages were dropped"),
            });
            known = trouble;
        }
        std::thread::sleep(Duration::from_millis(50));
    }
    let log = lock(&log).take();
    log.map_or_else(
        || Ok(Totals::default()),
        |log| log.finish().with_context(|| format!("cannot write {}", path.display())),
    )
}

/// The log of one program, behind its network.
#[derive(Debug, Clone)]
pub struct NetworkLog(Arc<BackgroundWriter>);

impl NetworkLog {
    /// Whether the disk refuses messages now.
    #[must_use]
    pub fn is_troubled(&self) -> bool {
        self.0.trouble().is_some()
    }

    /// Messages that could not be written so far. \[-\]
    #[must_use]
    pub fn dropped(&self) -> u64 {
        self.0.dropped()
    }

    /// Text for the heartbeat; `None` while everything is written.
    #[must_use]
    pub fn complaint(&self) -> Option<String> {
        let (dropped, trouble) = (self.dropped(), self.0.trouble());
        match trouble {
            Some(trouble) => Some(format!("log: {dropped} messages dropped, {trouble}")),
            None => (dropped > 0).then(|| format!("log: {dropped} messages dropped")),
        }
    }
}

/// The same network; what is published and what is subscribed to also goes to the end of the log
/// `path`, even if the network refuses it. A disk that takes nothing never makes it wait.
///
/// # Errors
/// If the file cannot be opened.
pub fn logged(
    network: Arc<dyn Transport>,
    path: &Path,
) -> Result<(Arc<dyn Transport>, NetworkLog)> {
    let file = OpenOptions::new().create(true).append(true).open(path);
    let file = file.with_context(|| format!("cannot write the log {}", path.display()))?;
    recorded(network, file)
}

/// [`logged`], into anything that can be written.
///
/// # Errors
/// If the writing thread cannot be started.
pub fn recorded(
    network: Arc<dyn Transport>,
    out: impl Write + Send + 'static,
) -> Result<(Arc<dyn Transport>, NetworkLog)> {
    let log = Arc::new(writer(out)?);
    Ok((Arc::new(Logged { network, log: Arc::clone(&log) }), NetworkLog(log)))
}

fn lock(log: &Mutex<Option<BackgroundWriter>>) -> MutexGuard<'_, Option<BackgroundWriter>> {
    log.lock().unwrap_or_else(PoisonError::into_inner)
}

fn writer(out: impl Write + Send + 'static) -> Result<BackgroundWriter> {
    Ok(BackgroundWriter::new(BufWriter::with_capacity(BUFFER, out), WAITING)?)
}

struct Logged {
    network: Arc<dyn Transport>,
    log: Arc<BackgroundWriter>,
}

impl Transport for Logged {
    fn publish(&self, channel: &str, payload: &[u8]) -> Result<(), Error> {
        // First: the answer may come before this thread goes on.
        self.log.push(transport::now().utime, channel, payload);
        self.network.publish(channel, payload)
    }

    fn subscribe(&self, filter: Filter, mut sink: Box<dyn Sink>) -> Result<(), Error> {
        let log = Arc::clone(&self.log);
        let both = move |message: &ReceivedMessage<'_>| {
            // First: whoever waits for the message may answer before this thread goes on.
            log.push(message.arrival.utime, message.channel, message.payload);
            sink.deliver(message);
        };
        self.network.subscribe(filter, Box::new(both))
    }

    fn statistics(&self) -> Statistics {
        self.network.statistics()
    }

    fn warnings(&self) -> &[String] {
        self.network.warnings()
    }
}
