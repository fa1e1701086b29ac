#![allow(clippy::unwrap_used)]

use std::sync::Arc;

use vehicle_model::{CarParams, Plant, PlantParams, SensorNoise, State, Track};

use super::Stage;
use crate::config::Config;
use crate::controller::Controller;
use crate::presets::Preset;
use crate::snapshot::ControllerState;
use crate::status::{Command, LapKind, Measurement, Pose};

/// A simulated car with less grip than its controller assumes, and noisy sensors.
#[derive(Clone)]
struct Car {
    plant: Plant,
    steps: u32,
}

const PERIOD: f64 = 0.1;

impl Car {
    fn new(track: &Arc<Track>, noisy: bool) -> Self {
        let noise = if noisy { SensorNoise::laboratory() } else { SensorNoise::default() };
        let car = CarParams::builtin("barc").unwrap();
        let mut params =
            PlantParams { noise, seed: 3, ..PlantParams::new(car.clone().with_mu(0.9)) };
        params.car.actuator_delay = PERIOD;
        let start = State { v_x: 1.2, ..State::default() };
        Self { plant: Plant::new(params, track.clone(), start).unwrap(), steps: 0 }
    }

    fn step(&mut self, controller: &mut Controller) -> Command {
        let time = f64::from(self.steps) * PERIOD;
        let pose = Pose::Frenet(self.plant.measure());
        let command = controller.step(&Measurement { time, pose, applied: None });
        self.plant.apply(command.input, PERIOD);
        self.steps += 1;
        command
    }
}

fn controller(track: &Arc<Track>, laps: usize) -> Controller {
    let car = CarParams::builtin("barc").unwrap();
    let mut config = Config::derived(Preset::Race, &car, track);
    config.regression.laps = laps;
    assert_eq!(config.horizon.period, PERIOD);
    Controller::new(config, car, track.clone()).unwrap()
}

fn track() -> Arc<Track> {
    Arc::new(Track::builtin("l").unwrap())
}

/// What a step may do for a closed lap is bounded by a number of samples, and all is done within a
/// part of the next lap.
#[test]
fn no_step_takes_more_than_a_piece() {
    let track = track();
    for (laps, noisy) in [(4, true), (0, true), (4, false)] {
        let (mut car, mut controller) = (Car::new(&track, noisy), controller(&track, laps));
        let piece = controller.setup.piece();
        let (mut done, mut learned, mut since, mut longest, mut most) = (0, 0, 0, 0, 0);
        while learned < 8 {
            let command = car.step(&mut controller);
            let now = controller.memory.lap_end.done;
            most = most.max(now - done);
            done = now;
            since = if command.status.finished.is_some() { 0 } else { since + 1 };
            // The initial laps are slow, and the first fit is far from where it begins.
            if controller.learning_pending() && learned > 0 {
                longest = longest.max(since);
            }
            let learning = |lap: crate::LapResult| lap.kind == LapKind::Learning;
            learned += u32::from(command.status.finished.is_some_and(learning));
            assert!(car.steps < 3000, "no lap");
        }
        assert_eq!(most, piece, "{laps} laps searched");
        assert!((5..50).contains(&longest), "{laps} laps searched: {longest} steps");
    }
}

/// A controller that goes on from the bytes of another's state drives as that one, whatever piece was
/// in work.
#[test]
fn a_state_saved_between_pieces_goes_on_bit_for_bit() {
    let track = track();
    for (laps, noisy) in [(4, true), (0, true), (0, false)] {
        let (mut car, mut controller) = (Car::new(&track, noisy), controller(&track, laps));
        let mut seen = Vec::new();
        // The end of the initial laps, and that of the second learned lap.
        for finished in [4, 6] {
            while controller.laps().len() < finished {
                car.step(&mut controller);
            }
            while controller.learning_pending() {
                let stage = controller.memory.lap_end.stage;
                seen.push((finished, controller.memory.smoothing.is_some(), stage));
                let bytes = postcard::to_allocvec(&controller.state()).unwrap();
                let state: ControllerState = postcard::from_bytes(&bytes).unwrap();
                let mut other = self::controller(&track, laps);
                other.resume(&state);
                let (mut copy, mut kept) = (car.clone(), self::controller(&track, laps));
                kept.resume(&controller.state());
                for k in 0..40 {
                    let expected = copy.clone().step(&mut kept);
                    assert_eq!(copy.step(&mut other), expected, "{stage:?}, {k} steps on");
                }
                assert_eq!(other.save(), kept.save());
                car.step(&mut controller);
            }
        }
        let seen_at = |lap, smoothed, stage| seen.contains(&(lap, smoothed, stage));
        assert_eq!(noisy, seen_at(6, true, Stage::Idle), "{seen:?}");
        assert!(noisy || !seen_at(4, true, Stage::Idle), "{seen:?}");
        // Measurements that are known to be noisy are fitted as they come.
        assert_eq!(!noisy, seen_at(6, false, Stage::Fit), "{seen:?}");
        for stage in [Stage::Data, Stage::Envelope] {
            assert!(seen_at(6, false, stage), "{seen:?}");
        }
    }
}

/// Learning all at once gives what learning in pieces gives.
#[test]
fn all_at_once_is_the_same_as_in_pieces() {
    let track = track();
    // Without noise, which data do not hold.
    let (mut car, mut slow) = (Car::new(&track, false), controller(&track, 4));
    while slow.laps().len() < 6 {
        car.step(&mut slow);
    }
    let mut fast = controller(&track, 4);
    fast.resume(&slow.state());
    fast.finish_learning();
    while slow.learning_pending() {
        slow.learn_piece();
    }
    assert_eq!((fast.save(), fast.grip()), (slow.save(), slow.grip()));
    // What was loaded derives the same from the same laps and grip.
    let mut loaded = controller(&track, 4);
    loaded.load(&fast.save()).unwrap();
    assert!(!loaded.learning_pending());
    for lap in fast.laps() {
        let sample = lap.samples[lap.samples.len() / 2];
        let of = |controller: &Controller| controller.learned_model(&sample.x, &sample.u);
        assert_eq!(of(&loaded), of(&fast));
        let speed =
            |controller: &Controller| controller.memory.derived.envelope.at(sample.x.s).to_bits();
        assert_eq!(speed(&loaded), speed(&fast));
    }
}
