//! Everything said on a network, into an event log.

use std::fs::File;
use std::io::BufWriter;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use anyhow::{Context as _, Result};
use lcm_types::eventlog::{BackgroundWriter, Totals};

use crate::transport::{Filter, Message, Transport};

/// Events that may wait for the disk. \[-\]
const WAITING: usize = 65_536;

/// Writes every message to `path` until `stop` is set.
///
/// # Errors
/// If the file cannot be made or written, or the network tells no channels apart.
pub fn record(network: &Arc<dyn Transport>, path: &Path, stop: &AtomicBool) -> Result<Totals> {
    let file = File::create_new(path).with_context(|| format!("cannot make {}", path.display()))?;
    let log = Arc::new(Mutex::new(Some(BackgroundWriter::new(BufWriter::new(file), WAITING)?)));
    let entrance = Arc::clone(&log);
    let sink = move |message: &Message<'_>| {
        let log = entrance.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(log) = &*log {
            log.push(message.arrival.utime, message.channel, message.payload);
        }
    };
    network.subscribe(Filter::All, Box::new(sink))?;
    while !stop.load(Ordering::Relaxed) {
        std::thread::sleep(Duration::from_millis(50));
    }
    let log = log.lock().unwrap_or_else(PoisonError::into_inner).take();
    log.map_or_else(
        || Ok(Totals::default()),
        |log| log.finish().with_context(|| format!("cannot write {}", path.display())),
    )
}
