//! The speed cap changed while driving: like a controller built with that cap that took over.

use controller::{Config, Controller, LapKind, Measurement, Pose};
use vehicle_model::{CarParams, Plant, PlantParams, State, Track};

#[test]
fn a_cap_set_while_driving_is_that_of_a_configuration() {
    let mut config = Config::default();
    config.warm_up.laps = 1;
    let car = CarParams::builtin("barc").unwrap();
    let track = std::sync::Arc::new(Track::builtin("l").unwrap());
    let period = config.horizon.period;
    let start = State { v_x: config.warm_up.speed, ..State::default() };
    let mut plant = Plant::new(PlantParams::new(car.clone()), track.clone(), start).unwrap();
    let mut one = Controller::new(config.clone(), car.clone(), track.clone()).unwrap();
    let mut other = Controller::new(config.clone(), car.clone(), track.clone()).unwrap();
    let mut fastest = [0.0_f64; 2];
    let learned = one.save();
    for n in 0..400_u32 {
        if [200, 300].contains(&n) {
            let cap = if n == 200 { 1.2 } else { 0.0 };
            one.set_speed_cap(cap).unwrap();
            config.limits.speed_cap = cap;
            let mut next = Controller::new(config.clone(), car.clone(), track.clone()).unwrap();
            next.resume(&other.state());
            other = next;
        }
        let time = f64::from(n) * period;
        let state = plant.measure();
        let measurement = Measurement { time, pose: Pose::Frenet(state), applied: None };
        let (a, b) = (one.step(&measurement), other.step(&measurement));
        assert_eq!(a, b, "step {n}");
        if n >= 225 {
            let phase = usize::from(n >= 300);
            fastest[phase] = fastest[phase].max(state.v_x);
        }
        plant.apply(a.input, period);
        one.prepare();
    }
    assert!(fastest[0] < 1.25 && fastest[1] > 1.6, "{fastest:?}");
    assert!(one.laps().iter().any(|lap| lap.result.kind == LapKind::Learning));
    // A cap of the moment is none of the configuration's: the data stay loadable.
    one.set_speed_cap(0.7).unwrap();
    let mut fresh = Controller::new(one.config().clone(), car, track).unwrap();
    fresh.load(&one.save()).unwrap();
    fresh.load(&learned).unwrap();
    for refused in [-1.0, f64::NAN, 1e4] {
        assert!(one.set_speed_cap(refused).is_err());
    }
}
