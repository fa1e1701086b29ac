//! The operator's orders in a drive on the network, and the replay of its log.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "code of tests")]

use std::sync::Arc;
use std::time::Duration;

use common::{MULTICAST, Program, URL, isolated};
use controller::{Config, Controller};
use lcm_types::eventlog::Writer;
use lcm_types::{Checked as _, Message as _, OperatorAck, OperatorCommand, VehicleState, channels};
use vehicle_bridge::network::outlet::{Identity, Outlet};
use vehicle_bridge::network::replay::{Replay, replay};
use vehicle_bridge::transport::{self, Filter, Inbox};
use vehicle_model::{CarParams, Track};

mod common;

const PATIENCE: Duration = Duration::from_secs(60);
const STEPS: i64 = 420;
/// At which state which order is given: in the warm-up lap, and in the learned ones.
const ORDERS: [(i64, i8, f64); 6] = [
    (30, OperatorCommand::SET_SPEED_CAP, 0.6),
    (60, OperatorCommand::SET_SPEED_CAP, 0.0),
    (220, OperatorCommand::SET_SPEED_CAP, 1.2),
    (290, OperatorCommand::SET_SPEED_CAP, 0.0),
    (320, OperatorCommand::STOP, 0.0),
    (340, OperatorCommand::START, 0.0),
];

fn controller() -> Controller {
    let mut config = Config::from_toml(Config::of_car("barc").unwrap_or_default()).unwrap();
    config.warm_up.laps = 1;
    let nominal = CarParams::builtin("barc").unwrap().with_mu(1.2);
    Controller::new(config, nominal, Arc::new(Track::builtin("l").unwrap())).unwrap()
}

/// Replays the messages on the channels that are kept.
fn again(messages: &[transport::Received], keep: impl Fn(&str) -> bool) -> Replay {
    let mut log = Writer::new(Vec::new());
    for message in messages.iter().filter(|m| keep(&m.channel)) {
        log.write(message.arrival.utime, &message.channel, &message.payload).unwrap();
    }
    replay(&log.into_inner()[..], &mut controller()).unwrap()
}

#[test]
fn a_drive_under_changing_caps_keeps_them_and_replays() {
    isolated("a_drive_under_changing_caps_keeps_them_and_replays", MULTICAST, URL, || {
        let network = transport::open(URL, None).unwrap();
        let inbox = Inbox::queue(100_000);
        network.subscribe(Filter::All, inbox.sink()).unwrap();
        let serve = ["serve", "--url", URL, "--set", "warm_up.laps=1"];
        let _serve = Program::start(&serve);
        assert!(inbox.wait(PATIENCE).is_some(), "a life sign of `lmpc serve`");
        let mut operator = Outlet::new(&network, &Identity::new("test"), channels::OPERATOR);
        let steps = STEPS.to_string();
        let sim = ["vehicle", "sim", "--lock-step", "--steps", &steps, "--url", URL];
        let mut car = Program::start(&sim);
        let (mut messages, mut speeds) = (Vec::new(), Vec::new());
        let mut orders = (1..).zip(ORDERS).peekable();
        while let Some(received) = inbox
            .wait(Duration::from_millis(300))
            .or_else(|| car.0.try_wait().unwrap().is_none().then(|| inbox.wait(PATIENCE)).flatten())
        {
            if received.channel == channels::STATE {
                let state = VehicleState::open(&received.payload).unwrap();
                speeds.push((state.h.seq, state.vx));
                if let Some((request_id, (_, command, value))) =
                    orders.next_if(|(_, (seq, ..))| state.h.seq >= *seq)
                {
                    let h = operator.header();
                    let order =
                        OperatorCommand { h, request_id, command, value, ..Default::default() };
                    operator.send_sealed(&order).unwrap();
                }
            }
            let over = received.channel.starts_with(channels::HEARTBEAT)
                && car.0.try_wait().unwrap().is_some();
            messages.push(received);
            if over {
                break;
            }
        }
        let acks: Vec<OperatorAck> = messages
            .iter()
            .filter(|m| m.channel == channels::OPERATOR_ACK)
            .map(|m| OperatorAck::decode(&m.payload).unwrap())
            .collect();
        assert_eq!(acks.len(), ORDERS.len());
        assert!(acks.iter().all(|ack| ack.accepted), "{acks:?}");

        let fastest = |from: i64, to: i64| {
            let within = speeds.iter().filter(|(seq, _)| (from..to).contains(seq));
            within.map(|(_, v)| *v).fold(0.0, f64::max)
        };
        // The plant's grip and noise are its own; a few periods to slow down.
        assert!(fastest(40, 58) < 0.75, "{}", fastest(40, 58));
        assert!(fastest(240, 288) < 1.35, "{}", fastest(240, 288));
        assert!(fastest(180, 220) > 1.6, "{}", fastest(180, 220));
        assert!(fastest(332, 338) < 0.3, "{}", fastest(332, 338));

        let found = again(&messages, |_| true);
        assert!(found.is_identical(), "{found:?}");
        assert!(found.commands > 380, "{found:?}");
        let found = again(&messages, |channel| channel != channels::OPERATOR);
        assert!(!found.is_identical(), "{found:?}");
    });
}
