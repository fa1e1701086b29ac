//! Back to racing: from random poses inside the lane, and after spins forced at full speed. The
//! lap in which it happens is no lap of the safe set and teaches nothing.
//!
//! A small number of runs by default; `LMPC_POSES=200` before `cargo test --release -p controller
//! --test recovery` starts from that many poses on each track.
#![allow(clippy::unwrap_used)]

use std::sync::Arc;

use controller::{Action, Config, Controller, ControllerState, Measurement, Pose, Preset, Reason};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use vehicle_model::{CarParams, Plant, PlantParams, State, Track};

/// A car that has learned to race, its controller and the clock of both.
struct Racer {
    controller: Controller,
    plant: Plant,
    period: f64,
    steps: u32,
}

impl Racer {
    /// Drives the initial laps and `laps` learned ones.
    fn new(car: &CarParams, track: Track, laps: usize) -> Self {
        let track = Arc::new(track);
        let config = Config::derived(Preset::Race, car, &track);
        let start = State { v_x: config.warm_up.speed, ..State::default() };
        let period = config.horizon.period;
        let all = config.warm_up.laps + laps;
        let plant = Plant::new(PlantParams::new(car.clone()), Arc::clone(&track), start).unwrap();
        let controller = Controller::new(config, car.clone(), track).unwrap();
        let mut racer = Self { controller, plant, period, steps: 0 };
        while racer.controller.laps().len() < all {
            racer.step();
        }
        racer
    }

    fn step(&mut self) -> controller::Status {
        let time = f64::from(self.steps) * self.period;
        let pose = Pose::Frenet(self.plant.measure());
        let command = self.controller.step(&Measurement { time, pose, applied: None });
        assert!(command.input.is_finite());
        self.plant.apply(command.input, self.period);
        self.steps += 1;
        command.status
    }

    /// Puts car and controller back to where they were, and the car in another pose.
    fn put(&mut self, state: &ControllerState, steps: u32, x: State) {
        self.controller.resume(state);
        self.steps = steps;
        self.plant.reset(x);
    }

    /// Drives until the lap after the incident is raced through, and looks at the laps. Returns the
    /// number of steps it took to recover.
    fn races_again(&mut self, what: &str) -> usize {
        let before = self.controller.laps().len();
        let mut recovering = 0;
        let warm_up = self.controller.config().warm_up.speed;
        let most = 8.0 * self.controller.track().length() / warm_up / self.period;
        let began = self.steps;
        let mut incident = before;
        let mut incidents = Vec::new();
        while self.controller.laps().len() < incident + 2 {
            let status = self.step();
            // The first measurements come from where the car was put; beyond the centre of a bend
            // the plant's own frame jumps.
            let put = self.steps - began < 4;
            let beyond = self.controller.track().kappa(status.state.s) * status.state.e_y > 0.7;
            let true_one = put || beyond || status.reason != Reason::Jump;
            assert!(true_one, "{what}: {status:?}");
            if status.action == Action::Recovering {
                recovering += 1;
                incident = self.controller.laps().len();
                incidents.push(incident);
            }
            let took = f64::from(self.steps - began);
            assert!(took < most, "{what}: {status:?} {:?}", self.plant.truth());
        }
        let laps = self.controller.laps();
        for lap in incidents.iter().map(|i| &laps[*i]) {
            let taught = lap.samples.iter().filter(|sample| sample.next.is_some()).count();
            assert!(!lap.result.valid && taught == 0, "{what}: lap {:?}", lap.result);
        }
        assert!(laps[incident + 1].result.valid, "{what}: {:?}", laps[incident + 1].result);
        recovering
    }
}

fn count() -> usize {
    std::env::var("LMPC_POSES").ok().and_then(|text| text.parse().ok()).unwrap_or(8)
}

/// Speeds of the fastest lap, to say what is fast at a place.
fn local_speed(controller: &Controller, s: f64) -> f64 {
    let laps = controller.laps().iter().filter(|lap| lap.result.valid);
    let lap = laps.min_by(|a, b| a.result.lap_time.total_cmp(&b.result.lap_time)).unwrap();
    lap.samples.iter().take_while(|sample| sample.x.s <= s).last().unwrap_or(&lap.samples[0]).x.v_x
}

fn random_poses(car: &CarParams, track: Track, seed: u64) {
    let mut racer = Racer::new(car, track, 4);
    let (state, steps) = (racer.controller.state(), racer.steps);
    let track = Arc::clone(racer.controller.track());
    let mut rng = Pcg64Mcg::seed_from_u64(seed);
    let mut between = |from: f64, to: f64| from + (to - from) * rng.random::<f64>();
    for n in 0..count() {
        let s = between(0.0, track.length());
        let half = 0.5 * car.width;
        let e_y = between(half - track.width_right(s), track.width_left(s) - half);
        // Straight enough to race on is no incident.
        let e_psi = between(0.7, 150_f64.to_radians()).copysign(between(-1.0, 1.0));
        let v_x = between(0.0, 0.5) * local_speed(&racer.controller, s);
        let x = State { v_x, e_psi, s, e_y, ..State::default() };
        racer.put(&state, steps, x);
        let recovering = racer.races_again(&format!("{} pose {n} {x:?}", track.name()));
        assert!(recovering > 0, "{} pose {n} {x:?}: nothing happened", track.name());
    }
}

/// A car that stands where it was fast before drives on to the speed it had there: its plan does not wait for
/// an end that it cannot reach.
#[test]
fn a_car_that_stands_on_a_straight_drives_on() {
    let car = CarParams::builtin("f1tenth").unwrap();
    let mut racer = Racer::new(&car, Track::builtin("l").unwrap(), 8);
    let (state, steps) = (racer.controller.state(), racer.steps);
    let length = racer.controller.track().length();
    for n in 0..10 {
        let s = length * f64::from(n) / 10.0;
        racer.put(&state, steps, State { v_x: 0.05, s, ..State::default() });
        let began = racer.steps;
        let fast = |racer: &Racer| {
            let x = racer.plant.truth();
            x.v_x > 0.7 * local_speed(&racer.controller, racer.controller.track().wrap(x.s))
        };
        while !fast(&racer) {
            racer.step();
            let took = f64::from(racer.steps - began) * racer.period;
            assert!(took < 5.0, "from {s}: {:?}", racer.plant.truth());
        }
    }
}

fn barc() -> CarParams {
    CarParams::builtin("barc").unwrap()
}

#[test]
fn from_random_poses_on_the_l_track() {
    random_poses(&barc(), Track::builtin("l").unwrap(), 1);
}

#[test]
fn from_random_poses_on_a_random_track() {
    random_poses(&barc(), vehicle_model::track::random(7, &barc()).unwrap(), 2);
}

#[test]
fn from_random_poses_with_a_kart() {
    let kart = CarParams::builtin("kart").unwrap();
    random_poses(&kart, vehicle_model::track::random(3, &kart).unwrap(), 3);
}

#[test]
fn after_forced_spins() {
    let mut racer = Racer::new(&barc(), Track::builtin("l").unwrap(), 6);
    let mut rng = Pcg64Mcg::seed_from_u64(5);
    let mut spins = 0;
    for n in 0..count() {
        let (state, steps) = (racer.controller.state(), racer.steps);
        for _ in 0..rng.random_range(5..40) {
            racer.step();
        }
        // What hits the rear wheels: the car keeps its course and turns.
        let x = racer.plant.truth();
        let omega_z = 18.0_f64.copysign(rng.random::<f64>() - 0.5);
        racer.plant.reset(State { omega_z, ..x });
        spins += usize::from(racer.races_again(&format!("spin {n} from {x:?}")) > 0);
        racer.put(&state, steps, State { v_x: 1.0, ..State::default() });
    }
    assert!(2 * spins > count(), "{spins} spins");
}
