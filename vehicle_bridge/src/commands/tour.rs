//! `lmpc tour`: the first minute with the program.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use anyhow::{Context as _, Result, bail};
use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;

use super::{Outcome, folders};
use command_line::{NetworkArgs, TourArgs};
use hil_bench::host::NETWORK_UP;
use lcm_types::channels;
use terminal::{BEST, GOOD, SOFT, Talk, WARN, paint, result};
use transport::{DEFAULT_URL, Filter, Inbox};

/// A group of its own, for a computer on which another car may be driving; ttl 0 keeps it there.
const OWN_GROUP: &str = "udpm://239.255.76.99:7699?ttl=0";
/// Drives both FMUs in FMPy.
const RACE_FMPY: &str = include_str!("../../../examples/fmu/race_fmpy.py");
/// How long the controller may take to begin.
const PATIENCE: Duration = Duration::from_secs(30);
/// Both programs on the network have these settings.
const WARM_UP: [&str; 2] = ["--set", "warm_up.laps=2"];

/// Runs every part; a part whose tools are missing is passed over.
pub(super) fn run(args: &TourArgs, talk: Talk) -> Result<Outcome> {
    let tour = Tour { args, talk, program: std::env::current_exe().context("where is lmpc?")? };
    if args.network_part {
        tour.network()?;
        return Ok(Outcome::Done);
    }
    folders::results(&args.out)?;
    tour.heading(1, "A race: four laps at low speed, then ten that are faster and faster")?;
    let race = tour.file("race");
    tour.lmpc(&["race", "--laps", "10", "--out", &race])?;
    tour.heading(2, "Its report: laps, line, speeds and learning in one page without a network")?;
    let report = format!("{race}/report.html");
    if !Path::new(&report).is_file() {
        bail!("the race wrote no {report}");
    }
    result(&format!("Open {report} in a browser, and laps.csv beside it in a spreadsheet."))?;
    tour.heading(3, "Controller and car as FMUs in a co-simulation tool")?;
    tour.fmus()?;
    tour.heading(4, "Controller and car as two programs on an LCM network")?;
    tour.isolated_network()?;
    tour.end()?;
    Ok(Outcome::Done)
}

struct Tour<'a> {
    args: &'a TourArgs,
    talk: Talk,
    program: PathBuf,
}

impl Tour<'_> {
    fn file(&self, name: &str) -> String {
        self.args.out.join(name).display().to_string()
    }

    fn heading(&self, number: usize, text: &str) -> Result<()> {
        Ok(result(&format!("\n{}", paint(BEST, &format!("{number}. {text}"))))?)
    }

    fn missing(&self, what: &str, fix: &str) -> Result<()> {
        Ok(result(&format!("{} {fix}", paint(WARN, &format!("Passed over: {what}."))))?)
    }

    /// Runs a command of this program.
    fn lmpc(&self, arguments: &[&str]) -> Result<()> {
        show("lmpc", arguments, "")?;
        finish(self.command(arguments), "lmpc", arguments)
    }

    fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(&self.program);
        command.args(arguments);
        if self.talk.quiet {
            command.arg("--quiet");
        }
        command
    }

    /// Both FMUs in FMPy, if they and it are there.
    fn fmus(&self) -> Result<()> {
        let Some(folder) = self.fmu_folder() else {
            return self
                .missing("no FMUs in out/fmu", "`make fmu` of the source tree builds them.");
        };
        let vehicle = format!("fmu:{}", folder.join("fmi3/lmpc-vehicle.fmu").display());
        let out = self.file("race-fmu");
        self.lmpc(&["race", "--vehicle", &vehicle, "--laps", "3", "--out", &out])?;
        let python = self.args.python.display().to_string();
        let probe = Command::new(&self.args.python)
            .args(["-c", "import fmpy"])
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .status();
        if !probe.is_ok_and(|status| status.success()) {
            let what = format!("{python} has no FMPy");
            return self.missing(&what, "`pip install fmpy`, or --python VENV/bin/python.");
        }
        let script = self.file("race_fmpy.py");
        fs::write(&script, RACE_FMPY).with_context(|| format!("cannot write {script}"))?;
        let (folder, table) = (folder.display().to_string(), self.file("fmpy.csv"));
        let arguments = [&script, "--fmus", &folder, "--laps", "6", "--csv", &table];
        show(&python, &arguments, "")?;
        let mut command = Command::new(&self.args.python);
        command.args(arguments);
        finish(command, &python, &arguments)
    }

    /// The folder asked for or that of `make fmu`, if there are FMUs in it.
    fn fmu_folder(&self) -> Option<PathBuf> {
        let folder = self.args.fmus.clone().unwrap_or_else(|| PathBuf::from("out/fmu"));
        folder.join("fmi3/lmpc-vehicle.fmu").is_file().then_some(folder)
    }

    /// The part on the network, where nothing it sends can leave.
    fn isolated_network(&self) -> Result<()> {
        let part = ["tour", "--network-part", "--out", &self.args.out.display().to_string()];
        let inside = |then: &str| format!("{NETWORK_UP} && {then}");
        let flags = if nix::unistd::geteuid().is_root() { "-n" } else { "-rn" };
        let can = Command::new("unshare")
            .args([flags, "sh", "-c", &inside("true")])
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .status();
        let (mut command, url) = if can.is_ok_and(|status| status.success()) {
            result("In a network namespace of their own: nothing they send leaves it.")?;
            let mut command = Command::new("unshare");
            command.args([flags, "sh", "-c", &inside("exec \"$@\""), "sh"]).arg(&self.program);
            command.args(part).args(self.talk.quiet.then_some("--quiet"));
            (command, DEFAULT_URL)
        } else {
            result("In a multicast group of their own, with ttl 0: it stays on this computer.")?;
            (self.command(&part), OWN_GROUP)
        };
        command.env("LCM_DEFAULT_URL", url).env_remove("LMPC_KEY");
        finish(command, "lmpc", &part)
    }

    /// The controller, the car, and the drive once more from its log.
    fn network(&self) -> Result<()> {
        let (learned, log) = (self.file("learned.lmpc"), self.file("drive.log"));
        for old in [&learned, &log] {
            if Path::new(old).exists() {
                fs::remove_file(old).with_context(|| format!("cannot remove {old}"))?;
            }
        }
        let serve = [&["serve", "--learned", &learned, "--log", &log], &WARM_UP[..]].concat();
        show("lmpc", &serve, " &")?;
        let mut service = ServiceProcess::start(self.command(&serve))?;
        let drive = ["vehicle", "sim", "--lock-step", "--laps", "8"];
        let drive = [&drive[..], &WARM_UP].concat();
        let drove = self.lmpc(&drive);
        result(&paint(SOFT, "$ kill -INT %1"))?;
        service.end()?;
        drove?;
        self.lmpc(&[&["replay", &log], &WARM_UP[..]].concat())
    }

    fn end(&self) -> Result<()> {
        let out = self.args.out.display();
        result(&format!("\n{}", paint(GOOD, &format!("Done. All of it is in {out}."))))?;
        result(
            "Next:
  lmpc race --help                 another car, track, grip, delay, any setting
  lmpc study --help                many races: seeds, settings, cars, tracks
  lmpc vehicle --help              a car of your own: an FMU, or its own LCM messages
  lmpc hil --help                  a bench with faults and a verdict",
        )?;
        Ok(())
    }
}

/// The line of a shell that does what comes next.
fn show(program: &str, arguments: &[&str], end: &str) -> Result<()> {
    let line = format!("$ {program} {}{end}", arguments.join(" "));
    Ok(result(&paint(SOFT, &line))?)
}

fn finish(mut command: Command, program: &str, arguments: &[&str]) -> Result<()> {
    let line = || format!("{program} {}", arguments.join(" "));
    let status = command.status().with_context(|| format!("cannot run `{}`", line()))?;
    if !status.success() {
        bail!("`{}` failed: {status}", line());
    }
    Ok(())
}

/// The controller as a program beside this one.
struct ServiceProcess(Child);

impl ServiceProcess {
    /// Starts it and waits for its first heartbeat: from then on it receives the car's states.
    fn start(mut command: Command) -> Result<Self> {
        let url = NetworkArgs { url: None, key: None }.url();
        let network = transport::open(&url, None)?;
        let heartbeats = Inbox::queue(1);
        let channel = format!("{}lmpc", channels::HEARTBEAT);
        network.subscribe(Filter::channel(&channel), heartbeats.sink())?;
        let service = Self(command.spawn().context("cannot start `lmpc serve`")?);
        if heartbeats.wait_until(Instant::now() + PATIENCE).is_none() {
            bail!(
                "`lmpc serve` sent no heartbeat on {channel} ({url}) in {} s",
                PATIENCE.as_secs()
            );
        }
        Ok(service)
    }

    fn end(&mut self) -> Result<()> {
        kill(Pid::from_raw(i32::try_from(self.0.id())?), Signal::SIGINT)?;
        let status = self.0.wait()?;
        if !status.success() {
            bail!("`lmpc serve` failed: {status}");
        }
        Ok(())
    }
}

impl Drop for ServiceProcess {
    fn drop(&mut self) {
        // It has ended, unless something failed before.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}
