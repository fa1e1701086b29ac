//! `lmpc operator` and `lmpc top` beside `lmpc bridge` and `lmpc serve`, over real multicast.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "code of tests")]

use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use common::{MULTICAST, Program, URL, isolated};
use lcm_types::{Heartbeat, Message as _, channels};
use transport::{Filter, Inbox};

mod common;

const PATIENCE: Duration = Duration::from_secs(60);
/// The dead man's timeout and a tick, and a wide margin for a busy machine.
const STOP: Duration = Duration::from_millis(110 + 400);

fn lmpc(arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_lmpc"));
    command.args(arguments).env("NO_COLOR", "1").stdin(Stdio::null()).output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

fn until_obeyed(order: &[&str]) {
    let begun = Instant::now();
    loop {
        let output = lmpc(&[&["operator", "--url", URL], order].concat());
        if output.status.success() {
            return;
        }
        assert!(begun.elapsed() < PATIENCE, "{order:?}: {}", text(&output.stderr));
    }
}

/// Waits for a state of the bridge; how long that took.
fn until_state(life: &Inbox, state: i8) -> Duration {
    let begun = Instant::now();
    loop {
        let beat = life.wait(PATIENCE).expect("a life sign");
        if Heartbeat::decode(&beat.payload).unwrap().state == state {
            return begun.elapsed();
        }
        assert!(begun.elapsed() < PATIENCE, "never in state {state}");
    }
}

fn hold() -> Child {
    let mut command = Command::new(env!("CARGO_BIN_EXE_lmpc"));
    command.args(["operator", "start", "--deadman", "--url", URL]);
    command.stdin(Stdio::piped()).stdout(Stdio::null()).spawn().unwrap()
}

#[test]
fn a_dead_mans_switch_drives_while_it_is_held_and_the_view_shows_it() {
    isolated(
        "a_dead_mans_switch_drives_while_it_is_held_and_the_view_shows_it",
        MULTICAST,
        URL,
        || {
            let network = transport::open(URL, None).unwrap();
            let life = Inbox::queue(1000);
            network.subscribe(Filter::channel("HB/bridge"), life.sink()).unwrap();
            let nothing = lmpc(&["top", "--once", "--listen", "0.3", "--url", URL]);
            assert_eq!(nothing.status.code(), Some(1), "{}", text(&nothing.stdout));
            let _bridge = Program::start(&["bridge", "--url", URL]);
            let _serve = Program::start(&["serve", "--url", URL]);
            let release: [fn(&mut Child); 3] = [
                |held| drop(held.stdin.take()),
                |held| nix::sys::signal::kill(pid(held), nix::sys::signal::SIGINT).unwrap(),
                |held| held.kill().unwrap(),
            ];
            for (way, release) in release.into_iter().enumerate() {
                until_obeyed(&["arm"]);
                let mut held = hold();
                until_state(&life, Heartbeat::RUNNING);
                // Held for longer than any timeout: it goes on driving.
                std::thread::sleep(Duration::from_secs(2));
                assert!(held.try_wait().unwrap().is_none(), "{way}: it let go by itself");
                if way == 0 {
                    look();
                }
                while life.take().is_some() {}
                let beat = life.wait(PATIENCE).unwrap();
                assert_eq!(Heartbeat::decode(&beat.payload).unwrap().state, Heartbeat::RUNNING);
                let begun = Instant::now();
                release(&mut held);
                until_state(&life, Heartbeat::SAFE_STOP);
                let took = begun.elapsed();
                // A life sign comes every 100 ms.
                assert!(took < STOP + Duration::from_millis(100), "{way}: {took:?}");
                let ended = held.wait().unwrap();
                assert_eq!(ended.success(), way < 2, "{way}: {ended}");
                until_state(&life, Heartbeat::IDLE);
            }
        },
    );
}

fn pid(child: &Child) -> nix::unistd::Pid {
    nix::unistd::Pid::from_raw(i32::try_from(child.id()).unwrap())
}

/// What `lmpc top` shows of a car that drives.
fn look() {
    let shown = lmpc(&["top", "--once", "--url", URL]);
    let view = text(&shown.stdout);
    assert!(shown.status.success(), "{view}");
    for word in ["RUNNING", "●", "CAR/STATE", "dead man's switch", "of 100 ms", "driven by"] {
        assert!(view.contains(word), "no `{word}` in\n{view}");
    }
    assert!(!view.contains('\x1b'), "no colours where nobody sees them:\n{view}");
    #[allow(clippy::print_stdout, reason = "seen with --nocapture")]
    {
        println!("{view}");
    }
    let shown = lmpc(&["top", "--json", "--url", URL]);
    let seen: serde_json::Value = serde_json::from_slice(&shown.stdout).unwrap();
    let states = seen["programs"].as_array().unwrap();
    let state = |name: &str| {
        states.iter().find(|program| program["name"] == name).map(|p| p["state"].clone()).unwrap()
    };
    assert_eq!((state("bridge"), state("lmpc")), ("RUNNING".into(), "RUNNING".into()));
    assert_eq!(seen["order"]["order"], "start");
    assert!(seen["car"]["v_x_mps"].as_f64().unwrap() > 0.1, "{seen}");
    let channel = |name: &str| {
        let all = seen["channels"].as_array().unwrap();
        all.iter().find(|channel| channel["name"] == name).cloned().unwrap()
    };
    // 100 and 10 times a second, on a busy machine.
    assert!((50.0..=130.0).contains(&channel(channels::STATE)["rate_hz"].as_f64().unwrap()));
    assert!((5.0..=20.0).contains(&channel(channels::COMMAND)["rate_hz"].as_f64().unwrap()));
    assert_eq!(channel(channels::COMMAND)["unreadable"], 0);
}

#[test]
fn operators_are_obeyed_one_straight_after_the_other() {
    isolated("operators_are_obeyed_one_straight_after_the_other", MULTICAST, URL, || {
        let _serve = Program::start(&["serve", "--url", URL]);
        until_obeyed(&["speed-cap", "1"]);
        // The address before and after the order, and no pause between two programs.
        let begun = Instant::now();
        for arguments in [
            ["operator", "--url", URL, "speed-cap", "2"],
            ["operator", "speed-cap", "--url", URL, "3"],
            ["operator", "speed-cap", "1.5", "--url", URL],
        ] {
            let output = lmpc(&arguments);
            assert!(output.status.success(), "{arguments:?}: {}", text(&output.stderr));
            assert_eq!(text(&output.stdout).trim(), "lmpc: RUNNING");
        }
        // A second of silence before each was needed once: three seconds.
        assert!(begun.elapsed() < Duration::from_millis(2700), "{:?}", begun.elapsed());
        let held = lmpc(&["operator", "start", "--deadman", "--url", URL]);
        assert_eq!(held.status.code(), Some(1), "without a bridge nobody watches the switch");
        assert!(text(&held.stderr).contains("no bridge"), "{}", text(&held.stderr));
    });
}
