//! Malformed datagrams and 20,000 messages per second against `lmpc serve` and `lmpc vehicle sim`
//! themselves: both live, and no command is lost or wrong.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "code of tests")]
#![allow(clippy::print_stdout, reason = "figures for `--nocapture`")]

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use common::datagrams::{cases, noise};
use common::{MULTICAST, Program, URL, isolated};
use lcm_types::{ActuationCommand, Checked as _, VehicleState, channels};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use transport::{Filter, Inbox, Transport};

mod common;

const PATIENCE: Duration = Duration::from_secs(60);
/// Enough for a storm of half a second and more on a fast machine.
const STEPS: &str = "6000";
/// Messages per second of the storm.
const RATE: f64 = 20_000.0;

/// Each state's answers, by the state's number and time of measurement.
type Answers = BTreeMap<(i64, i64), Vec<(u64, u64, i8)>>;

/// Drives in lock-step; every state and what answers it.
fn drive(network: &dyn Transport) -> Answers {
    let inbox = |channel: &str| {
        let inbox = Inbox::queue(100_000);
        network.subscribe(Filter::channel(channel), inbox.sink()).unwrap();
        inbox
    };
    let (states, commands) = (inbox(channels::STATE), inbox(channels::COMMAND));
    let alive = inbox("HB/lmpc");
    let mut serve = Program::start(&["serve", "--url", URL, "--set", "warm_up.laps=1"]);
    assert!(alive.wait(PATIENCE).is_some(), "no heartbeat of `lmpc serve`");
    let sim = ["vehicle", "sim", "--lock-step", "--steps", STEPS, "--url", URL, "--seed", "3"];
    let mut car = Program::start(&sim);
    let status = car.0.wait().unwrap();
    assert_eq!(status.code(), Some(0), "`lmpc vehicle sim`: {status}");
    assert_eq!(serve.0.try_wait().unwrap(), None, "`lmpc serve` has ended");
    let mut answers = Answers::new();
    let good = std::iter::from_fn(|| states.take());
    for state in good.filter_map(|r| VehicleState::open(&r.payload).ok()) {
        answers.insert((state.h.seq, state.meas_mono_ns), Vec::new());
    }
    let good = std::iter::from_fn(|| commands.take());
    for c in good.filter_map(|r| ActuationCommand::open(&r.payload).ok()) {
        let known = answers.get_mut(&(c.state_seq, c.state_mono_ns)).expect("a state it answers");
        known.push((c.accel.to_bits(), c.steer.to_bits(), c.mode));
    }
    answers
}

/// Sends until `stop`: noise on channels of others, damaged copies of real messages on ours, and
/// every case of the malformed datagrams, over and over. Returns messages sent.
fn storm(stop: &AtomicBool) -> u64 {
    let network = transport::open(URL, None).unwrap();
    let (noise, cases) = (noise(), cases("CMD"));
    let mut rng = Pcg64::seed_from_u64(2);
    let mut sealed = Vec::new();
    VehicleState::default().seal_into(&mut sealed).unwrap();
    let (begin, mut sent) = (Instant::now(), 0_u64);
    while !stop.load(Ordering::Relaxed) {
        while (sent as f64) < begin.elapsed().as_secs_f64() * RATE {
            let result = match sent % 20 {
                0 => network.publish(channels::STATE, &sealed[..sealed.len() - 1]),
                1 => {
                    let mut flipped = sealed.clone();
                    flipped[rng.random_range(0..sealed.len())] ^= 0x10;
                    let ours = [channels::STATE, channels::COMMAND, channels::OPERATOR];
                    network.publish(ours[rng.random_range(0..3)], &flipped)
                }
                2 => {
                    let (_, datagrams) = &cases[rng.random_range(0..cases.len())];
                    datagrams.iter().for_each(|datagram| drop(noise.send(datagram)));
                    Ok(())
                }
                _ => network.publish("CAMERA", &[0; 1024]),
            };
            // A full send buffer is part of a storm.
            sent += u64::from(result.is_ok());
        }
        std::thread::sleep(Duration::from_micros(500));
    }
    println!("{sent} messages, {:.0} per second", sent as f64 / begin.elapsed().as_secs_f64());
    sent
}

#[test]
fn a_storm_loses_and_changes_no_command() {
    isolated("a_storm_loses_and_changes_no_command", MULTICAST, URL, || {
        let network = transport::open(URL, None).unwrap();
        let calm = drive(&*network);
        let stop = Arc::new(AtomicBool::new(false));
        let seen = Arc::clone(&stop);
        let thread = std::thread::spawn(move || storm(&seen));
        let stormy = drive(&*network);
        stop.store(true, Ordering::Relaxed);
        assert!(thread.join().unwrap() > 10_000, "that was no storm");
        for (what, answers) in [("calm", &calm), ("stormy", &stormy)] {
            let lost: Vec<_> = answers.iter().filter(|(_, a)| a.len() != 1).collect();
            assert!(lost.is_empty(), "{what}: not answered once: {lost:?}");
        }
        let by_time = |answers: &Answers| -> BTreeMap<i64, (u64, u64, i8)> {
            answers.iter().map(|((_, time), answer)| (*time, answer[0])).collect()
        };
        assert_eq!(by_time(&calm).len(), STEPS.parse::<usize>().unwrap());
        assert!(by_time(&calm) == by_time(&stormy), "commands differ");
        println!("{} states, {} said again", calm.len(), stormy.len() - by_time(&stormy).len());
    });
}
