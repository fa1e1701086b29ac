//! `lmpc hil`.

use std::os::unix::process::CommandExt as _;
use std::path::Path;
use std::process::Command;
use std::time::Instant;

use anyhow::{Context as _, Result, bail};
use bounded_file::Limit;
use comfy_table::{Table, presets};

use super::network::on_signal;
use super::{Outcome, folders};
use command_line::{HilAction, HilArgs, HilRunArgs, ProbeArgs, ProbeProgram};
use file_check::check_file;
use hil_bench::host::NETWORK_UP;
use hil_bench::verdict::{self, Tested};
use hil_bench::{Bench, Verdict, drive, execute, probe};
use terminal::{BAD, GOOD, Talk, paint, result};

const HEAD: [&str; 7] = ["row", "scenario", "expected", "measure", "limit", "measured", "failed"];

/// Runs a bench.
pub(super) fn run(args: &HilArgs, talk: Talk) -> Result<Outcome> {
    let args = match &args.action {
        HilAction::Run(args) => args,
        HilAction::Drive(args) => {
            let stop = on_signal()?;
            drive(&args.network.url(), &args.car, &args.track, args.speed, &stop)?;
            return Ok(Outcome::Done);
        }
        HilAction::Probe(args) => return measure(args).map(|()| Outcome::Done),
    };
    if !args.isolated {
        return Err(isolate());
    }
    let bench = load(args)?;
    let (lmpc, begun) = (std::env::current_exe()?, Instant::now());
    let mut tested = Tested::new(&bench, &args.bench, &lmpc)?;
    tested.options = options(args);
    tested.tester = args.tester.clone().unwrap_or_default();
    folders::results(&args.out)?;
    let total: u32 = bench.scenarios.iter().map(|scenario| bench.repeats(scenario)).sum();
    let mut count = 0;
    let jobs = args.jobs as usize;
    let (verdicts, stood) = execute(&bench, lmpc, jobs, |scenario, run| {
        count += 1;
        for disturbed in &run.disturbed {
            talk.say(&format!("{}, seed {}, repeated: {disturbed}", scenario.name, run.seed));
        }
        if !run.broken.is_empty() {
            let broken = run.broken.join("; ");
            talk.say(&format!("{}, seed {}: {}", scenario.name, run.seed, paint(BAD, &broken)));
        }
        if count % 50 == 0 {
            talk.say(&format!("{count} of {total} runs"));
        }
        Ok(())
    })?;
    let write = |name: &str, text: String| {
        let path = args.out.join(name);
        std::fs::write(&path, text).with_context(|| format!("cannot write {}", path.display()))
    };
    if stood.times > 0 {
        talk.say(&format!(
            "the computer stood still {} times for more than 5 ms, at most {:.1} ms",
            stood.times,
            stood.longest * 1e3
        ));
    }
    tested.ended(begun.elapsed().as_secs_f64(), stood);
    write("junit.xml", verdict::junit(&bench, &tested, &verdicts))?;
    write("verdict.json", verdict::json(&bench, &tested, &verdicts)?)?;
    write("verdict.html", verdict::page(&bench, &tested, &verdicts))?;
    say(&verdicts, args)
}

/// Runs a program of the shipped benches and prints what it measured.
fn measure(args: &ProbeArgs) -> Result<()> {
    let measured = match &args.probe {
        ProbeProgram::SaverKills { kills } => probe::saver_kills(&args.dir, args.seed, *kills)?,
        ProbeProgram::Saver => probe::saver(&args.dir, || Ok(result("ready")?))?,
        ProbeProgram::DamagedLog { network } => {
            probe::damaged_log(&args.dir, args.seed, &network.url())?
        }
        ProbeProgram::LoggedDrive { network } => probe::logged_drive(&args.dir, &network.url())?,
        ProbeProgram::HostileText { network } => probe::hostile_text(&args.dir, &network.url())?,
        ProbeProgram::SignalledCar { network, signal } => {
            probe::signalled_car(&args.dir, &network.url(), *signal)?
        }
    };
    for (name, value) in measured {
        result(&format!("{name} {value}"))?;
    }
    Ok(())
}

fn say(verdicts: &[Verdict<'_>], args: &HilRunArgs) -> Result<Outcome> {
    let mut table = Table::new();
    table.load_style(presets::NOTHING);
    table.set_header(HEAD);
    table.add_rows(verdict::rows(verdicts));
    for line in table.to_string().lines() {
        result(line.trim_end())?;
    }
    result(&format!("page: {}", args.out.join("verdict.html").display()))?;
    let failed: Vec<&str> = verdicts
        .iter()
        .filter(|verdict| verdict.failed() > 0)
        .map(|verdict| verdict.scenario.name.as_str())
        .collect();
    if failed.is_empty() {
        result(&paint(GOOD, "PASS"))?;
        return Ok(Outcome::Done);
    }
    result(&paint(BAD, &format!("FAIL: {}", failed.join(", "))))?;
    Ok(Outcome::Problems)
}

/// What options change of the file, for the verdict.
fn options(args: &HilRunArgs) -> String {
    let scenarios = args.scenarios.iter().map(|name| format!("--scenario '{name}'"));
    let numbers = [
        args.repeats.map(|repeats| format!("--repeats {repeats}")),
        args.seed.map(|seed| format!("--seed {seed}")),
        (args.jobs != 1).then(|| format!("--jobs {}", args.jobs)),
    ];
    scenarios.chain(numbers.into_iter().flatten()).collect::<Vec<_>>().join(" ")
}

fn load(args: &HilRunArgs) -> Result<Bench> {
    let text = bounded_file::text(&args.bench, Limit::SETTINGS)?;
    let checked = check_file(&args.bench);
    if let Some(first) = checked.problems.first() {
        bail!("{}: {first}; `lmpc check {}` names all", checked.file, checked.file);
    }
    let mut bench: Bench = toml::from_str(&text)?;
    if let Some(repeats) = args.repeats {
        bench.repeats = repeats;
        bench.scenarios.iter_mut().for_each(|scenario| scenario.repeats = None);
    }
    for name in [&mut bench.car, &mut bench.track] {
        let beside = args.bench.with_file_name(&*name);
        if beside.is_file() {
            *name = std::path::absolute(beside)?.display().to_string();
        }
    }
    bench.seed = args.seed.unwrap_or(bench.seed);
    if !args.scenarios.is_empty() {
        bench.scenarios.retain(|s| args.scenarios.iter().any(|name| s.name.contains(name)));
        if bench.scenarios.is_empty() {
            bail!("no scenario is called {}", args.scenarios.join(" or "));
        }
    }
    Ok(bench)
}

/// Becomes the same program in a network namespace of its own; returns only if that fails.
fn isolate() -> anyhow::Error {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let program = std::env::current_exe().unwrap_or_else(|_| Path::new("lmpc").to_owned());
    // Root keeps its rights to real-time priority only without a user namespace.
    let flags = if nix::unistd::geteuid().is_root() { "-nm" } else { "-rnm" };
    let error = Command::new("unshare")
        .args([flags, "sh", "-c", &format!("{NETWORK_UP} && exec \"$@\""), "sh"])
        .arg(program)
        .args(arguments)
        .arg("--isolated")
        .exec();
    anyhow::Error::new(error)
        .context("no network of its own: `unshare` and `ip` are needed (util-linux, iproute2)")
}
