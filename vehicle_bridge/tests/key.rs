//! `lmpc bridge`, `lmpc serve` and `lmpc operator` on a network with a key.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "code of tests")]

use std::process::{Command, Output};
use std::time::{Duration, Instant};

use common::{MULTICAST, Program, URL, isolated};
use lcm_types::{Heartbeat, Message as _, VehicleState, channels, signature};
use transport::{Filter, Inbox};

mod common;

const PATIENCE: Duration = Duration::from_secs(60);

fn operator(key: Option<&str>, order: &str) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_lmpc"));
    command.args(["operator", "--url", URL, order]);
    command.args(key.iter().flat_map(|key| ["--key", key]));
    command.output().unwrap()
}

/// Repeats the order until it is obeyed.
fn until_obeyed(key: &str, order: &str) {
    let begun = Instant::now();
    loop {
        let output = operator(Some(key), order);
        if output.status.success() {
            return;
        }
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(begun.elapsed() < PATIENCE, "{order}: {said}");
    }
}

#[test]
fn only_holders_of_the_key_are_obeyed_but_for_an_emergency_stop() {
    let name = "only_holders_of_the_key_are_obeyed_but_for_an_emergency_stop";
    isolated(name, MULTICAST, URL, || {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("key").display().to_string();
        let made = Command::new(env!("CARGO_BIN_EXE_lmpc")).args(["key", "new", &path]).output();
        assert!(made.unwrap().status.success());
        let network = transport::open(URL, None).unwrap();
        let inbox = |channel: &str| {
            let inbox = Inbox::queue(100_000);
            network.subscribe(Filter::channel(channel), inbox.sink()).unwrap();
            inbox
        };
        let (states, beats) = (inbox(channels::STATE), inbox("HB/bridge"));
        let _bridge = Program::start(&["bridge", "--url", URL, "--key", &path]);
        let state = states.wait(PATIENCE).expect("a state").payload;
        // Who has no key reads on.
        assert!(signature::split(&state).1.is_some());
        assert!(VehicleState::decode(&state).is_ok());
        let _serve = Program::start(&["serve", "--url", URL, "--key", &path]);
        until_obeyed(&path, "arm");
        until_obeyed(&path, "start");
        let phase = |wanted: i8| {
            let begun = Instant::now();
            loop {
                let beat = Heartbeat::decode(&beats.wait(PATIENCE).unwrap().payload).unwrap();
                if beat.state == wanted {
                    return beat;
                }
                assert!(begun.elapsed() < PATIENCE, "never in state {wanted}: {}", beat.detail);
            }
        };
        phase(Heartbeat::RUNNING);
        for order in ["stop", "disarm", "speed-cap"] {
            let arguments: &[&str] =
                if order == "speed-cap" { &["speed-cap", "0.1"] } else { &[order] };
            let lmpc = Command::new(env!("CARGO_BIN_EXE_lmpc"))
                .args([&["operator", "--url", URL], arguments].concat())
                .output();
            assert_eq!(lmpc.unwrap().status.code(), Some(1), "{order} without the key");
        }
        while beats.take().is_some() {}
        let beat = phase(Heartbeat::RUNNING);
        assert!(beat.detail.contains("unsigned"), "it is said: {}", beat.detail);
        assert!(operator(None, "estop").status.success(), "an emergency stop needs no key");
        phase(Heartbeat::ESTOP);
        while states.take().is_some() {}
        let still = |state: &VehicleState| state.vx < 0.05;
        while !still(&VehicleState::decode(&states.wait(PATIENCE).unwrap().payload).unwrap()) {}
        assert_eq!(operator(None, "reset").status.code(), Some(1), "its reset does");
        while beats.take().is_some() {}
        phase(Heartbeat::ESTOP);
        until_obeyed(&path, "reset");
        phase(Heartbeat::IDLE);
    });
}
