//! What a person at the terminal relies on: a dry run commands nothing, Ctrl-C stops the car.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "code of tests")]

use std::io::{BufRead as _, BufReader};
use std::time::Duration;

use common::{MULTICAST, Program, URL, isolated};
use lcm_types::{ActuationCommand, ActuationReport, Checked as _, channels};
use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;
use transport::{Filter, Inbox, Received};

mod common;

const PATIENCE: Duration = Duration::from_secs(60);
/// Answers before Ctrl-C.
const ANSWERS: usize = 20;
/// `source` of a report: full braking, for want of a command to drive.
const SAFE_STOP: i8 = 3;

/// Every message of a drive up to `ANSWERS` answers on `channel`, then Ctrl-C for `lmpc serve`, and
/// everything up to the end of a short drive of the car.
fn drive(serve: &[&str], channel: &str) -> Vec<Received> {
    let network = transport::open(URL, None).unwrap();
    let inbox = Inbox::queue(100_000);
    network.subscribe(Filter::All, inbox.sink()).unwrap();
    let mut service = Program::start(&[&["serve", "--url", URL], serve].concat());
    assert!(inbox.wait(PATIENCE).is_some(), "a heartbeat of `lmpc serve`");
    let mut car = Program::start(&["vehicle", "sim", "--steps", "60", "--url", URL]);
    let mut messages = Vec::new();
    while messages.iter().filter(|m: &&Received| m.channel == channel).count() < ANSWERS {
        messages.push(inbox.wait(PATIENCE).expect("an answer to each state"));
    }
    let id = i32::try_from(service.0.id()).unwrap();
    kill(Pid::from_raw(id), Signal::SIGINT).unwrap();
    assert!(service.0.wait().unwrap().success(), "the end by Ctrl-C is no failure");
    car.0.wait().unwrap();
    messages.extend(std::iter::from_fn(|| inbox.take()));
    messages
}

fn on<'a>(messages: &'a [Received], channel: &'a str) -> impl Iterator<Item = &'a Received> {
    messages.iter().filter(move |message| message.channel == channel)
}

fn commands(messages: &[Received], channel: &str) -> Vec<ActuationCommand> {
    on(messages, channel).map(|m| ActuationCommand::open(&m.payload).unwrap()).collect()
}

fn reports(messages: &[Received]) -> Vec<ActuationReport> {
    on(messages, channels::ACTUATION).map(|m| ActuationReport::open(&m.payload).unwrap()).collect()
}

#[test]
fn a_dry_run_says_what_it_would_do_and_commands_nothing() {
    isolated("a_dry_run_says_what_it_would_do_and_commands_nothing", MULTICAST, URL, || {
        let messages = drive(&["--dry-run"], channels::COMMAND_DRY);
        assert_eq!(on(&messages, channels::COMMAND).count(), 0);
        let would = commands(&messages, channels::COMMAND_DRY);
        assert!(would.iter().filter(|c| c.enable && c.accel > 0.0).count() >= ANSWERS / 2);
        assert!(reports(&messages).iter().all(|report| !report.enabled && report.cmd_seq == 0));
    });
}

#[test]
fn a_network_of_liblcm_prints_each_line_once() {
    // The program starts itself again with the URL in its environment.
    let folder = tempfile::tempdir().unwrap();
    let learned = folder.path().join("learned.lmpc").display().to_string();
    let mut serve = std::process::Command::new(env!("CARGO_BIN_EXE_lmpc"))
        .args(["serve", "--url", "memq://", "--learned", &learned])
        .env_remove("LCM_DEFAULT_URL")
        .stderr(std::process::Stdio::piped())
        .spawn()
        .map(Program)
        .unwrap();
    let mut lines = Vec::new();
    for line in BufReader::new(serve.0.stderr.take().unwrap()).lines() {
        lines.push(line.unwrap());
        if lines.iter().any(|line| line.contains("waiting for CAR/STATE")) {
            break;
        }
    }
    let loaded = lines.iter().filter(|line| line.contains("laps loaded")).count();
    assert_eq!(loaded, 1, "{lines:#?}");
}

#[test]
fn ctrl_c_tells_the_car_to_stop() {
    isolated("ctrl_c_tells_the_car_to_stop", MULTICAST, URL, || {
        let messages = drive(&[], channels::COMMAND);
        let commands = commands(&messages, channels::COMMAND);
        let (last, before) = commands.split_last().unwrap();
        assert!(before.iter().filter(|c| c.enable).count() >= ANSWERS - 1);
        assert!(!last.enable && last.mode == ActuationCommand::MODE_SAFE_STOP, "{last:?}");
        assert!(last.plan_accel.is_empty(), "{last:?}");
        let reports = reports(&messages);
        assert!(reports.iter().any(|report| report.enabled), "it drove");
        // By that command, and not because no other came.
        let told: Vec<_> = reports.iter().filter(|r| r.cmd_seq == last.h.seq).collect();
        assert!(!told.is_empty() && told.iter().skip(1).all(|r| r.source == SAFE_STOP), "{told:?}");
    });
}

#[test]
fn a_log_has_every_state_before_its_answer_and_replays() {
    isolated("a_log_has_every_state_before_its_answer_and_replays", MULTICAST, URL, || {
        let folder = tempfile::tempdir().unwrap();
        let log = folder.path().join("drive.log").display().to_string();
        let messages = drive(&["--log", &log], channels::COMMAND);
        assert!(commands(&messages, channels::COMMAND).len() >= ANSWERS);
        let mut known = std::collections::BTreeSet::new();
        let mut answered = 0;
        for event in lcm_types::eventlog::EventReader::new(std::fs::File::open(&log).unwrap()) {
            let event = event.unwrap();
            match event.channel.as_str() {
                channels::STATE => {
                    known.insert(lcm_types::VehicleState::open(&event.data).unwrap().h.seq);
                }
                channels::COMMAND => {
                    let command = ActuationCommand::open(&event.data).unwrap();
                    answered += u32::from(command.enable);
                    assert!(!command.enable || known.contains(&command.state_seq), "{command:?}");
                }
                _ => {}
            }
        }
        assert!(answered >= 20, "{answered}");
        let replay = std::process::Command::new(env!("CARGO_BIN_EXE_lmpc"))
            .args(["replay", &log])
            .output()
            .unwrap();
        let said = String::from_utf8_lossy(&replay.stdout).into_owned();
        assert!(replay.status.success(), "{said}{}", String::from_utf8_lossy(&replay.stderr));
    });
}
