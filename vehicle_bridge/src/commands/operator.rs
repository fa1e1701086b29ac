//! `lmpc bridge` and `lmpc operator`.

use std::io;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Duration;

use anyhow::{Result, bail};
use lcm_types::OperatorCommand;
use vehicle_model::{Plant, PlantParams, State};

use super::network::{comparable, connect, logged, on_signal, real_time};
use super::{Outcome, setup, vehicle};
use crate::cli::{BridgeArgs, OperatorArgs, OperatorOrder};
use crate::console::{Talk, WARN, complain, paint, result};
use hosting::settings::Usage;
use hosting::shutdown::Shutdown;
use protocol::convert;
use racing::RaceOptions;
use safety::{Lapse, Phase, Rules};
use services::bridge::Bridge;
use services::map_file;
use services::operator_client::{Answered, Held, Operator};
use services::side::CarSide;
use transport::Transport;

/// Runs the bridge until Ctrl-C.
pub(super) fn bridge(args: &BridgeArgs, talk: Talk) -> Result<Outcome> {
    let options = setup::race(&args.controller, 0, talk)?;
    let period_ns = convert::nanoseconds(options.config.horizon.period);
    let mut rules = Rules::new(&options.plant.car, &options.track, period_ns);
    rules.setup = comparable(&args.controller, &options.config, &options.track)?;
    rules.timeout_ns = i64::from(args.timeout_ms) * 1_000_000;
    check(args)?;
    let (network, mut notes) = connect(&args.network.url(), args.realtime)?;
    let bare = Arc::clone(&network);
    let (network, log) = logged(network, args.log.as_deref())?;
    notes.extend(real_time(args.realtime));
    let tick = Duration::from_nanos(rules.tick_ns.unsigned_abs());
    let side = side(args, &options, tick, &network)?;
    if let CarSide::Mapped(_) = side {
        // A source by a map has neither numbers nor validity; who chose it knows.
        rules.quality = 1;
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
    let mut bridge = bridge.with_log(log).with_panic(panic_after);
    let bridged = bridge.run(&shutdown, &mut |phase, lapse| {
        let why = if lapse == Lapse::None { String::new() } else { format!(" ({lapse})") };
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
    let car = Plant::new(params, Arc::clone(&options.track), State::default())?;
    Ok(CarSide::Simulated(Box::new(car)))
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
    let (network, _) = connect(&args.network.url(), false)?;
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
        talk.say("the dead man's switch is held; Ctrl-C or the end of the input lets go");
        Ok(())
    })?;
    match end {
        Held::Refused(answers) | Held::Released(answers) => show(&answers),
        Held::Ended(Answered { who, ack }) => {
            complain(&format!(
                "{who} ended the drive, it is in state {}",
                Phase::name_of(ack.state)
            ));
            Ok(Outcome::Degraded)
        }
    }
}

/// Prints answers.
fn show(answers: &[Answered]) -> Result<Outcome> {
    let mut refused = false;
    for answer in answers {
        let state = Phase::name_of(answer.ack.state);
        if answer.ack.accepted {
            result(&format!("{}: {state}", answer.who))?;
        } else {
            refused = true;
            complain(&format!("{} refuses in state {state}: {}", answer.who, answer.ack.detail));
        }
    }
    Ok(if refused { Outcome::Problems } else { Outcome::Done })
}
