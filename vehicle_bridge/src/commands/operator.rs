//! `lmpc bridge` and `lmpc operator`.

use std::io;
use std::sync::Arc;
use std::sync::atomic::Ordering;

use anyhow::Result;
use lcm_types::OperatorCommand;
use vehicle_model::{Plant, PlantParams, State};

use super::network::{connect, logged, on_signal, real_time};
use super::{Outcome, setup};
use crate::cli::{BridgeArgs, OperatorArgs, OperatorOrder};
use crate::console::{Talk, WARN, complain, paint, result};
use crate::network::bridge::Bridge;
use crate::network::convert;
use crate::network::operator_client::{Answered, Held, Operator};
use crate::safety::{Lapse, Rules};
use crate::top::state_name;

/// Runs the bridge until Ctrl-C.
pub(super) fn bridge(args: &BridgeArgs, talk: Talk) -> Result<Outcome> {
    let options = setup::race(&args.controller, 0)?;
    let params = PlantParams { seed: args.seed, ..options.plant.clone() };
    let period_ns = convert::nanoseconds(options.config.horizon.period);
    let mut rules = Rules::new(&params.car, &options.track, period_ns);
    rules.timeout_ns = i64::from(args.timeout_ms) * 1_000_000;
    let car = Plant::new(params, Arc::clone(&options.track), State::default())?;
    let (network, mut notes) = connect(&args.network.url(), args.realtime)?;
    let (network, log) = logged(network, args.log.as_deref())?;
    notes.extend(real_time(args.realtime));
    for note in &notes {
        talk.say(&paint(WARN, &format!("warning: {note}")));
    }
    let stop = on_signal()?;
    talk.say("bridging a simulated car; Ctrl-C ends");
    let mut bridge = Bridge::new(rules, Box::new(car), notes, &network)?.with_log(log);
    let bridged = bridge.run(&stop, &mut |phase, lapse| {
        let why = if lapse == Lapse::None { String::new() } else { format!(" ({lapse})") };
        talk.say(&format!("{}{why}", phase.name()));
    });
    let c = bridged.commands;
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
    Ok(Outcome::Done)
}

/// Gives an order.
pub(super) fn operator(args: &OperatorArgs, talk: Talk) -> Result<Outcome> {
    let mut held = false;
    let (command, value, arm_token) = match args.order {
        OperatorOrder::Arm { moving } => (OperatorCommand::ARM, f64::from(u8::from(moving)), 0),
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
            complain(&format!("{who} ended the drive, it is in state {}", state_name(ack.state)));
            Ok(Outcome::Degraded)
        }
    }
}

/// Prints answers.
fn show(answers: &[Answered]) -> Result<Outcome> {
    let mut refused = false;
    for answer in answers {
        let state = state_name(answer.ack.state);
        if answer.ack.accepted {
            result(&format!("{}: {state}", answer.who))?;
        } else {
            refused = true;
            complain(&format!("{} refuses in state {state}: {}", answer.who, answer.ack.detail));
        }
    }
    Ok(if refused { Outcome::Problems } else { Outcome::Done })
}
