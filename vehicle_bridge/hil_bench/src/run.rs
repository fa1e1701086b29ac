//! One run of a scenario: start, drive, inject, observe, end.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicI64, Ordering};
use std::time::{Duration, Instant};

use anyhow::{Context as _, Result, bail};
use hosting::rule::{Edges, TrackLimit};
use lcm_types::channels;
use rand::RngExt as _;
use vehicle_model::{CarParams, Limiter, Track};

use super::bench::{Bench, Scenario, Source};
use super::driver::{Driver, Progress, Task};
use super::fault::FaultKind;
use super::host::{self, Host};
use super::measure::{Expectation, Measure, MeasuredValues, Name};
use super::observe::{Heard, Rule};
use super::on_car;
use super::process::Program;
use super::program;
use super::proxy::Proxy;
use super::random;
use super::timeline::Timeline;
use auth::{Key, Signed};
use hosting::realtime;
use protocol::convert::nanoseconds;
use transport::{Filter, Inbox, ThreadStart, Transport, Url, now};

/// A program must send a message within this time.
const READY: Duration = Duration::from_secs(5);
const LOOK: Duration = Duration::from_millis(2);
/// Faults begin up to this much later, by the seed: at any phase of a period. \[s\]
const PHASE: f64 = 0.1;
/// Messages of a run on the car's side. \[-\]
const HEARD: usize = 1 << 16;
/// Channels of which something is measured.
const CHANNELS: [&str; 7] = [
    on_car::TRUTH,
    channels::ACTUATION,
    channels::STATE,
    channels::OPERATOR_ACK,
    channels::TELEMETRY,
    "HB/bridge",
    "HB/lmpc",
];
/// Faults of the car itself, in a run's folder.
const CAR_FAULTS: &str = "car-faults.json";
/// Positions this near to the one asked for count. \[m\]
const NEAR: f64 = 1.0;

/// What a run needs in addition to its scenario.
pub(super) struct RunContext<'a> {
    pub(super) bench: &'a Bench,
    pub(super) car: CarParams,
    pub(super) track: Arc<Track>,
    /// This program.
    pub(super) lmpc: PathBuf,
}

/// What a run gave.
#[derive(Debug, Clone, Default)]
pub struct RunOutcome {
    /// Its seed.
    pub seed: u64,
    /// What was measured.
    pub values: MeasuredValues,
    /// Limits that were broken; empty if it passed.
    pub broken: Vec<String>,
    /// The run over time.
    pub timeline: Timeline,
    /// How long it took. \[s\]
    pub duration: f64,
    /// Earlier tries that the computer itself spoilt, and what they broke.
    pub disturbed: Vec<String>,
    /// Whether a computer that stood still may be to blame for all that is broken.
    pub(super) excusable: bool,
}

/// Runs a scenario once on the networks of this pair of ports.
pub(super) fn run(
    context: &RunContext<'_>,
    scenario: &Scenario,
    seed: u64,
    ports: u16,
) -> RunOutcome {
    let begun = Instant::now();
    let mut outcome = RunOutcome { seed, ..RunOutcome::default() };
    let result = if !scenario.program.is_empty() {
        program::run(context, scenario, seed, ports).map(|values| (values, Timeline::default()))
    } else if scenario.is_alone() {
        host::alone(|| drive(context, scenario, seed, ports))
    } else {
        drive(context, scenario, seed, ports)
    };
    match result {
        Ok((values, timeline)) => {
            let limits = scenario.expectations.iter();
            let broken = limits.filter_map(|limit| Some((limit, limit.broken(&values)?)));
            let (limits, broken): (Vec<_>, Vec<_>) = broken.unzip();
            let strict = |e: &&Expectation| match &e.measure {
                Name::Observed(measure) => measure.is_strict(),
                Name::Printed(_) => true,
            };
            outcome.excusable = !broken.is_empty() && !limits.iter().any(strict);
            (outcome.broken, outcome.values, outcome.timeline) = (broken, values, timeline);
            // No scenario needs to say this, and none may allow it.
            for measure in [Measure::UnsafeOutputs, Measure::Crashes] {
                if let Some(count) = outcome.values.get(measure)
                    && count > 0.0
                    && !scenario.expectations.iter().any(|e| e.measure == measure.into())
                {
                    outcome.broken.push(format!("{}: {count}, limit <= 0", measure.name()));
                    outcome.excusable = false;
                }
            }
        }
        Err(error) => {
            outcome.broken.push(format!("{error:#}"));
            outcome.excusable = scenario.program.is_empty();
        }
    }
    outcome.duration = begun.elapsed().as_secs_f64();
    outcome
}

fn drive(
    context: &RunContext<'_>,
    scenario: &Scenario,
    seed: u64,
    ports: u16,
) -> Result<(MeasuredValues, Timeline)> {
    let folder = Folder::new(ports)?;
    let mut host = Host::new(scenario, &folder.0)?;
    let words = Words::of(context, seed, ports, &folder);
    let (control_url, car_url) = (&words.control_url, &words.car_url);
    let options = |url: &str| Url::parse(url)?.udpm_options();
    let heard = Inbox::queue(HEARD);
    let observer = join(car_url)?;
    observer.subscribe(Filter::Only(CHANNELS.map(str::to_owned).to_vec()), heard.sink())?;
    let key = scenario.key.then(|| Key::create(&folder.0.join("key"))).transpose()?;
    let start = Arc::new(AtomicI64::new(i64::MAX));
    let proxy =
        Proxy::start((&options(control_url)?, &options(car_url)?), &scenario.faults, &start, seed)?;
    let mut programs = Vec::new();
    for name in &scenario.processes {
        let process = context.bench.process(name).with_context(|| format!("process `{name}`"))?;
        let command = words.fill(&process.command);
        let ready = Inbox::latest();
        if let Some(channel) = &process.ready {
            observer.subscribe(Filter::channel(channel), ready.sink())?;
        }
        let mut program = Program::start(name, &command, &folder.0)?;
        let patience = Instant::now() + READY;
        while process.ready.is_some() && ready.take().is_none() {
            if program.crashed() || Instant::now() > patience {
                bail!("process `{name}` did not become ready: {}", program.last_words());
            }
            std::thread::sleep(LOOK);
        }
        programs.push(program);
    }
    let control = join(control_url)?;
    let control: Arc<dyn Transport> = match key {
        Some(key) => Arc::new(Signed::new(control, key)?),
        None => control,
    };
    let task = Task {
        car: context.car.clone(),
        track: Arc::clone(&context.track),
        speed: scenario.speed_mps,
        commands: scenario.source == Source::Light,
        arming: context.bench.arming,
        deadman: scenario.deadman,
        faults: scenario.faults.clone(),
    };
    let driver = Driver::start(&control, task, &start)?;
    let phase = PHASE * random::of(seed ^ 0x7ab1e).random::<f64>();
    let begins = wait(scenario, &driver, phase)?;
    let on_car = folder.0.join(CAR_FAULTS);
    on_car::begin(&on_car, &scenario.faults, begins, seed)?;
    start.store(begins, Ordering::Release);
    let growth = inject(scenario, &mut programs, &mut host, begins)?;
    let crashes = programs.iter_mut().filter_map(|p| p.crashed().then(|| p.name.clone())).count();
    let ended = now().mono.as_ns();
    let orders = driver.orders();
    drop(driver);
    let passed = proxy.passed();
    drop(programs);
    if !on_car::acted(&on_car) {
        bail!("the car read no faults: its process needs `--bench-car {{dir}}/{CAR_FAULTS}`");
    }
    for (index, fault) in scenario.faults.iter().enumerate().filter(|(_, fault)| !fault.car) {
        if fault.action.is_on_messages() && !passed.acted.contains_key(&index) {
            let channel = fault.channel.as_deref().unwrap_or("any channel");
            bail!("fault {} acted on no message of {channel}", index + 1);
        }
        if matches!(fault.action, FaultKind::Order { .. }) && !orders.contains(&index) {
            bail!("the order of fault {} was never given: another one took its time", index + 1);
        }
    }
    let log = scenario.processes.iter().find_map(|n| context.bench.process(n)?.log.clone());
    let heard = match log {
        Some(path) => Heard::of_log(Path::new(&words.fill(&[path])[0]), ended)?,
        None => Heard::of(&heard, ended),
    };
    let limiter = Limiter::new(&context.car);
    let edges = Edges::new(&context.car, TrackLimit::Body);
    let rule = Rule { limiter, edges, track: &context.track, latching: context.bench.arming };
    let mut values = heard.values(begins, &passed, &rule);
    values.insert(Measure::Crashes, crashes as f64);
    values.insert(Measure::MemoryMb, growth);
    Ok((values, heard.timeline(begins, &rule)))
}

/// A network whose receiving thread a busy computer does not hold up, where the system allows it.
pub(super) fn join(url: &str) -> Result<Arc<dyn Transport>> {
    let start: ThreadStart = Box::new(|| drop(realtime::prioritise(realtime::RECEIVE_PRIORITY)));
    Ok(transport::open(url, Some(start))?)
}

/// Waits until the faults are to begin. \[ns\]
fn wait(scenario: &Scenario, driver: &Driver, phase: f64) -> Result<i64> {
    let when = &scenario.when;
    let patience = Instant::now() + Duration::from_secs_f64(scenario.patience_s);
    loop {
        let Progress { driving_ns, speed, s, lap, refusal } = driver.progress();
        if when.refused.as_ref().is_some_and(|why| refusal.contains(why)) {
            return Ok(now().mono.as_ns());
        }
        if let Some(begun) = driving_ns {
            let due = begun + nanoseconds(when.driving_s + phase);
            let there = when.s_m.is_none_or(|at| (at..at + NEAR).contains(&s));
            if now().mono.as_ns() >= due && speed >= when.speed_mps && lap >= when.lap && there {
                return Ok(now().mono.as_ns());
            }
        }
        if Instant::now() > patience {
            let state = if driving_ns.is_some() {
                "drives".to_owned()
            } else {
                format!("was never armed ({refusal})")
            };
            bail!(
                "the scenario's `when` did not come within {} s: the car {state}, {speed:.2} m/s, \
                 s = {s:.2} m, lap {lap}; {} is silent or the car side refuses",
                scenario.patience_s,
                channels::STATE
            );
        }
        std::thread::sleep(LOOK);
    }
}

/// Does to processes and computer what the faults say, until the observation ends; how much the
/// memory of the first process grew meanwhile. \[MB\]
fn inject(
    scenario: &Scenario,
    programs: &mut [Program],
    host: &mut Host,
    begins: i64,
) -> Result<f64> {
    let memory = |programs: &[Program]| programs.first().map_or(0.0, Program::resident_mb);
    let (before, mut most) = (memory(programs), 0.0_f64);
    let end = begins + nanoseconds(scenario.observe_s);
    let mut begun: Vec<Option<i64>> = vec![None; scenario.faults.len()];
    while now().mono.as_ns() < end {
        let since = now().mono.as_ns() - begins;
        for (fault, begun) in scenario.faults.iter().zip(&mut begun) {
            let (from, until) = fault.window_ns();
            host.switch(&fault.action, (from..until).contains(&since))?;
            let (FaultKind::Kill { process }
            | FaultKind::Interrupt { process, .. }
            | FaultKind::Stop { process }
            | FaultKind::Restart { process }) = &fault.action
            else {
                continue;
            };
            let Some(program) = programs.iter_mut().find(|p| p.name == *process) else { continue };
            if since >= from && begun.is_none() {
                *begun = Some(since);
                match &fault.action {
                    FaultKind::Kill { .. } => program.kill(),
                    FaultKind::Interrupt { signal, .. } => program.interrupt(*signal),
                    FaultKind::Restart { .. } => program.restart()?,
                    _ => program.stop(),
                }
            }
            // A busy computer may be late: what it stops stands still for as long as it should.
            let late = begun.map_or(0, |begun| begun - from);
            if since >= until.saturating_add(late) {
                program.go_on();
            }
        }
        most = most.max(memory(programs) - before);
        std::thread::sleep(LOOK);
    }
    Ok(most)
}

/// What words in braces in a bench file's commands stand for.
pub(super) struct Words {
    control_url: String,
    car_url: String,
    others: Vec<(&'static str, String)>,
}

impl Words {
    pub(super) fn of(context: &RunContext<'_>, seed: u64, ports: u16, folder: &Folder) -> Self {
        let url = |port: u16| format!("udpm://239.255.76.67:{port}?ttl=0");
        let others = vec![
            ("{lmpc}", context.lmpc.display().to_string()),
            ("{dir}", folder.0.display().to_string()),
            ("{seed}", seed.to_string()),
            ("{car}", context.bench.car.clone()),
            ("{track}", context.bench.track.clone()),
        ];
        Self { control_url: url(ports), car_url: url(ports + 1), others }
    }

    pub(super) fn fill(&self, command: &[String]) -> Vec<String> {
        let urls = [("{control_url}", &self.control_url), ("{car_url}", &self.car_url)];
        let words = urls.into_iter().chain(self.others.iter().map(|(word, text)| (*word, text)));
        let mut command = command.to_vec();
        for (word, text) in words {
            command.iter_mut().for_each(|part| *part = part.replace(word, text));
        }
        command
    }
}

/// A folder that is removed with its run.
pub(super) struct Folder(pub(super) PathBuf);

impl Folder {
    pub(super) fn new(ports: u16) -> Result<Self> {
        let path = std::env::temp_dir().join(format!("lmpc-hil-{}-{ports}", std::process::id()));
        std::fs::create_dir_all(&path)
            .with_context(|| format!("cannot make {}", path.display()))?;
        Ok(Self(path))
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let path: &Path = &self.0;
        // What stays behind is in the system's folder for such things.
        let _ = std::fs::remove_dir_all(path);
    }
}
