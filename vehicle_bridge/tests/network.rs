//! `lmpc serve` and `lmpc vehicle sim` in two processes over real multicast.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "code of tests")]

use std::io::Cursor;
use std::time::Duration;

use common::{MULTICAST, Program, URL, isolated};
use controller::{Action, Config, Controller};
use lcm_types::eventlog::EventWriter;
use lcm_types::{ActuationCommand, Checked as _, SeqNumber, VehicleState, channels};
use racing::{Race, RaceOptions, change_plant};
use services::replay::replay;
use transport::{Filter, Inbox};
use vehicle_model::{CarParams, Track};

mod common;

const PATIENCE: Duration = Duration::from_secs(60);
const STEPS: usize = 400;
/// One warm-up lap, so that most of the steps are learned.
const WARM_UP: &str = "warm_up.laps=1";
const PLANT: &str = "mu=0.85,noise=0.001";
const SEED: u64 = 3;

fn start(arguments: &[&str]) -> Program {
    let seed = SEED.to_string();
    Program::start(&[arguments, &["--url", URL, "--set", WARM_UP, "--seed", &seed]].concat())
}

/// What the two processes are given.
fn options() -> RaceOptions {
    let car = CarParams::builtin("barc").unwrap();
    let nominal = car.clone().with_mu(1.2);
    let track = std::sync::Arc::new(Track::builtin("l").unwrap());
    let mut config = Config::derived(controller::Preset::Race, &nominal, &track);
    config.warm_up.laps = 1;
    config.warm_up.seed = SEED;
    let mut options = RaceOptions::new(config, nominal, track);
    options.plant = vehicle_model::PlantParams::new(car);
    change_plant(&mut options.plant, &PLANT.split(',').map(str::to_owned).collect::<Vec<_>>())
        .unwrap();
    options.seed = SEED;
    options
}

/// The same race in one process.
fn race() -> Race {
    let mut race = Race::new(options()).unwrap();
    for _ in 0..STEPS {
        race.step().unwrap();
    }
    race
}

/// The message's samples, against the track itself: a sample's own edges project onto it again.
fn check_map(map: &lcm_types::Track, track: &Track) {
    assert_eq!((map.name.as_str(), map.closed, map.length), (track.name(), true, track.length()));
    assert_eq!(map.track_id, protocol::convert::track_id(track));
    for i in 0..usize::try_from(map.n).unwrap() {
        let at = |values: &[f32]| f64::from(values[i]);
        let (s, yaw, left) = (at(&map.s), at(&map.yaw), at(&map.w_left));
        let edge = (at(&map.x) - left * yaw.sin(), at(&map.y) + left * yaw.cos());
        let found = track.project(edge.0, edge.1, Some(s));
        assert!((found.e_y - left).abs() < 1e-4, "{found:?}, width {left}");
        let apart = track.wrap(found.s - s + 1.0) - 1.0;
        assert!(apart.abs() < 1e-3, "{found:?}, expected s = {s}");
        let exact = i as f64 * track.length() / f64::from(map.n);
        assert!((at(&map.kappa) - track.kappa(exact)).abs() < 1e-5, "at {exact}");
    }
}

#[test]
fn in_lock_step_the_commands_are_those_of_the_race_bit_for_bit() {
    let name = "in_lock_step_the_commands_are_those_of_the_race_bit_for_bit";
    isolated(name, MULTICAST, URL, || {
        let network = transport::open(URL, None).unwrap();
        let inbox = |channel: &str| {
            let inbox = Inbox::queue(2 * STEPS);
            network.subscribe(Filter::channel(channel), inbox.sink()).unwrap();
            inbox
        };
        let (states, commands) = (inbox(channels::STATE), inbox(channels::COMMAND));
        let (alive, maps) = (inbox("HB/lmpc"), inbox(channels::TRACK));
        let _serve = start(&["serve"]);
        alive.wait(PATIENCE).expect("a heartbeat of `lmpc serve`");
        let steps = STEPS.to_string();
        let mut car =
            start(&["vehicle", "sim", "--lock-step", "--steps", &steps, "--plant", PLANT]);
        let status = car.0.wait().unwrap();
        assert!(matches!(status.code(), Some(0 | 3)), "{status}");

        let maps: Vec<_> = std::iter::from_fn(|| maps.take()).collect();
        assert!(!maps.is_empty(), "no track on the network");
        for map in &maps {
            check_map(&lcm_types::Track::open(&map.payload).unwrap(), &options().track);
        }

        let race = race();
        let learned = race.steps.iter().filter(|row| row.status.action == Action::Learned).count();
        assert!(learned >= 150, "{learned} learned steps");
        // Every state behind its command: the order in which a recorder can hear them at worst.
        let mut log = EventWriter::new(Vec::new());
        let mut keep = |received: &transport::Received| {
            log.write(0, &received.channel, &received.payload).unwrap();
        };
        let commands: Vec<ActuationCommand> = std::iter::from_fn(|| commands.take())
            .inspect(&mut keep)
            .map(|received| ActuationCommand::open(&received.payload).unwrap())
            .collect();
        let states: Vec<VehicleState> = std::iter::from_fn(|| states.take())
            .inspect(&mut keep)
            .map(|received| VehicleState::open(&received.payload).unwrap())
            .collect();
        for (n, row) in race.steps.iter().enumerate() {
            // A state that is not received at once is sent again, with the same time of measurement.
            let meas_mono_ns = (row.time * 1e9).round() as i64;
            let state = states.iter().find(|state| state.meas_mono_ns == meas_mono_ns);
            let state = state.unwrap_or_else(|| panic!("no state of step {n}"));
            let answers: Vec<_> =
                commands.iter().filter(|c| c.state_mono_ns == meas_mono_ns && c.enable).collect();
            assert!(!answers.is_empty(), "no answer in step {n}");
            for answer in answers {
                let bits = |a: f64, delta: f64| (a.to_bits(), delta.to_bits());
                assert_eq!(
                    bits(answer.accel, answer.steer),
                    bits(row.u.a, row.u.delta),
                    "step {n}, {:?}: {answer:?}, race {:?}",
                    row.status.action,
                    row.u
                );
            }
            assert_eq!(state.quality, 2);
        }

        // The log gives the commands again; to another seed's noise it does not.
        let log = log.into_inner();
        let again = |seed: u64| {
            let RaceOptions { mut config, nominal, track, .. } = options();
            config.warm_up.seed = seed;
            let mut controller = Controller::new(config, nominal, track).unwrap();
            replay(Cursor::new(&log), &mut controller).unwrap()
        };
        let found = again(SEED);
        assert!(found.is_identical() && found.commands == STEPS as u64, "{found:?}");
        let found = again(SEED + 1);
        assert!(
            !found.is_identical() && found.first_difference == Some(SeqNumber::default()),
            "{found:?}"
        );
    });
}
