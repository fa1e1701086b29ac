//! A fall of grip in mid-race: when it is seen, and what the car does.
#![allow(clippy::unwrap_used)]

use std::sync::Arc;

use controller::{Config, Controller, Measurement, Pose, Preset};
use vehicle_model::{
    CarParams, GripChange, Outline, Plant, PlantParams, SensorNoise, State, Track,
};

/// What happened in a race.
struct Race {
    /// Periods from the fall to the first lower share.
    seen: Option<u32>,
    /// Least share before the fall.
    before: f64,
    /// Share in force at the end, and its greatest rise in one period.
    share: f64,
    rise: f64,
    stayed: bool,
}

/// A race of the small car whose grip is `factor` from `fall` on, until `end` \[s\].
fn race(factor: f64, fall: f64, end: f64, duration: f64) -> Race {
    race_with(SensorNoise::default(), factor, fall, end, duration)
}

/// The same with noise of its measurements.
fn race_with(noise: SensorNoise, factor: f64, fall: f64, end: f64, duration: f64) -> Race {
    let car = CarParams::builtin("barc").unwrap();
    let track = Arc::new(Track::builtin("l").unwrap());
    let nominal = car.clone().with_mu(1.2);
    let config = Config::derived(Preset::Race, &nominal, &track);
    let period = config.horizon.period;
    let mut params = PlantParams::new(car.clone());
    let change = GripChange { factor: [factor; 2], time_s: Some([fall, end]), s_m: None };
    params.disturbance.grip.push(change);
    params.noise = noise;
    let start = State { v_x: config.warm_up.speed, ..State::default() };
    let mut plant = Plant::new(params, Arc::clone(&track), start).unwrap();
    let mut controller = Controller::new(config, nominal, Arc::clone(&track)).unwrap();
    let outline = Outline::new(&car);
    let mut race = Race { seen: None, before: 1.0, share: 1.0, rise: 0.0, stayed: true };
    for n in 0..(duration / period) as u32 {
        let time = f64::from(n) * period;
        let pose = Pose::Frenet(plant.measure());
        let command = controller.step(&Measurement { time, pose, applied: None });
        race.rise = race.rise.max(command.status.road_grip - race.share);
        race.share = command.status.road_grip;
        assert_eq!(race.share, controller.road_grip());
        if time < fall {
            race.before = race.before.min(race.share);
        } else if race.share < 1.0 && race.seen.is_none() {
            race.seen = Some(((time - fall) / period) as u32);
        }
        plant.apply(command.input, period);
        race.stayed &= outline.overhang(&track, &plant.truth()) <= 0.0;
    }
    race
}

#[test]
fn a_fall_is_seen_in_a_bend_at_once_and_the_car_stays_on_the_track() {
    for fall in [126.3, 128.0, 130.4] {
        let race = race(0.7 / 0.9, fall, f64::INFINITY, fall + 20.0);
        assert_eq!(race.before, 1.0, "fall at {fall}: nothing fell before");
        assert!(race.seen.is_some_and(|periods| periods <= 10), "{fall}: {:?}", race.seen);
        assert!((race.share - 0.7 / 0.9).abs() < 0.04, "fall at {fall}: {}", race.share);
        assert!(race.stayed, "fall at {fall}");
    }
}

#[test]
fn grip_that_comes_back_is_given_back_slowly() {
    let race = race(0.8, 126.3, 136.3, 175.0);
    assert!(race.seen.is_some());
    assert!(race.share > 0.85, "{}", race.share);
    assert!(race.rise > 0.0 && race.rise < 0.0101, "{}", race.rise);
}

/// What is fitted among noise must not make up for a share that is no more: the car would stay slow.
#[test]
fn grip_that_comes_back_among_noise_is_given_back_whole() {
    let race = race_with(SensorNoise::laboratory(), 0.75, 126.3, 131.3, 200.0);
    assert!(race.seen.is_some());
    assert!(race.share > 0.97, "{}", race.share);
    assert!(race.rise > 0.0 && race.rise < 0.0101, "{}", race.rise);
}

#[test]
fn laps_after_a_fall_in_the_first_learned_ones_tell_the_share() {
    for fall in [80.0, 81.0] {
        let race = race(0.6, fall, f64::INFINITY, fall + 75.0);
        assert!(race.seen.is_some(), "fall at {fall}");
        assert!((race.share - 0.6).abs() < 0.02, "fall at {fall}: {}", race.share);
        assert!(race.rise < 0.0101, "fall at {fall}: {}", race.rise);
    }
}
