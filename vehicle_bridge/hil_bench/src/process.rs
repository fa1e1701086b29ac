//! Programs under test: started, stopped, killed by their own ids.

use std::fs::File;
use std::os::unix::process::ExitStatusExt as _;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use anyhow::{Context as _, Result, bail};
use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;

use super::fault::EndSignal;
use hosting::memory::resident_mb;

/// How long a program has to end after SIGINT before it is killed.
const GRACE: Duration = Duration::from_millis(300);

/// One program; ends with this value.
pub(super) struct Program {
    pub(super) name: String,
    command: Vec<String>,
    log: PathBuf,
    child: Child,
    /// Ended or stopped by the bench: its end is no crash.
    ended: bool,
    stopped: bool,
}

impl Program {
    /// Starts `command`; its output goes to `NAME.txt` in `folder`.
    pub(super) fn start(name: &str, command: &[String], folder: &Path) -> Result<Self> {
        let log = folder.join(format!("{name}.txt"));
        let child = spawn(command, &log)?;
        let (name, command) = (name.to_owned(), command.to_vec());
        Ok(Self { name, command, log, child, ended: false, stopped: false })
    }

    fn signal(&self, signal: Signal) {
        // It may have ended in between.
        let _ = kill(Pid::from_raw(self.child.id().cast_signed()), signal);
    }

    pub(super) fn kill(&mut self) {
        self.ended = true;
        self.signal(Signal::SIGKILL);
        // Killed: it cannot fail to end.
        let _ = self.child.wait();
    }

    /// Asks it to end: its end is no crash.
    pub(super) fn interrupt(&mut self, signal: EndSignal) {
        self.ended = true;
        self.signal(signal_of(signal));
    }

    pub(super) fn stop(&mut self) {
        if !self.stopped {
            self.stopped = true;
            self.signal(Signal::SIGSTOP);
        }
    }

    pub(super) fn go_on(&mut self) {
        if self.stopped {
            self.stopped = false;
            self.signal(Signal::SIGCONT);
        }
    }

    pub(super) fn restart(&mut self) -> Result<()> {
        self.kill();
        self.child = spawn(&self.command, &self.log)?;
        self.ended = false;
        Ok(())
    }

    /// Resident memory; 0 once it has ended. \[MB\]
    pub(super) fn resident_mb(&self) -> f64 {
        f64::from(resident_mb(&self.child.id().to_string()))
    }

    /// Whether it ended by itself.
    pub(super) fn crashed(&mut self) -> bool {
        !self.ended && !matches!(self.child.try_wait(), Ok(None))
    }

    /// The last lines of its output.
    pub(super) fn last_words(&self) -> String {
        let text = std::fs::read_to_string(&self.log).unwrap_or_default();
        text.lines().last().unwrap_or_default().to_owned()
    }
}

impl Drop for Program {
    fn drop(&mut self) {
        self.go_on();
        if self.ended && !matches!(self.child.try_wait(), Ok(None)) {
            return;
        }
        self.signal(Signal::SIGINT);
        let end = Instant::now() + GRACE;
        while Instant::now() < end {
            if !matches!(self.child.try_wait(), Ok(None)) {
                return;
            }
            std::thread::sleep(Duration::from_millis(5));
        }
        self.kill();
    }
}

/// The system's signal of this name.
pub(super) fn signal_of(signal: EndSignal) -> Signal {
    match signal {
        EndSignal::Int => Signal::SIGINT,
        EndSignal::Term => Signal::SIGTERM,
        EndSignal::Hup => Signal::SIGHUP,
        EndSignal::Quit => Signal::SIGQUIT,
    }
}

/// The exit code; of a program a signal ended, 128 and the signal's number, as in a shell.
pub(super) fn ended(status: ExitStatus) -> i32 {
    status.code().unwrap_or_else(|| 128 + status.signal().unwrap_or_default())
}

fn spawn(command: &[String], log: &Path) -> Result<Child> {
    let [program, arguments @ ..] = command else { bail!("a process has an empty command") };
    let folder = log.parent().unwrap_or(Path::new("."));
    let log = File::create(log).with_context(|| format!("cannot write {}", log.display()))?;
    Command::new(program)
        .args(arguments)
        // A black box in a run's own folder.
        .env("XDG_STATE_HOME", folder)
        .env_remove("STATE_DIRECTORY")
        .env_remove("NOTIFY_SOCKET")
        .stdin(Stdio::null())
        .stdout(log.try_clone()?)
        .stderr(log)
        .spawn()
        .with_context(|| format!("cannot start `{program}`"))
}
