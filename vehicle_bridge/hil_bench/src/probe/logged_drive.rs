//! The log that `lmpc serve` writes itself: each state before the commands that answer it, and a replay
//! that finds the same commands.

use std::collections::BTreeSet;
use std::fs::File;
use std::path::Path;
use std::time::Duration;

use anyhow::{Context as _, Result};
use lcm_types::eventlog::EventReader;
use lcm_types::{ActuationCommand, BootId, Checked as _, SeqNumber, VehicleState, channels};
use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;

use super::Measured;
use super::damaged_log::{replay, start};

/// Length of the drive, in real time.
const DRIVE: Duration = Duration::from_secs(5);

/// Drives a simulated car in real time on the network `url` with `serve --log`, and replays the log.
///
/// # Errors
/// If a program cannot be started or the log not be read.
pub fn run(dir: &Path, url: &str) -> Result<Measured> {
    let log = dir.join("serve.log");
    let mut serve = start(&["serve", "--log", &log.display().to_string(), "--url", url])?;
    let drive = start(&["vehicle", "sim", "--url", url]).and_then(|mut car| {
        std::thread::sleep(DRIVE);
        car.kill()?;
        car.wait().context("the car did not end")
    });
    kill(Pid::from_raw(serve.id().cast_signed()), Signal::SIGINT)?;
    serve.wait()?;
    drive?;
    let file = File::open(&log).with_context(|| format!("cannot read {}", log.display()))?;
    let (mut states, mut early) = (BTreeSet::new(), 0);
    for event in EventReader::new(file) {
        let event = event?;
        if event.channel == channels::STATE
            && let Ok(state) = VehicleState::open(&event.data)
        {
            states.insert((state.h.sender_start(), state.h.number()));
        } else if event.channel == channels::COMMAND
            && let Ok(command) = ActuationCommand::open(&event.data)
            && command.mode == ActuationCommand::MODE_DRIVE
        {
            let answered = (BootId::new(command.state_boot_id), SeqNumber::new(command.state_seq));
            early += u64::from(!states.contains(&answered));
        }
    }
    let (identical, code) = replay(&log)?;
    Ok(vec![
        ("commands_before_their_state", early),
        ("identical", identical),
        ("replay_exit_code", code.unsigned_abs().into()),
    ])
}
