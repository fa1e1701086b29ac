//! Orders while driving: a speed cap far below the present speed slows the car down along the
//! track, and without it the car races again; the initial laps are slow enough for slow steering.
#![allow(clippy::unwrap_used)]

use std::sync::Arc;

use controller::{Config, Controller, ControllerState, Measurement, Pose, Preset, Status};
use vehicle_model::{CarParams, Plant, PlantParams, State, Track};

struct Drive {
    controller: Controller,
    plant: Plant,
    steps: u32,
}

impl Drive {
    fn new(car: &CarParams) -> Self {
        let track = Arc::new(Track::builtin("l").unwrap());
        let config = Config::derived(Preset::Race, car, &track);
        let start = State { v_x: config.warm_up.speed, ..State::default() };
        let plant = Plant::new(PlantParams::new(car.clone()), Arc::clone(&track), start).unwrap();
        let controller = Controller::new(config, car.clone(), track).unwrap();
        Self { controller, plant, steps: 0 }
    }

    fn step(&mut self) -> Status {
        let period = self.controller.config().horizon.period;
        let time = f64::from(self.steps) * period;
        let pose = Pose::Frenet(self.plant.measure());
        let command = self.controller.step(&Measurement { time, pose, applied: None });
        self.plant.apply(command.input, period);
        self.steps += 1;
        command.status
    }

    /// How far the centre of gravity is beyond an edge; negative inside.
    fn beyond(&self) -> f64 {
        let (x, track) = (self.plant.truth(), self.controller.track());
        (x.e_y - track.width_left(x.s)).max(-x.e_y - track.width_right(x.s))
    }

    fn until(&mut self, laps: usize) {
        while self.controller.laps().len() < laps {
            self.step();
        }
    }

    /// Speed of the last lap here.
    fn raced(&self, lap: usize) -> f64 {
        let (samples, s) = (&self.controller.laps()[lap].samples, self.plant.truth().s);
        samples.iter().take_while(|sample| sample.x.s <= s).last().unwrap_or(&samples[0]).x.v_x
    }

    fn lap_times(&self) -> Vec<f64> {
        self.controller.laps().iter().map(|lap| lap.result.lap_time).collect()
    }
}

/// One cap at one place; what is wrong with it, if anything.
fn capped(drive: &mut Drive, from: &(ControllerState, Plant, u32), share: f64) -> Option<String> {
    drive.controller.resume(&from.0);
    drive.plant = from.1.clone();
    drive.steps = from.2;
    let at = drive.plant.truth();
    let cap = share * at.v_x;
    let best = drive.lap_times().into_iter().fold(f64::INFINITY, f64::min);
    drive.controller.set_speed_cap(cap).unwrap();
    let (mut slowest, mut widest) = (f64::INFINITY, f64::NEG_INFINITY);
    let raced = drive.controller.laps().len() - 1;
    for _ in 0..60 {
        drive.step();
        // Where bends ask for less than the cap, that counts.
        slowest = slowest.min(drive.plant.truth().v_x / drive.raced(raced).min(cap));
        widest = widest.max(drive.beyond());
    }
    let kept = drive.plant.truth().v_x;
    drive.controller.set_speed_cap(0.0).unwrap();
    let laps = drive.controller.laps().len();
    while drive.controller.laps().len() < laps + 2 {
        drive.step();
        widest = widest.max(drive.beyond());
        if drive.steps - from.2 > 700 {
            break;
        }
    }
    let again = drive.lap_times().last().copied().unwrap_or(f64::INFINITY);
    drive.controller.set_speed_cap(0.0).unwrap();
    let good = widest < 0.0 && slowest > 0.8 && kept < 1.03 * cap && again < 1.1 * best;
    (!good).then(|| {
        format!(
            "cap {cap:.2} at s {:.2}, {:.2} m/s: {widest:.3} m beyond, slowest {slowest:.2} \
             of what is allowed, then {kept:.2}; lap {again:.2} s after {best:.2} s",
            at.s, at.v_x
        )
    })
}

#[test]
fn a_cap_slows_down_along_the_track_and_its_end_is_racing() {
    let places = std::env::var("LMPC_PLACES").ok().and_then(|text| text.parse().ok());
    let places: usize = places.unwrap_or(6);
    let mut drive = Drive::new(&CarParams::builtin("barc").unwrap());
    drive.until(12);
    let mut wrong = Vec::new();
    for place in 0..places {
        // A lap takes about 40 steps.
        for _ in 0..(1 + 44 / places) {
            drive.step();
        }
        let from = (drive.controller.state(), drive.plant.clone(), drive.steps);
        for share in [0.3, 0.5, 0.7, 0.9] {
            wrong.extend(capped(&mut drive, &from, share).map(|text| format!("{place}: {text}")));
        }
        drive.controller.resume(&from.0);
        (drive.plant, drive.steps) = (from.1, from.2);
    }
    assert!(wrong.is_empty(), "{} of {}:\n{}", wrong.len(), 4 * places, wrong.join("\n"));
}

#[test]
fn the_initial_laps_suit_slow_steering() {
    let mut car = CarParams::builtin("barc").unwrap();
    car.delta_rate_max = Some(0.5);
    let mut drive = Drive::new(&car);
    let laps = drive.controller.config().warm_up.laps;
    while drive.controller.laps().len() < laps {
        drive.step();
        assert!(drive.beyond() < 0.0, "{:?}", drive.plant.truth());
        assert!(drive.steps < 3000, "{:?}", drive.plant.truth());
    }
}
