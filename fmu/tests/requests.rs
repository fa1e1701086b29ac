//! The controller FMU's requests, driven in both versions of FMI: the car stops on the track, stands,
//! and races on; a spun car recovers only with leave.
#![allow(clippy::unwrap_used, clippy::panic)]

mod slave;

use std::sync::Arc;

use fmu_core::{ControllerFmu, Version};
use slave::{COMMAND, STATE, Set, Slave, VERSIONS};
use vehicle_model::{CarParams, Input, Plant, PlantParams, State, Track};

/// Codes of `status.action`.
const LEARNED: f64 = 1.0;
const BRAKING: f64 = 4.0;
const RECOVERING: f64 = 5.0;

/// A controller FMU and a car that it drives, in lock-step.
struct Drive {
    controller: Slave<ControllerFmu>,
    plant: Plant,
    period: f64,
    steps: u32,
    /// Farthest the centre of gravity was beyond an edge; negative inside.
    beyond: f64,
}

impl Drive {
    fn new(version: Version, more: &[Set<'_>]) -> Self {
        Self::of(version, ["barc", "l"], more)
    }

    fn of(version: Version, [car, track]: [&str; 2], more: &[Set<'_>]) -> Self {
        let mut settings = vec![Set::Text("param.car", car), Set::Text("param.track", track)];
        settings.push(Set::Number("param.warm_up.laps", 1.0));
        settings.extend_from_slice(more);
        let controller = Slave::with(version, &settings);
        let [v_x, period] = controller.all(["param.warm_up.speed", "param.period"]);
        let params = PlantParams::new(CarParams::builtin(car).unwrap());
        let track = Arc::new(Track::builtin(track).unwrap());
        let plant = Plant::new(params, track, State { v_x, ..State::default() }).unwrap();
        Self { controller, plant, period, steps: 0, beyond: f64::NEG_INFINITY }
    }

    fn step(&mut self) {
        let x = self.plant.measure();
        let all = [x.v_x, x.v_y, x.omega_z, x.e_psi, x.s, x.e_y];
        self.controller.set_all(STATE, all);
        let pose = self.plant.track().to_global(&x);
        self.controller
            .set_all(["vehicle.x", "vehicle.y", "vehicle.psi"], [pose.x, pose.y, pose.psi]);
        let period = self.period;
        let status = self.controller.step(f64::from(self.steps) * period, period);
        assert!(status <= 1, "step {}: {:?}", self.steps, self.controller.log());
        let [a, delta] = self.controller.all(COMMAND);
        self.plant.apply(Input { a, delta }, period);
        self.steps += 1;
        let (x, track) = (self.plant.truth(), self.plant.track());
        let beyond = (x.e_y - track.width_left(x.s)).max(-x.e_y - track.width_right(x.s));
        self.beyond = self.beyond.max(beyond);
    }

    fn seconds(&mut self, time: f64) {
        for _ in 0..(time / self.period).round() as usize {
            self.step();
        }
    }

    /// Drives until so many laps are finished.
    fn laps(&mut self, count: f64) {
        let from = self.steps;
        while self.controller.get("lap.finished") < count {
            self.step();
            assert!(self.steps - from < 9000, "{:?}", self.plant.truth());
        }
    }

    fn request(&self) -> f64 {
        self.controller.get("status.request")
    }
}

#[test]
fn a_stop_ends_on_the_track_and_racing_goes_on_when_it_is_over() {
    for version in VERSIONS {
        let mut drive = Drive::new(version, &[]);
        // Learned laps, and places all around the track; in the third round on a straight at speed.
        for (laps, more) in [(4.0, 0.7), (7.0, 2.0), (10.0, 3.1)] {
            drive.laps(laps);
            drive.seconds(more);
            let speed = drive.plant.truth().v_x;
            assert!(speed > 1.4, "{speed} m/s");
            assert_eq!(drive.controller.get("status.action"), LEARNED);
            assert_eq!(drive.request(), 0.0);
            drive.controller.set("request.stop", 1.0);
            drive.step();
            assert_eq!([drive.request(), drive.controller.get("status.action")], [1.0, BRAKING]);
            drive.seconds(5.0);
            let (stood, lap) = (drive.plant.truth(), drive.controller.get("lap.finished"));
            assert_eq!(drive.request(), 2.0);
            assert!(stood.v_x.abs() < 0.02, "{stood:?}");
            drive.seconds(20.0);
            let stands = drive.plant.truth();
            assert!((stands.s - stood.s).abs() < 0.02, "{stood:?}, later {stands:?}");
            assert_eq!(drive.controller.get("lap.finished"), lap);
            drive.controller.set("request.stop", 0.0);
            drive.seconds(3.0);
            assert_eq!(drive.request(), 0.0);
            assert!(drive.plant.truth().v_x > 1.0, "{:?}", drive.plant.truth());
            // The lap with the stop counts for nothing, the one after it is raced.
            drive.laps(lap + 1.0);
            assert_eq!(drive.controller.get("lap.last_valid"), 0.0);
            drive.laps(lap + 2.0);
            assert_eq!(drive.controller.get("lap.last_valid"), 1.0);
            let [last, best] = drive.controller.all(["lap.last_time", "lap.best_time"]);
            assert!(last < 1.15 * best, "{last} s after {best} s");
            assert!(drive.beyond < 0.0, "{} m beyond an edge", drive.beyond);
        }
    }
}

/// Fast cars go farther in the time of a stop than the controller takes for one way. Their poses are
/// global ones; the switch is a fixed parameter.
#[test]
fn a_fast_car_stops_too() {
    for version in VERSIONS {
        let mut drive =
            Drive::of(version, ["kart", "road_course"], &[Set::Switch("param.global_pose")]);
        drive.laps(3.0);
        for wait in [6.0, 14.0] {
            drive.seconds(wait);
            let speed = drive.plant.truth().v_x;
            drive.controller.set("request.stop", 1.0);
            let (mut steps, lap) = (0, drive.controller.get("lap.finished"));
            while drive.request() < 2.0 {
                drive.step();
                steps += 1;
                assert!(steps < 200, "from {speed} m/s: {:?}", drive.plant.truth());
            }
            drive.controller.set("request.stop", 0.0);
            drive.laps(lap + 2.0);
            assert_eq!(drive.controller.get("lap.last_valid"), 1.0, "from {speed} m/s");
            assert!(drive.beyond < 0.0, "from {speed} m/s: {} m beyond an edge", drive.beyond);
        }
    }
}

#[test]
fn a_stop_taken_back_ends_at_a_stand_and_one_in_an_initial_lap_is_no_harm() {
    for version in VERSIONS {
        let mut drive = Drive::new(version, &[]);
        drive.seconds(6.0);
        drive.controller.set("request.stop", 1.0);
        drive.step();
        drive.controller.set("request.stop", 0.0);
        let (mut slowest, mut steps) = (f64::INFINITY, 0);
        while drive.request() > 0.0 {
            drive.step();
            slowest = slowest.min(drive.plant.truth().v_x);
            steps += 1;
            assert!(steps < 100, "{:?}", drive.plant.truth());
        }
        assert!(slowest < 0.12, "{slowest} m/s");
        drive.laps(5.0);
        assert_eq!(drive.controller.get("status.action"), LEARNED);
        assert!(drive.controller.get("lap.best_time") < 9.0);
        assert!(drive.beyond < 0.0, "{} m beyond an edge", drive.beyond);
    }
}

#[test]
fn a_stop_goes_on_in_a_new_instance_from_its_bytes() {
    for version in VERSIONS {
        let mut drive = Drive::new(version, &[]);
        drive.laps(3.0);
        drive.controller.set("request.stop", 1.0);
        drive.seconds(0.3);
        let revived = Slave::instantiate(version);
        assert_eq!(revived.revive(&drive.controller.bytes()), 0, "{:?}", revived.log());
        let mut other = Drive { controller: revived, plant: drive.plant.clone(), ..drive };
        other.steps = drive.steps;
        let mut first = Drive { controller: drive.controller, plant: drive.plant, ..other };
        first.steps = other.steps;
        for k in 0..120 {
            for drive in [&mut first, &mut other] {
                if k == 60 {
                    drive.controller.set("request.stop", 0.0);
                }
                drive.step();
            }
            assert_eq!(first.controller.all(COMMAND), other.controller.all(COMMAND), "step {k}");
            assert_eq!(first.request(), other.request(), "step {k}");
        }
        assert_eq!(first.request(), 0.0);
    }
}

#[test]
fn a_spun_car_recovers_only_with_leave() {
    for version in VERSIONS {
        let mut drive = Drive::new(version, &[Set::Number("param.recovery.mode", 2.0)]);
        drive.laps(8.0);
        drive.seconds(1.0);
        // It points back and stands, half-way to the edge.
        let x = drive.plant.truth();
        drive.plant.reset(State { s: x.s, e_y: 0.2, e_psi: 2.5, ..State::default() });
        drive.seconds(8.0);
        let spun = drive.plant.truth();
        assert_eq!(drive.controller.get("status.action"), BRAKING);
        assert!(spun.v_x.abs() < 0.02 && spun.e_psi > 2.0, "{spun:?}");
        assert_eq!([drive.request(), drive.controller.get("status.recovering")], [0.0; 2]);
        // A pulse of one period is enough: what began is finished.
        drive.controller.set("request.recover", 1.0);
        drive.step();
        assert_eq!([drive.request(), drive.controller.get("status.action")], [3.0, RECOVERING]);
        drive.controller.set("request.recover", 0.0);
        let lap = drive.controller.get("lap.finished");
        while drive.request() > 0.0 {
            assert_eq!(drive.controller.get("status.action"), RECOVERING);
            drive.step();
            assert!(drive.steps < 2000, "{:?}", drive.plant.truth());
        }
        let back = drive.plant.truth();
        assert!(back.e_psi.abs() < 0.5 && back.v_x > 0.3, "{back:?}");
        drive.laps(lap + 2.0);
        assert_eq!(drive.controller.get("lap.last_valid"), 1.0);
        let [last, best] = drive.controller.all(["lap.last_time", "lap.best_time"]);
        assert!(last < 1.15 * best, "{last} s after {best} s");
        // The leave is over; the parameter gives it for good.
        drive.plant.reset(State { s: 1.0, e_psi: 2.5, ..State::default() });
        drive.seconds(8.0);
        assert_eq!(drive.controller.get("status.action"), BRAKING);
        assert!(drive.plant.truth().e_psi > 2.0);
        drive.controller.set("param.recovery.mode", 1.0);
        drive.step();
        assert_eq!([drive.request(), drive.controller.get("status.action")], [0.0, RECOVERING]);
    }
}
