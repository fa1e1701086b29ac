//! Learned data to disk after every lap, on a thread of its own: the loop never waits for a disk.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::Duration;

use anyhow::{Context as _, Result};
use controller::{Controller, Learned};

use hosting::learned::{self, write};

/// How long after a failure the next attempt.
const RETRY: Duration = Duration::from_secs(1);

/// The writing thread.
pub struct LearnedDataStore {
    path: PathBuf,
    queue: Option<Sender<Learned>>,
    outcomes: Receiver<Option<String>>,
    failures: Arc<AtomicU64>,
    thread: Option<JoinHandle<()>>,
}

impl LearnedDataStore {
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
        let (tell, outcomes) = channel();
        let failures = Arc::<AtomicU64>::default();
        let (file, failed) = (path.to_owned(), Arc::clone(&failures));
        let thread = std::thread::Builder::new()
            .name("lmpc-store".to_owned())
            .spawn(move || save_all(&file, &saves, &tell, &failed))
            .context("cannot start the thread that saves")?;
        Ok(Self {
            path: path.to_owned(),
            queue: Some(queue),
            outcomes,
            failures,
            thread: Some(thread),
        })
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
            let _ = queue.send(controller.learned_data());
        }
    }

    /// How the last save since the question before ended: `Some(None)` is well, else why not.
    #[must_use]
    pub fn outcome(&self) -> Option<Option<String>> {
        self.outcomes.try_iter().last()
    }

    /// Attempts to save that failed so far. \[-\]
    #[must_use]
    pub fn failures(&self) -> u64 {
        self.failures.load(Ordering::Relaxed)
    }
}

impl Drop for LearnedDataStore {
    /// Waits for what is still to be written.
    fn drop(&mut self) {
        self.queue = None;
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

fn save_all(
    path: &Path,
    saves: &Receiver<Learned>,
    tell: &Sender<Option<String>>,
    failures: &AtomicU64,
) {
    let mut unsaved: Option<Learned> = None;
    loop {
        // What could not be saved is tried again: the disk may have room then.
        let patience = if unsaved.is_some() { RETRY } else { Duration::MAX };
        let next = saves.recv_timeout(patience);
        let ended = matches!(next, Err(RecvTimeoutError::Disconnected));
        if let Ok(learned) = next {
            // Of several that wait only the newest counts.
            unsaved = Some(saves.try_iter().last().unwrap_or(learned));
        }
        if let Some(learned) = &unsaved {
            let failure = write(path, learned).err();
            let said =
                failure.as_ref().map(|error| format!("cannot save {}: {error}", path.display()));
            failures.fetch_add(failure.is_some().into(), Ordering::Relaxed);
            let _ = tell.send(said); // nobody listens after the end
            if failure.is_none() {
                unsaved = None;
            }
        }
        if ended {
            break;
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "code of tests")]

    use super::*;

    #[test]
    fn what_could_not_be_saved_is_saved_once_it_can_be() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("learned.lmpc");
        // A folder where the new file is to be written.
        let obstacle = folder.path().join("learned.lmpc.new");
        std::fs::create_dir(&obstacle).unwrap();
        let ((queue, saves), (tell, outcomes)) = (channel(), channel());
        let path = file.clone();
        let failures = Arc::<AtomicU64>::default();
        let failed = Arc::clone(&failures);
        let thread = std::thread::spawn(move || save_all(&path, &saves, &tell, &failed));
        let car = vehicle_model::CarParams::builtin("barc").unwrap();
        let track = Arc::new(vehicle_model::Track::builtin("l").unwrap());
        let controller = Controller::new(controller::Config::default(), car, track).unwrap();
        queue.send(controller.learned_data()).unwrap();
        assert!(outcomes.recv().unwrap().unwrap().contains("cannot save"));
        assert!(failures.load(Ordering::Relaxed) > 0);
        std::fs::remove_dir(&obstacle).unwrap();
        while outcomes.recv().unwrap().is_some() {}
        assert_eq!(std::fs::read(&file).unwrap(), controller.save());
        drop(queue);
        thread.join().unwrap();
    }
}
