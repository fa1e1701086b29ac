//! `lmpc bridge` and `lmpc operator`.

use std::io;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Duration;

use anyhow::{Result, bail};
use lcm_types::{OperatorCommand, VehicleState};
use vehicle_model::{Plant, PlantParams, State};

use super::network::{comparable, connect, logged, on_signal, real_time};
use super::{Outcome, setup, vehicle};
use command_line::{BridgeArgs, OperatorArgs, OperatorOrder};
use hil_bench::on_car::FaultyCar;
use hosting::settings::Usage;
use hosting::shutdown::Shutdown;
use protocol::convert;
use racing::RaceOptions;
use safety::{BridgeState, Rules, StopReason};
use services::blackbox::BlackBox;
use services::bridge::Bridge;
use services::map_file;
use services::operator_client::{Held, Operator, OperatorAnswer};
use services::side::CarSide;
use services::watchdog::Watchdog;
use terminal::{Talk, WARN, complain, paint, result};
use transport::Transport;
use transport::record::{self, NetworkLog};
use vehicle_host::Vehicle;

/// Runs the bridge until Ctrl-C.
pub(super) fn bridge(args: &BridgeArgs, talk: Talk) -> Result<Outcome> {
    let options = setup::race(&args.controller, 0, talk)?;
    let period_ns = convert::nanoseconds(options.config.horizon.period);
    let mut rules = Rules::new(&options.plant.car, &options.track, period_ns);
    rules.setup = comparable(&args.controller, &options.config, &options.track)?;
    rules.timeout_ns = i64::from(args.timeout_ms) * 1_000_000;
    let changed = set_doubt(&mut rules, &args.doubt)?;
    check(args)?;
    let (network, mut notes, seal) = connect(&args.network, args.realtime)?;
    notes.extend(changed);
    let bare = Arc::clone(&network);
    let watchdog = Watchdog::new(args.relay.as_deref())?;
    let (network, recording) = black_box(network, args, &mut notes);
    let (network, log) = logged(network, args.log.as_deref(), talk)?;
    notes.extend(real_time(args.realtime));
    let tick = Duration::from_nanos(rules.tick_ns.unsigned_abs());
    let side = side(args, &options, tick, &network)?;
    if let CarSide::Mapped(_) = side {
        // A source by a map has neither numbers nor validity; who chose it knows.
        rules.quality = VehicleState::DEGRADED;
        rules.state_ns = args.state_period_ms.map_or(period_ns, |ms| i64::from(ms) * 1_000_000);
        notes.push("the car's states have neither numbers nor checksums (quality 1)".to_owned());
    }
    for note in &notes {
        talk.say(&paint(WARN, &format!("warning: {note}")));
    }
    let shutdown = Shutdown::on_signals()?;
    talk.say(&format!(
        "bridging ({}); Ctrl-C stops the car and ends, a second one ends at once",
        args.vehicle
    ));
    let panic_after = args.bench_panic_s.map(Duration::from_secs_f64);
    let bridge = Bridge::new(rules, side, notes, &network)?.watching(&bare)?;
    let bridge = bridge
        .with_log(log.as_ref().map(|watched| watched.log.clone()).or(recording))
        .with_seal(seal)
        .with_panic(panic_after);
    let mut bridge = bridge.with_watchdog(watchdog);
    let bridged = bridge.run(&shutdown, &mut |phase, reason| {
        let why = if reason == StopReason::None { String::new() } else { format!(" ({reason})") };
        talk.say(&format!("{}{why}", phase.name()));
    });
    let c = bridged.commands;
    if bridged.moving {
        complain("the car was not known to stand when the bridge ended");
    }
    talk.say(&format!(
        "{} ticks, {} missed, latest by {:.1} ms; commands: {} obeyed, {} bad, {} old or not \
         granted, {} stale, {} lost; {} inputs limited, {} stops",
        bridged.ticks,
        bridged.missed,
        bridged.latest * 1e3,
        c.ok,
        c.bad,
        c.old,
        c.stale,
        c.lost,
        c.limited,
        c.stops
    ));
    if bridged.panics > 0 {
        bail!("the bridge panicked (see above); the car was stopped first");
    }
    Ok(Outcome::Done)
}

/// The network with the black box behind it. A bridge without one drives all the same, and says so
/// in every heartbeat.
fn black_box(
    network: Arc<dyn Transport>,
    args: &BridgeArgs,
    notes: &mut Vec<String>,
) -> (Arc<dyn Transport>, Option<NetworkLog>) {
    if args.black_box.as_deref() == Some(Path::new("off")) {
        notes.push("no black box (--black-box off)".to_owned());
        return (network, None);
    }
    let Some(folder) = args.black_box.clone().or_else(BlackBox::default_folder) else {
        notes.push("no black box: neither HOME nor --black-box FOLDER names a folder".to_owned());
        return (network, None);
    };
    let most = u64::from(args.black_box_mb) * 1_000_000;
    let opened = BlackBox::open(&folder, most)
        .and_then(|recording| record::recorded(Arc::clone(&network), recording));
    match opened {
        Ok((recorded, log)) => (recorded, Some(log)),
        Err(error) => {
            notes.push(format!("no black box: {error:#}"));
            (network, None)
        }
    }
}

/// Sets limits of doubt from `NAME=VALUE`; what was changed, in words: every heartbeat says it.
fn set_doubt(rules: &mut Rules, changes: &[String]) -> Result<Vec<String>> {
    let set = |text: &String| {
        let pair = text.split_once('=').and_then(|(name, value)| Some((name, value.parse().ok()?)));
        let (Some((name, value)), Some(limits)) = (pair, &mut rules.doubt) else {
            bail!(Usage(format!("--doubt {text}: expected NAME=VALUE, for example edge_m=0.1")));
        };
        let before =
            limits.set(name, value).map_err(|error| Usage(format!("--doubt {text}: {error}")))?;
        Ok(format!("doubt limit {name} is {value}, {before:.3} by car and track"))
    };
    changes.iter().map(set).collect()
}

/// Whether the options of the car's side go together.
fn check(args: &BridgeArgs) -> Result<()> {
    let (vehicle, map, preload) = (args.vehicle.as_str(), &args.fmu.map, &args.fmu.preload);
    let is_fmu = vehicle.starts_with("fmu:");
    let wrong = match vehicle {
        "sim" if map.is_some() => "--map belongs to --vehicle fmu:FILE or car",
        "car" if map.is_none() => "--vehicle car needs the map of its messages, --map FILE",
        "sim" | "car" if preload.is_some() => "--preload belongs to --vehicle fmu:FILE",
        _ if vehicle != "car" && args.state_period_ms.is_some() => {
            "--state-period-ms belongs to --vehicle car: others are measured every tick"
        }
        "sim" | "car" => return Ok(()),
        _ if is_fmu => return Ok(()),
        other => bail!(Usage(format!("--vehicle {other}: expected sim, fmu:FILE or car"))),
    };
    bail!(Usage(wrong.to_owned()))
}

/// The car's side that the command line names.
fn side(
    args: &BridgeArgs,
    options: &RaceOptions,
    tick: Duration,
    network: &Arc<dyn Transport>,
) -> Result<CarSide> {
    if let Some(file) = args.vehicle.strip_prefix("fmu:") {
        let (file, controller) = (Path::new(file), &args.controller);
        let car = vehicle::fmu(file, &args.fmu, controller, options, args.seed, 0.0)?;
        // A vendor's may know one step size alone.
        return Ok(CarSide::stepped(Box::new(car), tick));
    }
    if let Some(map) = args.fmu.map.as_ref().filter(|_| args.vehicle == "car") {
        return Ok(CarSide::mapped(map_file::load(map)?, &options.track, network));
    }
    let params = PlantParams { seed: args.seed, ..options.plant.clone() };
    let start = match &args.bench_start {
        None => State::default(),
        Some(text) => {
            let place = text.split_once(',').and_then(|(e_y, e_psi)| {
                Some(State {
                    e_y: e_y.parse().ok()?,
                    e_psi: e_psi.parse().ok()?,
                    ..State::default()
                })
            });
            place.ok_or_else(|| Usage(format!("--bench-start {text}: expected E_Y,E_PSI")))?
        }
    };
    let car: Box<dyn Vehicle> = Box::new(Plant::new(params, Arc::clone(&options.track), start)?);
    Ok(CarSide::Simulated(match &args.bench_car {
        Some(file) => Box::new(FaultyCar::new(car, file, network)),
        None => car,
    }))
}

/// Gives an order.
pub(super) fn operator(args: &OperatorArgs, talk: Talk) -> Result<Outcome> {
    let mut held = false;
    let (command, value, arm_token) = match args.order {
        OperatorOrder::Arm { moving, controller } => {
            (OperatorCommand::ARM, f64::from(u8::from(moving)), controller.unwrap_or(0))
        }
        OperatorOrder::Disarm => (OperatorCommand::DISARM, 0.0, 0),
        OperatorOrder::Start { token, deadman } => {
            held = deadman;
            (OperatorCommand::START, 0.0, token.unwrap_or(0))
        }
        OperatorOrder::Stop => (OperatorCommand::STOP, 0.0, 0),
        OperatorOrder::Estop => (OperatorCommand::ESTOP, 0.0, 0),
        OperatorOrder::Reset => (OperatorCommand::ESTOP_RESET, 0.0, 0),
        OperatorOrder::SpeedCap { value } => (OperatorCommand::SET_SPEED_CAP, value, 0),
    };
    let (network, ..) = connect(&args.network, false)?;
    let mut order = OperatorCommand { command, value, arm_token, ..OperatorCommand::default() };
    let mut operator = Operator::new(&network)?;
    if !held {
        return show(&operator.give(&mut order)?);
    }
    let release = on_signal()?;
    let closed = Arc::clone(&release);
    std::thread::Builder::new().name("lmpc-stdin".to_owned()).spawn(move || {
        // Whatever is typed: its end lets go, as a broken terminal does.
        let _ = io::copy(&mut io::stdin(), &mut io::sink());
        closed.store(true, Ordering::Relaxed);
    })?;
    let end = operator.hold(order, &release, &mut |answers| {
        show(answers)?;
        talk.say("the dead man's switch is held; Ctrl-C or the end of the input releases it");
        Ok(())
    })?;
    match end {
        Held::Refused(answers) | Held::Released(answers) => show(&answers),
        Held::Ended(OperatorAnswer { who, ack }) => {
            complain(&format!(
                "{who} ended the drive, it is in state {}",
                BridgeState::name_of(ack.state)
            ));
            Ok(Outcome::Degraded)
        }
    }
}

/// Prints answers.
fn show(answers: &[OperatorAnswer]) -> Result<Outcome> {
    let mut refused = false;
    for answer in answers {
        let state = BridgeState::name_of(answer.ack.state);
        if answer.ack.accepted {
            result(&format!("{}: {state}", answer.who))?;
        } else {
            refused = true;
            complain(&format!("{} refuses in state {state}: {}", answer.who, answer.ack.detail));
        }
    }
    Ok(if refused { Outcome::Problems } else { Outcome::Done })
}
