//! Requests to end: signals of a terminal, a service manager or a lost connection.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::Result;
use signal_hook::consts::{SIGHUP, SIGINT, SIGQUIT, SIGTERM};
use signal_hook::iterator::Signals;

/// Signals that ask a program to end; SIGHUP comes with a terminal that is closed or lost.
pub const SIGNALS: [i32; 4] = [SIGINT, SIGTERM, SIGHUP, SIGQUIT];

/// Requests to end so far.
#[derive(Debug, Clone, Default)]
pub struct Shutdown {
    requested: Arc<AtomicBool>,
    again: Arc<AtomicBool>,
}

impl Shutdown {
    /// Begins to listen to the signals, none of which ends the process by itself any more.
    ///
    /// # Errors
    /// If a signal or the listening thread is not to be had.
    pub fn on_signals() -> Result<Self> {
        let shutdown = Self::default();
        let seen = shutdown.clone();
        let mut signals = Signals::new(SIGNALS)?;
        std::thread::Builder::new().name("lmpc-signals".to_owned()).spawn(move || {
            for _ in signals.forever() {
                seen.request();
            }
        })?;
        Ok(shutdown)
    }

    /// Asks to end; the second time, to end at once.
    pub fn request(&self) {
        if self.requested.swap(true, Ordering::SeqCst) {
            self.again.store(true, Ordering::SeqCst);
        }
    }

    /// Whether the program is asked to end.
    #[must_use]
    pub fn is_requested(&self) -> bool {
        self.requested.load(Ordering::SeqCst)
    }

    /// Whether it is asked to end at once.
    #[must_use]
    pub fn is_urgent(&self) -> bool {
        self.again.load(Ordering::SeqCst)
    }

    /// The first request, for loops that know no other.
    #[must_use]
    pub fn flag(&self) -> &AtomicBool {
        &self.requested
    }
}
