//! `lmpc bridge`, `lmpc serve` and `lmpc operator` as processes over real multicast.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "code of tests")]

use std::process::{Command, Output};
use std::time::{Duration, Instant};

use common::{MULTICAST, Program, URL, isolated};
use lcm_types::{ActuationReport, Checked as _, VehicleState, channels};
use transport::{Filter, Inbox};

mod common;

const PATIENCE: Duration = Duration::from_secs(60);
/// One timeout after the command that is due, and a wide margin for a busy machine. \[ns\]
const MOST_NS: i64 = 100_000_000 + 100_000_000 + 300_000_000;

fn operator(order: &[&str]) -> Output {
    let lmpc = Command::new(env!("CARGO_BIN_EXE_lmpc"))
        .args([&["operator", "--url", URL], order].concat())
        .output();
    lmpc.unwrap()
}

/// Repeats the order until it is obeyed.
fn until_obeyed(order: &[&str]) {
    let begun = Instant::now();
    loop {
        let output = operator(order);
        if output.status.success() {
            return;
        }
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(begun.elapsed() < PATIENCE, "{order:?}: {said}");
    }
}

fn refused(order: &[&str], why: &str) {
    let output = operator(order);
    assert_eq!(output.status.code(), Some(1), "{order:?}");
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(said.contains(why), "{order:?}: {said}");
}

#[test]
fn an_armed_controller_drives_a_lap_and_when_it_dies_the_car_stops() {
    let name = "an_armed_controller_drives_a_lap_and_when_it_dies_the_car_stops";
    isolated(name, MULTICAST, URL, || {
        let network = transport::open(URL, None).unwrap();
        let inbox = |channel: &str| {
            let inbox = Inbox::queue(100_000);
            network.subscribe(Filter::channel(channel), inbox.sink()).unwrap();
            inbox
        };
        let (states, reports) = (inbox(channels::STATE), inbox(channels::ACTUATION));
        let commands = inbox(channels::COMMAND);
        let _bridge = Program::start(&["bridge", "--url", URL]);
        states.wait(PATIENCE).expect("a state");
        refused(&["start"], "not armed");
        std::thread::sleep(Duration::from_millis(1200));
        refused(&["arm"], "no heartbeat of the controller");
        let mut serve = Program::start(&["serve", "--url", URL]);
        until_obeyed(&["arm"]);
        refused(&["start", "--token", "12345"], "wrong arm token");
        until_obeyed(&["start"]);
        let begun = Instant::now();
        let next = |inbox: &Inbox| {
            assert!(begun.elapsed() < PATIENCE, "no lap in time");
            inbox.wait(PATIENCE).unwrap()
        };
        while VehicleState::open(&next(&states).payload).unwrap().frenet.lap < 1 {}

        let mut driving = 0;
        while reports.take().is_some_and(|r| {
            driving += u32::from(ActuationReport::open(&r.payload).unwrap().enabled);
            true
        }) {}
        assert!(driving > 500, "{driving} ticks driven");
        serve.0.kill().unwrap();
        serve.0.wait().unwrap();
        let last = std::iter::from_fn(|| commands.wait(Duration::from_millis(50))).last().unwrap();
        let stopped = std::iter::from_fn(|| reports.wait(PATIENCE))
            .find(|r| ActuationReport::open(&r.payload).unwrap().source == 3)
            .expect("a safe stop");
        let took = stopped.arrival.mono.as_ns() - last.arrival.mono.as_ns();
        assert!((0..MOST_NS).contains(&took), "{took} ns from the last command to the safe stop");
        #[allow(clippy::print_stdout, reason = "a figure, seen with --nocapture")]
        {
            println!("safe stop {:.1} ms after the last command", took as f64 * 1e-6);
        }
        while VehicleState::open(&states.wait(PATIENCE).unwrap().payload).unwrap().vx > 0.1 {}
        refused(&["start"], "not armed");
        assert!(operator(&["estop"]).status.success());
        refused(&["arm"], "only `reset`");
        until_obeyed(&["reset"]);
    });
}
