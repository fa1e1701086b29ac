//! Learned data to disk after every lap, on a thread of its own: the loop never waits for a disk.

use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::JoinHandle;

use anyhow::{Context as _, Result};
use controller::Controller;

use crate::race::learned;

/// The writing thread.
pub struct Store {
    path: PathBuf,
    queue: Option<Sender<Vec<u8>>>,
    errors: Receiver<String>,
    thread: Option<JoinHandle<()>>,
}

impl Store {
    /// Loads what an earlier start has learned, if there is such a file, and saves there.
    ///
    /// A file that is damaged is not loaded; then the one before it is, with a warning.
    ///
    /// # Errors
    /// If there are data, none of which may be loaded, or the thread cannot be started.
    pub fn open(path: &Path, controller: &mut Controller, warn: impl Fn(&str)) -> Result<Self> {
        if path.exists()
            && let Err(error) = learned::load(path, controller)
        {
            let before = learned::backup(path);
            if !before.exists() {
                return Err(error);
            }
            warn(&format!("{error:#}"));
            learned::load(&before, controller)?;
        }
        let (queue, saves) = channel();
        let (tell, errors) = channel();
        let file = path.to_owned();
        let thread = std::thread::Builder::new()
            .name("lmpc-store".to_owned())
            .spawn(move || save_all(&file, &saves, &tell))
            .context("cannot start the thread that saves")?;
        Ok(Self { path: path.to_owned(), queue: Some(queue), errors, thread: Some(thread) })
    }

    /// The file.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Has what the controller knows now written.
    pub fn save(&self, controller: &Controller) {
        if let Some(queue) = &self.queue {
            // The thread ends only with the queue.
            let _ = queue.send(controller.save());
        }
    }

    /// The next failure to save, in words.
    #[must_use]
    pub fn error(&self) -> Option<String> {
        self.errors.try_recv().ok()
    }
}

impl Drop for Store {
    /// Waits for what is still to be written.
    fn drop(&mut self) {
        self.queue = None;
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

fn save_all(path: &Path, saves: &Receiver<Vec<u8>>, errors: &Sender<String>) {
    while let Ok(bytes) = saves.recv() {
        // Of several that wait only the newest counts.
        let newest = saves.try_iter().last().unwrap_or(bytes);
        if let Err(error) = learned::write(path, &newest) {
            let _ = errors.send(format!("cannot save {}: {error}", path.display()));
        }
    }
}
