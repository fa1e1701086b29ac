//! The operator's orders in a drive on the network, and the replay of its log.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "code of tests")]

use std::io::Cursor;
use std::sync::Arc;
use std::time::Duration;

use common::{MULTICAST, Program, URL, isolated};
use controller::{Config, Controller};
use lcm_types::eventlog::EventWriter;
use lcm_types::{Checked as _, Message as _, OperatorAck, OperatorCommand, VehicleState, channels};
use protocol::publisher::{Identity, Publisher};
use services::replay::{Replay, replay};
use transport::{Filter, Inbox};
use vehicle_model::{CarParams, Track};

mod common;

const PATIENCE: Duration = Duration::from_secs(60);
/// After how many states since the last answer which order is given: in the warm-up lap, and in
/// the learned ones.
const ORDERS: [(usize, i8, f64); 6] = [
    (30, OperatorCommand::SET_SPEED_CAP, 0.6),
    (40, OperatorCommand::SET_SPEED_CAP, 0.0),
    (230, OperatorCommand::SET_SPEED_CAP, 1.2),
    (70, OperatorCommand::SET_SPEED_CAP, 0.0),
    (40, OperatorCommand::STOP, 0.0),
    (40, OperatorCommand::START, 0.0),
];
/// States after the last order.
const REST: usize = 60;
/// States in which a new order has taken effect. The car has to slow down first.
const EFFECT: usize = 20;

fn controller() -> Controller {
    let nominal = CarParams::builtin("barc").unwrap().with_mu(1.2);
    let track = Arc::new(Track::builtin("l").unwrap());
    let mut config = Config::derived(controller::Preset::Race, &nominal, &track);
    config.warm_up.laps = 1;
    // As `lmpc serve` without --recover.
    config.recovery.active = false;
    Controller::new(config, nominal, track).unwrap()
}

/// Replays the messages on the channels that are kept.
fn again(messages: &[transport::Received], keep: impl Fn(&str) -> bool) -> Replay {
    let mut log = EventWriter::new(Vec::new());
    for message in messages.iter().filter(|m| keep(&m.channel)) {
        log.write(message.arrival.utime, &message.channel, &message.payload).unwrap();
    }
    replay(Cursor::new(log.into_inner()), &mut controller()).unwrap()
}

#[test]
fn a_drive_under_changing_caps_keeps_them_and_replays() {
    isolated("a_drive_under_changing_caps_keeps_them_and_replays", MULTICAST, URL, || {
        let network = transport::open(URL, None).unwrap();
        let inbox = Inbox::queue(100_000);
        network.subscribe(Filter::All, inbox.sink()).unwrap();
        let serve = ["serve", "--url", URL, "--set", "warm_up.laps=1"];
        let _serve = Program::start(&serve);
        assert!(inbox.wait(PATIENCE).is_some(), "a heartbeat of `lmpc serve`");
        let mut operator = Publisher::new(&network, &Identity::new("test"), channels::OPERATOR);
        let _car = Program::start(&["vehicle", "sim", "--lock-step", "--url", URL]);
        let mut messages = Vec::new();
        // The speeds after each answer to an order, in the order of the messages.
        let mut speeds = vec![Vec::new()];
        let mut given = 0;
        while speeds.len() <= ORDERS.len() || speeds[ORDERS.len()].len() < REST {
            let received = inbox.wait(PATIENCE).expect("a message");
            if received.channel == channels::OPERATOR_ACK {
                let ack = OperatorAck::decode(&received.payload).unwrap();
                assert!(ack.accepted, "{ack:?}");
                speeds.push(Vec::new());
            } else if received.channel == channels::STATE {
                let state = VehicleState::open(&received.payload).unwrap();
                let answered = speeds.len() - 1;
                speeds[answered].push(state.vx);
                let due =
                    ORDERS.get(answered).filter(|(after, ..)| speeds[answered].len() >= *after);
                if let (Some((_, command, value)), true) = (due, given == answered) {
                    given += 1;
                    let order = OperatorCommand {
                        h: operator.header(),
                        request_id: given as i64,
                        command: *command,
                        value: *value,
                        ..OperatorCommand::default()
                    };
                    operator.send_sealed(&order).unwrap();
                }
            }
            messages.push(received);
        }

        let fastest = |order: usize| speeds[order].iter().skip(EFFECT).copied().fold(0.0, f64::max);
        assert!(fastest(1) < 0.75, "{}", fastest(1));
        assert!(fastest(2) > 1.6, "{}", fastest(2));
        assert!(fastest(3) < 1.35, "{}", fastest(3));
        assert!(fastest(5) < 0.3, "{}", fastest(5));

        let found = again(&messages, |_| true);
        assert!(found.is_identical(), "{found:?}");
        assert!(found.commands > 350, "{found:?}");
        let found = again(&messages, |channel| channel != channels::OPERATOR);
        assert!(!found.is_identical(), "{found:?}");
    });
}
