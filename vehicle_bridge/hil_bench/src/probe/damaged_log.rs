//! A log cut or with flipped bits: `lmpc replay` gives everything before the damage.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use anyhow::{Context as _, Result, bail};
use lcm_types::eventlog::{EventReader, HEADER};
use lcm_types::{ActuationCommand, Checked as _, channels};
use rand::{RngExt as _, SeedableRng as _};
use rand_pcg::Pcg64;

use super::Measured;
use crate::process::ended;
use transport::record;

/// Periods driven.
const STEPS: &str = "60";
const PATIENCE: Duration = Duration::from_secs(30);
/// Channel to wake the recorder on.
const READY: &str = "BENCH/READY";
/// Exit codes from here on are no answer: a panic, a signal.
const CRASHED: i32 = 101;

/// Records a short drive on the network `url`, damages the log and replays it: no command before the
/// damage may be lost, and nothing may crash.
///
/// # Errors
/// If the drive cannot be recorded or the log not be written.
pub fn run(dir: &Path, seed: u64, url: &str) -> Result<Measured> {
    let log = dir.join("drive.log");
    drive(&log, url)?;
    let whole = fs::read(&log).with_context(|| format!("cannot read {}", log.display()))?;
    let (all, _) = replay(&log)?;
    let mut damaged = whole.clone();
    let first = damage(&mut damaged, seed);
    let before = commands(&whole, first)?;
    let log = dir.join("damaged.log");
    fs::write(&log, &damaged).with_context(|| format!("cannot write {}", log.display()))?;
    let (identical, code) = replay(&log)?;
    Ok(vec![
        ("commands", all),
        ("commands_before_damage", before),
        ("good_commands_lost", before.saturating_sub(identical)),
        ("crashes", u64::from(code >= CRASHED)),
    ])
}

/// A log of a short drive over the network.
fn drive(log: &Path, url: &str) -> Result<()> {
    let network = transport::open(url, None)?;
    let stop = Arc::new(AtomicBool::new(false));
    let (ended, file, recorded) = (Arc::clone(&stop), log.to_owned(), Arc::clone(&network));
    let recorder =
        std::thread::spawn(move || record::record(&recorded, &file, &ended, &mut |_| {}));
    let begun = Instant::now();
    // It records once it hears this.
    while fs::metadata(log).map_or(0, |file| file.len()) == 0 {
        if recorder.is_finished() || begun.elapsed() > PATIENCE {
            bail!("the recorder receives nothing");
        }
        network.publish(READY, &[])?;
        std::thread::sleep(Duration::from_millis(5));
    }
    let mut serve = start(&["serve", "--url", url])?;
    let drive = start(&["vehicle", "sim", "--lock-step", "--steps", STEPS, "--url", url]).and_then(
        |mut car| {
            while car.try_wait()?.is_none() {
                if begun.elapsed() > PATIENCE {
                    car.kill()?;
                    car.wait()?;
                    bail!("the drive did not end in time");
                }
                std::thread::sleep(Duration::from_millis(5));
            }
            Ok(())
        },
    );
    serve.kill()?;
    serve.wait()?;
    stop.store(true, Ordering::Relaxed);
    match recorder.join() {
        Ok(recorded) => recorded.and(drive),
        Err(_) => bail!("the recorder panicked"),
    }
}

/// Starts this program with other arguments, silent.
pub(super) fn start(arguments: &[&str]) -> Result<Child> {
    let mut command = Command::new(std::env::current_exe()?);
    command.args(arguments).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    command.spawn().with_context(|| format!("cannot start lmpc {}", arguments[0]))
}

/// Cuts, or flips up to eight bits; where the first damage is. \[B\]
fn damage(log: &mut Vec<u8>, seed: u64) -> usize {
    let mut random = Pcg64::seed_from_u64(seed);
    if seed.is_multiple_of(2) {
        log.truncate(random.random_range(0..log.len()));
        return log.len();
    }
    let flips = random.random_range(1..=8);
    let places: Vec<usize> = (0..flips).map(|_| random.random_range(0..8 * log.len())).collect();
    places.iter().for_each(|bit| log[bit / 8] ^= 1 << (bit % 8));
    places.into_iter().min().unwrap_or_default() / 8
}

/// Commands to drive, each to a state of its own, in the events that end before `end`. \[-\]
fn commands(log: &[u8], end: usize) -> Result<u64> {
    let (mut at, mut answered) = (0, BTreeSet::new());
    for event in EventReader::new(log) {
        let event = event?;
        at += HEADER + event.channel.len() + event.data.len();
        if at > end {
            break;
        }
        if event.channel == channels::COMMAND
            && let Ok(command) = ActuationCommand::open(&event.data)
            && command.mode == ActuationCommand::MODE_DRIVE
        {
            answered.insert((command.state_boot_id, command.state_seq));
        }
    }
    Ok(answered.len() as u64)
}

/// Commands that come out identical when it is replayed, and the exit code.
pub(super) fn replay(log: &Path) -> Result<(u64, i32)> {
    let output = Command::new(std::env::current_exe()?).arg("replay").arg(log).output()?;
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let identical = text.split_whitespace().next().and_then(|word| word.parse().ok());
    Ok((identical.unwrap_or_default(), ended(output.status)))
}
