//! `kill -9` at any moment while learned data are being saved: whole files are left.
//!
//! This tests the order of write, sync and rename, not a power cut.

use std::fs;
use std::io::{BufRead as _, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::Arc;
use std::time::{Duration, SystemTime};

use anyhow::{Context as _, Result, bail};
use controller::{Config, Controller, Measurement, Pose, Preset};
use rand::{RngExt as _, SeedableRng as _};
use rand_pcg::Pcg64;
use vehicle_model::{Plant, PlantParams, State};

use super::Measured;
use hosting::{learned, load};

const FILE: &str = "learned.lmpc";
/// What the saver knows: one lap, and two.
const KNOWN: [&str; 2] = ["one", "two"];
/// A kill comes this long after the saver began, or earlier. \[us\]
const LATEST_US: u64 = 8_000;
/// Steps of two laps at the speed of the first ones are far fewer. \[-\]
const MOST_STEPS: u32 = 10_000;

/// Kills a saver `kills` times, each at a moment drawn from `seed`, and counts the damaged files.
///
/// # Errors
/// If the saver cannot be started or the folder not be written.
pub fn kills(dir: &Path, seed: u64, kills: u32) -> Result<Measured> {
    let two = two()?;
    for (name, controller) in KNOWN.iter().zip(&two) {
        learned::save(&dir.join(name), controller)?;
    }
    learned::save(&dir.join(FILE), &two[0])?;
    let whole = two.map(|controller| controller.save());
    let unfinished = dir.join(format!("{FILE}.new"));
    let mut random = Pcg64::seed_from_u64(seed);
    let (mut corrupt, mut missing, mut mid_write) = (0, 0, 0);
    for _ in 0..kills {
        let before = written(&unfinished);
        let mut saver = start(dir)?;
        std::thread::sleep(Duration::from_micros(random.random_range(0..LATEST_US)));
        saver.kill()?;
        saver.wait()?;
        mid_write += u64::from(written(&unfinished).is_some_and(|at| before != Some(at)));
        missing += u64::from(!dir.join(FILE).exists());
        for name in [FILE.to_owned(), format!("{FILE}.bak")] {
            let damaged = |bytes: Vec<u8>| !whole.contains(&bytes);
            corrupt += u64::from(fs::read(dir.join(name)).is_ok_and(damaged));
        }
    }
    Ok(vec![
        ("kills", kills.into()),
        ("mid_write", mid_write),
        ("corrupt_files", corrupt),
        ("missing_files", missing),
    ])
}

/// Saves two sets of learned data in turn until the process is killed; calls `ready` before the
/// first save.
///
/// # Errors
/// If a file cannot be read or written.
pub fn save(dir: &Path, ready: impl FnOnce() -> Result<()>) -> Result<Measured> {
    let mut known = Vec::new();
    for name in KNOWN {
        let mut controller = controller()?;
        learned::load(&dir.join(name), &mut controller)?;
        known.push(controller);
    }
    ready()?;
    loop {
        for controller in &known {
            learned::save(&dir.join(FILE), controller)?;
        }
    }
}

fn start(dir: &Path) -> Result<Child> {
    let mut command = Command::new(std::env::current_exe()?);
    command.args(["hil", "probe", "saver", "--dir"]).arg(dir);
    let mut child = command.stdout(Stdio::piped()).spawn().context("cannot start the saver")?;
    let out = child.stdout.take().context("the saver has no output")?;
    let mut line = String::new();
    BufReader::new(out).read_line(&mut line)?;
    if line.trim() != "ready" {
        bail!("the saver says {line:?}, expected \"ready\"");
    }
    Ok(child)
}

/// When a file was last written. One from an earlier kill stays until the next save.
fn written(path: &Path) -> Option<SystemTime> {
    fs::metadata(path).and_then(|found| found.modified()).ok()
}

fn controller() -> Result<Controller> {
    let (nominal, track) = (load::car("barc")?.with_mu(1.2), load::track("l")?);
    let mut config = Config::derived(Preset::Race, &nominal, &track);
    config.warm_up.laps = 1;
    Ok(Controller::new(config, nominal, track)?)
}

/// Controllers that know one and two laps.
fn two() -> Result<[Controller; 2]> {
    let (mut driver, mut found) = (controller()?, Vec::new());
    let start = State { v_x: driver.config().warm_up.speed, ..State::default() };
    let params = PlantParams::new(load::car("barc")?);
    let mut plant = Plant::new(params, Arc::clone(driver.track()), start)?;
    let period = driver.config().horizon.period;
    for n in 0..MOST_STEPS {
        let time = f64::from(n) * period;
        let measurement = Measurement { time, pose: Pose::Frenet(plant.measure()), applied: None };
        let command = driver.step(&measurement);
        driver.prepare();
        plant.apply(command.input, period);
        if command.status.finished.is_some() {
            let mut copy = controller()?;
            copy.load(&driver.save())?;
            found.push(copy);
        }
        if found.len() == 2 {
            break;
        }
    }
    found.try_into().ok().context("the car did not close two laps")
}
