//! Scenarios that are a program: what it prints is measured, how it ends is judged.

use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use anyhow::{Context as _, Result, bail};

use super::bench::Scenario;
use super::measure::{MeasuredValues, Name};
use super::process::ended;
use super::run::{Folder, RunContext, Words};

const LOOK: Duration = Duration::from_millis(5);
const EXIT_CODE: &str = "exit_code";

/// Runs a scenario's program once, with the networks of this pair of ports to itself.
pub(super) fn run(
    context: &RunContext<'_>,
    scenario: &Scenario,
    seed: u64,
    ports: u16,
) -> Result<MeasuredValues> {
    let folder = Folder::new(ports)?;
    let command = Words::of(context, seed, ports, &folder).fill(&scenario.program);
    let [program, arguments @ ..] = &command[..] else { bail!("program: an empty command") };
    let log = folder.0.join("program.txt");
    let out =
        std::fs::File::create(&log).with_context(|| format!("cannot write {}", log.display()))?;
    let mut child = Command::new(program)
        .args(arguments)
        .current_dir(&folder.0)
        .stdin(Stdio::null())
        .stdout(out.try_clone()?)
        .stderr(out)
        .spawn()
        .with_context(|| format!("cannot start `{program}`"))?;
    let begun = Instant::now();
    let patience = Duration::from_secs_f64(scenario.patience_s);
    let code = loop {
        if let Some(status) = child.try_wait()? {
            break ended(status);
        }
        if begun.elapsed() > patience {
            child.kill()?;
            child.wait()?;
            bail!("the program did not end within {} s: {}", scenario.patience_s, text(&log));
        }
        std::thread::sleep(LOOK);
    };
    judge(scenario, code, begun.elapsed(), &text(&log))
}

fn text(log: &std::path::Path) -> String {
    std::fs::read(log).map(|bytes| String::from_utf8_lossy(&bytes).into_owned()).unwrap_or_default()
}

fn judge(scenario: &Scenario, code: i32, took: Duration, text: &str) -> Result<MeasuredValues> {
    let last = text.lines().last().unwrap_or_default();
    if code != 0 && !scenario.expectations.iter().any(|e| e.measure == EXIT_CODE.into()) {
        bail!("exit_code: {code}, limit = 0: {last}");
    }
    for wanted in &scenario.says {
        if !text.contains(wanted.as_str()) {
            bail!("its output does not contain `{wanted}`; it ends with: {last}");
        }
    }
    let mut values = MeasuredValues::default();
    for line in text.lines() {
        if let Some((name, value)) = line.split_once(' ')
            && let Ok(value) = value.trim().parse()
        {
            values.insert(Name::from(name), value);
        }
    }
    values.insert(EXIT_CODE, f64::from(code));
    values.insert("duration_s", took.as_secs_f64());
    Ok(values)
}
