//! A drive that is shown, shared by who receives its messages and by the pages.

use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use crate::frame::{self, Cursor, Events};
use crate::model::ViewModel;
use crate::reference::Resolve;

/// The time of what is shown: this computer's for a network, that of the log for a log. \[ns\]
pub type Clock = Box<dyn Fn() -> i64 + Send + Sync>;

/// A drive and what is known of it.
pub struct View {
    source: String,
    clock: Clock,
    model: Mutex<ViewModel>,
    changed: Condvar,
}

impl View {
    /// Nothing received yet of `source`, which is named on the page.
    #[must_use]
    pub fn new(source: String, clock: Clock, resolve: Resolve) -> Self {
        let model = Mutex::new(ViewModel::new(resolve));
        Self { source, clock, model, changed: Condvar::new() }
    }

    /// What is shown.
    #[must_use]
    pub fn source(&self) -> &str {
        &self.source
    }

    /// Takes a message that arrived at `arrival_ns` on the clock of what is shown.
    pub fn take(&self, channel: &str, payload: &[u8], arrival_ns: i64) {
        self.lock().take(channel, payload, arrival_ns);
        self.changed.notify_all();
    }

    /// Nothing more will come, for this reason.
    pub fn end(&self, why: &str) {
        let mut model = self.lock();
        model.ended = Some(why.to_owned());
        model.version += 1;
        drop(model);
        self.changed.notify_all();
    }

    /// Waits until a message comes after the version `known`, at most for `patience`; the version
    /// then.
    pub(crate) fn wait(&self, known: u64, patience: Duration) -> u64 {
        let model = self.lock();
        let idle = |model: &mut ViewModel| model.version == known;
        let waited = self.changed.wait_timeout_while(model, patience, idle);
        waited.unwrap_or_else(PoisonError::into_inner).0.version
    }

    /// What a page lacks.
    pub(crate) fn events(&self, cursor: &mut Cursor, status: bool) -> Events {
        let model = self.lock();
        frame::events(&model, cursor, (self.clock)(), status)
    }

    fn lock(&self) -> MutexGuard<'_, ViewModel> {
        self.model.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
