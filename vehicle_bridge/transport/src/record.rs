//! Event logs: of everything said on a network, or of what one program says and hears.

use std::fs::{File, OpenOptions};
use std::io::BufWriter;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use anyhow::{Context as _, Result};
use lcm_types::eventlog::{BackgroundWriter, Totals};

use crate as transport;
use crate::{Error, Filter, Message, Sink, Statistics, Transport};

/// Events that may wait for the disk. \[-\]
const WAITING: usize = 65_536;
/// In front of the disk: more than the largest message of ours. \[B\]
const BUFFER: usize = 1 << 16;

/// Writes every message to `path` until `stop` is set. `say` hears when the disk begins and ceases
/// to refuse messages.
///
/// # Errors
/// If the file cannot be made, or the network tells no channels apart.
pub fn record(
    network: &Arc<dyn Transport>,
    path: &Path,
    stop: &AtomicBool,
    say: &mut dyn FnMut(&str),
) -> Result<Totals> {
    let file = File::create_new(path).with_context(|| format!("cannot make {}", path.display()))?;
    let log = Arc::new(Mutex::new(Some(writer(file)?)));
    let entrance = Arc::clone(&log);
    let sink = move |message: &Message<'_>| {
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
pub struct Log(Arc<BackgroundWriter>);

impl Log {
    /// What a life sign says of it: nothing as long as all is written.
    #[must_use]
    pub fn complaint(&self) -> Option<String> {
        let (dropped, trouble) = (self.0.dropped(), self.0.trouble());
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
pub fn logged(network: Arc<dyn Transport>, path: &Path) -> Result<(Arc<dyn Transport>, Log)> {
    let file = OpenOptions::new().create(true).append(true).open(path);
    let file = file.with_context(|| format!("cannot write the log {}", path.display()))?;
    let log = Arc::new(writer(file)?);
    Ok((Arc::new(Logged { network, log: Arc::clone(&log) }), Log(log)))
}

fn lock(log: &Mutex<Option<BackgroundWriter>>) -> MutexGuard<'_, Option<BackgroundWriter>> {
    log.lock().unwrap_or_else(PoisonError::into_inner)
}

fn writer(file: File) -> Result<BackgroundWriter> {
    Ok(BackgroundWriter::new(BufWriter::with_capacity(BUFFER, file), WAITING)?)
}

struct Logged {
    network: Arc<dyn Transport>,
    log: Arc<BackgroundWriter>,
}

impl Transport for Logged {
    fn publish(&self, channel: &str, payload: &[u8]) -> Result<(), Error> {
        let sent = self.network.publish(channel, payload);
        self.log.push(transport::now().utime, channel, payload);
        sent
    }

    fn subscribe(&self, filter: Filter, mut sink: Box<dyn Sink>) -> Result<(), Error> {
        let log = Arc::clone(&self.log);
        let both = move |message: &Message<'_>| {
            sink.deliver(message);
            log.push(message.arrival.utime, message.channel, message.payload);
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
