//! `lmpc serve`, `lmpc vehicle`, `lmpc record` and `lmpc replay`.

use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use anyhow::{Context as _, Result, bail};
use controller::{Config, Controller};
use lcm_types::channels;
use vehicle_model::{Plant, PlantParams, State, Track};

use super::{Outcome, folders, setup, vehicle};
use auth::{Key, Seal, Signed};
use command_line::{
    CarArgs, ControllerArgs, FmuVehicleArgs, NetworkArgs, RecordArgs, ReplayArgs, ServeArgs,
    SimArgs,
};
use hosting::realtime;
use hosting::rule::FailureRule;
use hosting::shutdown::{self, Shutdown};
use hosting::worker::Worker;
use hosting::{learned, load};
use protocol::convert;
use racing::RaceOptions;
use racing::words::kind_word;
use safety::Setup;
use services::car::{CarOptions, DriveSummary, SimulatedCar};
use services::mapped_car::MappedCar;
use services::service::{Service, ServiceOptions};
use services::store::LearnedDataStore;
use services::{map_file, replay};
use terminal::{Talk, WARN, paint, result};
use transport::record;
use transport::record::NetworkLog;
use transport::{ThreadStart, Transport};
use vehicle_host::Vehicle;

/// A command may be used this many periods: one lost command does not stop the car.
const VALID_PERIODS: f64 = 2.5;
/// Of a network that leaves this host.
const UNSIGNED: &str = "without a key (--key) every program on this network can command the car";
/// How often a log is looked at.
const LOOK: Duration = Duration::from_millis(50);
/// In lock-step, how long the car waits for an answer.
pub(super) const PATIENCE: Duration = Duration::from_secs(30);

/// Serves until Ctrl-C.
pub(super) fn serve(args: &ServeArgs, talk: Talk) -> Result<Outcome> {
    let options = setup::race(&args.controller, 0, talk)?;
    let period = options.config.horizon.period;
    let mut controller = service_controller(options, args.seed, args.recover)?;
    let warn = |text: &str| talk.say(&paint(WARN, &format!("warning: {text}")));
    let store = match &args.learned {
        Some(path) => Some(LearnedDataStore::open(path, &mut controller, warn)?),
        None => None,
    };
    if let Some(path) = &args.learned {
        talk.say(&format!("{} laps loaded from {}", controller.laps().len(), path.display()));
    }
    let (network, mut notes, seal) = connect(&args.network, args.realtime)?;
    let (network, log) = logged(network, args.log.as_deref(), talk)?;
    notes.extend(real_time(args.realtime));
    // It drives all the same, and tries again: the disk may come.
    let unsaved = args.learned.as_deref().and_then(|path| folders::file(path).err());
    notes.extend(unsaved.map(|error| format!("{error:#}")));
    for note in &notes {
        warn(note);
    }
    let service = ServiceOptions {
        dry_run: args.dry_run,
        wait_for_start: args.wait_for_start,
        valid_for: args.valid_for_ms.map_or(VALID_PERIODS * period, |ms| f64::from(ms) * 1e-3),
        notes,
        setup: setup_message(
            &args.controller,
            controller.config(),
            controller.track(),
            &args.controller.car,
        )?,
        log: log.as_ref().map(|watched| watched.log.clone()),
        seal,
        overrun: args.bench_overrun,
    };
    let stop = on_signal()?;
    let mut service = Service::new(service, controller, store, &network)?;
    talk.say(&format!(
        "waiting for {} on {}; Ctrl-C stops the car and ends",
        channels::STATE,
        args.network.url()
    ));
    if args.dry_run {
        talk.say(&format!(
            "dry run: commands go to {} only; the car receives no command",
            channels::COMMAND_DRY
        ));
    }
    service.run(&stop, &mut |lap, seen| {
        let best = seen.best_time;
        let best =
            if best.is_finite() { format!("best {best:.3} s") } else { "no best yet".into() };
        talk.say(&format!(
            "lap {} ({}): {:.3} s, {best}, margin {:.3} m, {} fallbacks{}",
            lap.lap,
            kind_word(lap.kind),
            lap.lap_time,
            seen.min_margin,
            seen.fallbacks,
            if lap.valid { "" } else { ", not valid" }
        ));
    });
    let deadlines = service.deadlines();
    talk.say(&format!(
        "{} steps, {} longer than a period; the longest took {:.2} ms from state to command",
        deadlines.steps,
        deadlines.overruns,
        deadlines.longest * 1e3
    ));
    Ok(Outcome::Done)
}

/// Runs a simulated car, or a vehicle FMU.
pub(super) fn sim(
    args: &SimArgs,
    fmu: Option<(&PathBuf, &FmuVehicleArgs)>,
    talk: Talk,
) -> Result<Outcome> {
    let options = setup::race(&args.controller, 0, talk)?;
    let config = &options.config;
    let rolling = if args.lock_step { config.warm_up.speed } else { 0.0 };
    let start = State { v_x: args.start_speed.unwrap_or(rolling), ..State::default() };
    let vehicle: Box<dyn Vehicle> = match fmu {
        Some((file, fmu)) => {
            let (controller, seed) = (&args.controller, args.seed);
            Box::new(vehicle::fmu(file, fmu, controller, &options, seed, start.v_x)?)
        }
        None => {
            let params = PlantParams { seed: args.seed, ..options.plant.clone() };
            Box::new(Plant::new(params, Arc::clone(&options.track), start)?)
        }
    };
    let rule = FailureRule::new(config, &options.track, vehicle.car(), args.limit.limit(config));
    let (network, mut notes, _) = connect(&args.network, args.realtime)?;
    notes.extend(real_time(args.realtime));
    for note in &notes {
        talk.say(&paint(WARN, &format!("warning: {note}")));
    }
    let car = CarOptions {
        period: config.horizon.period,
        lock_step: args.lock_step,
        steps: args.steps,
        laps: args.laps,
        patience: PATIENCE,
    };
    let stop = on_signal()?;
    let mut closed = Ok(());
    let drive =
        SimulatedCar::new(car, vehicle, rule, &network)?.run(&stop, &mut |lap, time, clean| {
            let off = if clean { "" } else { "  off the track" };
            if closed.is_ok() {
                closed = result(&format!("lap {lap:3}  {time:8.3} s{off}"));
            }
        })?;
    closed?;
    account(&drive, talk);
    Ok(match (drive.deserted, drive.off_track + drive.stopped) {
        (true, _) => Outcome::Problems,
        (false, 0) => Outcome::Done,
        _ => Outcome::Degraded,
    })
}

/// Bridges to a real car until Ctrl-C.
pub(super) fn car(args: &CarArgs, talk: Talk) -> Result<Outcome> {
    let mapping = map_file::load(&args.map)?;
    let car = load::car(&args.car)?;
    let (network, mut notes, _) = connect(&args.network, args.realtime)?;
    notes.extend(real_time(args.realtime));
    for note in &notes {
        talk.say(&paint(WARN, &format!("warning: {note}")));
    }
    let shutdown = Shutdown::on_signals()?;
    talk.say("bridging; Ctrl-C stops the car and ends");
    let bridged = MappedCar::new(mapping, car, &network)?.run(shutdown.flag())?;
    let (source, commands) = (bridged.source, bridged.commands);
    talk.say(&format!(
        "car: {} states, {} messages bad, {} old, {} incomplete; controller: {} commands, {} bad, \
         {} old, {} stale; {} sent to the car, {} stops",
        bridged.states,
        source.bad,
        source.old,
        source.incomplete,
        commands.ok,
        commands.bad,
        commands.old,
        commands.stale,
        bridged.sent,
        bridged.stops
    ));
    Ok(Outcome::Done)
}

/// Records until Ctrl-C.
pub(super) fn record(args: &RecordArgs, talk: Talk) -> Result<Outcome> {
    let (network, notes, _) = connect(&args.network, false)?;
    for note in notes {
        talk.say(&paint(WARN, &format!("warning: {note}")));
    }
    let stop = on_signal()?;
    talk.say("recording; Ctrl-C ends");
    let warn = |text: &str| talk.say(&paint(WARN, &format!("warning: {text}")));
    let totals = record::record(&network, &args.log, &stop, &mut { warn })?;
    talk.say(&format!("{} messages written, {} dropped", totals.written, totals.dropped));
    Ok(if totals.dropped == 0 { Outcome::Done } else { Outcome::Degraded })
}

/// Replays a log.
pub(super) fn replay(args: &ReplayArgs) -> Result<Outcome> {
    let options = setup::race(&args.controller, 0, Talk { quiet: true })?;
    let mut controller = service_controller(options, args.seed, args.recover)?;
    if let Some(path) = &args.load {
        learned::load(path, &mut controller)?;
    }
    let log =
        File::open(&args.log).with_context(|| format!("cannot read {}", args.log.display()))?;
    let found = replay::replay(BufReader::new(log), &mut controller)?;
    if found.commands == 0 && found.damage.places == 0 && found.unreadable == 0 {
        bail!("{}: no commands of a controller; expected a log with LMPC/CMD", args.log.display());
    }
    result(&format!("{} of {} commands identical", found.identical, found.commands))?;
    if let Some(seq) = found.first_difference {
        result(&format!("the first that differs is number {seq}"))?;
    }
    for (count, what) in [
        (found.without_state, "commands answer states that are not in the log"),
        (found.unreadable, "messages could not be read"),
        (found.damage.places, "places of the log are damaged and were skipped"),
    ] {
        if count > 0 {
            result(&format!("{count} {what}"))?;
        }
    }
    Ok(if found.is_identical() { Outcome::Done } else { Outcome::Problems })
}

fn account(drive: &DriveSummary, talk: Talk) {
    talk.say(&format!(
        "{} periods, {} off the track, {} by fallback plan, {} stopped, {} more than a period late \
         (latest by {:.1} ms)",
        drive.steps,
        drive.off_track,
        drive.by_plan,
        drive.stopped,
        drive.late,
        drive.latest * 1e3
    ));
    if !drive.commanded && !drive.deserted {
        talk.say("no command arrived: is `lmpc serve` running on the same network?");
    }
    if drive.deserted {
        talk.say("no command answered the last state");
    }
}

/// A network, what a person should know about it, and its key if it has one.
type Connected = (Arc<dyn Transport>, Vec<String>, Option<Seal>);

/// The controller of a service, and of its replay: on a real car it drives back to the line by itself
/// only with the operator's leave.
fn service_controller(options: RaceOptions, seed: u64, recover: bool) -> Result<Controller> {
    let mut config = options.config;
    config.warm_up.seed = seed;
    config.recovery.active = recover;
    Ok(Controller::new(config, options.nominal, options.track)?)
}

/// The network of the command line, behind its key if that names one.
pub(super) fn connect(args: &NetworkArgs, fifo: bool) -> Result<Connected> {
    let url = args.url();
    // Before anything is sent without it.
    let key = args.key().map(|path| Key::load(&path)).transpose()?;
    #[cfg(feature = "liblcm")]
    transport::liblcm::enter_environment(&url)?;
    // What it cannot have is reported once, for the loop.
    let start: ThreadStart = Box::new(|| drop(realtime::prioritise(realtime::RECEIVE_PRIORITY)));
    let network = transport::open(&url, fifo.then_some(start))
        .with_context(|| format!("cannot join the network {url}"))?;
    let mut warnings = network.warnings().to_vec();
    let Some(key) = key else {
        let leaves = transport::Url::parse(&url).and_then(|url| url.udpm_options());
        if leaves.is_ok_and(|options| options.ttl > 0) {
            warnings.push(UNSIGNED.to_owned());
        }
        return Ok((network, warnings, None));
    };
    let signed = Signed::new(network, key)?;
    let seal = signed.seal();
    Ok((Arc::new(signed), warnings, Some(seal)))
}

/// A log and the thread that reports at once when the disk stops taking messages, and takes them again.
pub(super) struct Watched {
    pub(super) log: NetworkLog,
    _watch: Worker,
}

/// The network with a log behind it, if one is wanted.
pub(super) fn logged(
    network: Arc<dyn Transport>,
    path: Option<&Path>,
    talk: Talk,
) -> Result<(Arc<dyn Transport>, Option<Watched>)> {
    let Some(path) = path else { return Ok((network, None)) };
    let (network, log) = record::logged(network, path)?;
    let watched = log.clone();
    let _watch = Worker::start("lmpc-log-watch", move |stop| {
        let mut known = false;
        while !stop.load(Ordering::Relaxed) {
            let troubled = watched.is_troubled();
            if let Some(complaint) = watched.complaint().filter(|_| troubled != known) {
                let end = if troubled { "" } else { "; it is written again" };
                talk.say(&paint(WARN, &format!("warning: {complaint}{end}")));
                known = troubled;
            }
            std::thread::sleep(LOOK);
        }
    })?;
    Ok((network, Some(Watched { log, _watch })))
}

/// Takes real-time rights for this thread; what is missing, in words.
pub(super) fn real_time(wanted: bool) -> Vec<String> {
    if !wanted {
        return vec!["without real-time priority (--realtime)".to_owned()];
    }
    [realtime::lock_memory(), realtime::prioritise(realtime::LOOP_PRIORITY)]
        .into_iter()
        .filter_map(Result::err)
        .collect()
}

/// The controller's setup, for the bridge to compare.
pub(super) fn setup_message(
    args: &ControllerArgs,
    config: &Config,
    track: &Track,
    car: &str,
) -> Result<lcm_types::Setup> {
    let Setup { track_id, car_id, config_id, period_ns } = comparable(args, config, track)?;
    let (track, car) = (track.name().to_owned(), car.to_owned());
    Ok(lcm_types::Setup {
        track_id,
        car_id,
        config_id,
        period_ns,
        track,
        car,
        ..Default::default()
    })
}

/// What both ends must have in common, from the command line of either. The car is that of `--car`:
/// what `--plant` and `--nominal-mu` change are differences on purpose.
pub(super) fn comparable(args: &ControllerArgs, config: &Config, track: &Track) -> Result<Setup> {
    Ok(Setup {
        track_id: convert::track_id(track),
        car_id: convert::car_id(&load::car(&args.car)?),
        config_id: convert::config_id(config),
        period_ns: convert::nanoseconds(config.horizon.period),
    })
}

/// Set by a request to end; a second one ends at once. A terminal that is lost is one.
pub(super) fn on_signal() -> Result<Arc<AtomicBool>> {
    let stop = Arc::new(AtomicBool::new(false));
    for signal in shutdown::SIGNALS {
        signal_hook::flag::register_conditional_shutdown(signal, 1, Arc::clone(&stop))?;
        signal_hook::flag::register(signal, Arc::clone(&stop))?;
    }
    Ok(stop)
}
