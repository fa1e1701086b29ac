//! Who looks after the bridge from outside: the service manager, and a relay in the car.
//!
//! Both get a sign of life from the loop that drives the car, not from a thread beside it: a loop
//! that hangs is seen. systemd (`Type=notify`, `WatchdogSec=`) kills and restarts a bridge whose
//! signs fail to come; a relay that needs an edge every few ticks opens by itself.

use std::fs::{File, OpenOptions};
use std::io::{self, Write as _};
use std::os::unix::fs::{FileExt as _, FileTypeExt as _, OpenOptionsExt as _};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use anyhow::{Context as _, Result};
use sd_notify::NotifyState;

/// Notifications to the service manager and to a relay.
#[derive(Debug)]
pub struct Watchdog {
    /// Time between two signs to the service manager; `None` where it wants none.
    every: Option<Duration>,
    next: Instant,
    relay: Option<Relay>,
    /// What the relay's device last refused.
    trouble: Option<String>,
}

/// A device or file that gets 1 and 0 in turn.
#[derive(Debug)]
struct Relay {
    path: PathBuf,
    file: File,
    stream: bool,
    high: bool,
}

impl Relay {
    fn open(path: &Path) -> Result<Self> {
        let flags = nix::libc::O_NONBLOCK | nix::libc::O_NOCTTY;
        let file = OpenOptions::new().write(true).custom_flags(flags).open(path);
        let file = file.with_context(|| {
            format!(
                "cannot write to the relay {}: expected a serial port, or a GPIO's `value` file that \
                 is exported as an output",
                path.display()
            )
        })?;
        let kind = file.metadata()?.file_type();
        let stream = kind.is_char_device() || kind.is_fifo();
        Ok(Self { path: path.to_owned(), file, stream, high: false })
    }

    fn toggle(&mut self) -> io::Result<()> {
        self.high = !self.high;
        let level: &[u8] = if self.high { b"1" } else { b"0" };
        if self.stream { self.file.write_all(level) } else { self.file.write_all_at(level, 0) }
    }
}

impl Watchdog {
    /// For the service manager that started this program, if it wants signs, and for a relay.
    ///
    /// # Errors
    /// If the relay cannot be written to.
    pub fn new(relay: Option<&Path>) -> Result<Self> {
        // Twice as often as needed, as sd_watchdog_enabled(3) recommends.
        let every = sd_notify::watchdog_enabled().map(|timeout| timeout / 2);
        let relay = relay.map(Relay::open).transpose()?;
        Ok(Self { every, next: Instant::now(), relay, trouble: None })
    }

    /// The program is ready.
    pub fn ready(&self) {
        tell(&[NotifyState::Ready]);
    }

    /// What the program does, for `systemctl status`.
    pub fn status(&self, words: &str) {
        tell(&[NotifyState::Status(words)]);
    }

    /// The program begins to end: a car that drives is stopped first.
    pub fn ending(&self) {
        tell(&[NotifyState::Stopping]);
    }

    /// The loop runs; called at every tick. Never waits.
    pub fn beat(&mut self) {
        let now = Instant::now();
        if let Some(every) = self.every
            && now >= self.next
        {
            self.next = now + every;
            tell(&[NotifyState::Watchdog]);
        }
        if let Some(relay) = &mut self.relay {
            let told = relay.toggle();
            self.trouble = told.err().map(|e| format!("relay {}: {e}", relay.path.display()));
        }
    }

    /// Why the relay got no sign, in words.
    #[must_use]
    pub fn trouble(&self) -> Option<&str> {
        self.trouble.as_deref()
    }
}

/// Without a service manager nobody is there to be told.
fn tell(state: &[NotifyState<'_>]) {
    let _ = sd_notify::notify(state);
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "code of tests")]
    use super::*;

    #[test]
    fn a_relay_gets_an_edge_at_every_tick_and_a_missing_one_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("value");
        assert!(Watchdog::new(Some(&path)).unwrap_err().to_string().contains("relay"));
        std::fs::write(&path, "0\n").unwrap();
        let mut watchdog = Watchdog::new(Some(&path)).unwrap();
        let levels: Vec<String> = (0..4)
            .map(|_| {
                watchdog.beat();
                std::fs::read_to_string(&path).unwrap().trim().to_owned()
            })
            .collect();
        assert_eq!(levels, ["1", "0", "1", "0"]);
        assert_eq!(watchdog.trouble(), None);
    }
}
