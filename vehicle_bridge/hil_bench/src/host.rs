//! Faults of the computer itself: its network interface, its file system.

use std::fs::File;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context as _, Result, anyhow, bail};
use nix::sched::{CloneFlags, unshare};

use super::bench::Scenario;
use super::fault::FaultKind;

/// Multicast on the loopback interface, as commands of a shell.
pub const NETWORK_UP: &str = "ip link set lo up && ip link set lo multicast on && \
    ip route add 224.0.0.0/4 dev lo";
const NETWORK_DOWN: &str = "ip link set lo down";
/// What fills the disk, in pieces of this size. \[B\]
const PIECE: usize = 4096;

/// The computer of one run.
pub(super) struct Host {
    disk: Option<PathBuf>,
    full: bool,
    down: bool,
}

impl Host {
    /// With a file system of its own in `folder`, if the scenario wants one.
    pub(super) fn new(scenario: &Scenario, folder: &Path) -> Result<Self> {
        let mut host = Self { disk: None, full: false, down: false };
        if let Some(mb) = scenario.disk_mb {
            let disk = folder.join("disk");
            std::fs::create_dir_all(&disk)?;
            let mount = Command::new("mount")
                .args(["-t", "tmpfs", "-o", &format!("size={mb}m"), "lmpc-bench"])
                .arg(&disk)
                .status();
            if !mount.context("cannot run `mount` (util-linux)")?.success() {
                bail!("cannot mount a file system of its own at {}", disk.display());
            }
            host.disk = Some(disk);
        }
        Ok(host)
    }

    /// Lets a fault of the computer act, or ends it; other faults are not its business.
    pub(super) fn switch(&mut self, action: &FaultKind, acts: bool) -> Result<()> {
        match action {
            FaultKind::NetworkDown {} if acts != self.down => {
                self.down = acts;
                shell(if acts { NETWORK_DOWN } else { NETWORK_UP })
            }
            FaultKind::FillDisk {} if acts != self.full => {
                self.full = acts;
                let disk = self.disk.as_ref().context("fill_disk needs disk_mb")?;
                let ballast = disk.join("ballast");
                if acts { fill(&ballast) } else { Ok(std::fs::remove_file(ballast)?) }
            }
            _ => Ok(()),
        }
    }
}

impl Drop for Host {
    fn drop(&mut self) {
        if let Some(disk) = &self.disk {
            // What cannot be unmounted goes with the namespace.
            let _ = Command::new("umount").arg("--lazy").arg(disk).status();
        }
    }
}

fn fill(ballast: &Path) -> Result<()> {
    let mut file = File::create(ballast)?;
    // Ends when nothing more fits, down to the last page.
    while file.write_all(&[0; PIECE]).is_ok() {}
    Ok(())
}

/// Runs in a network of its own, whose interface may be taken down without harm to other runs.
pub(super) fn alone<T: Send>(run: impl FnOnce() -> Result<T> + Send) -> Result<T> {
    let separate = || {
        unshare(CloneFlags::CLONE_NEWNET).context("no network of its own for this run")?;
        shell(NETWORK_UP)?;
        run()
    };
    let joined = std::thread::scope(|scope| scope.spawn(separate).join());
    joined.unwrap_or_else(|_| Err(anyhow!("the run panicked")))
}

fn shell(commands: &str) -> Result<()> {
    let status = Command::new("sh").args(["-c", commands]).status()?;
    if status.success() { Ok(()) } else { bail!("`{commands}` failed: {status}") }
}
