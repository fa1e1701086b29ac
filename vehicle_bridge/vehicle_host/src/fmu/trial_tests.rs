//! A simulated car behind maps with wrong senses, units and zeros.
#![allow(clippy::unwrap_used, reason = "code of tests")]

use std::convert::Infallible;
use std::f64::consts::FRAC_PI_2;
use std::sync::Arc;

use vehicle_model::{Plant, PlantParams, State, Track};

use super::*;

/// A simulated car whose measurements and inputs are read wrongly: times, plus.
struct Wrong {
    plant: Plant,
    input: [f64; 2],
    state: [(f64, f64); 6],
    /// Measurements change only every so many steps. \[-\]
    every: u32,
    count: u32,
    last: [f64; 6],
}

impl Wrong {
    fn new(change: impl FnOnce(&mut CarParams)) -> Self {
        let mut car = CarParams::builtin("barc").unwrap();
        change(&mut car);
        // Wide enough to turn on.
        let track = Arc::new(Track::builtin("l").unwrap());
        let start = State { v_x: 1.0, ..State::default() };
        let plant = Plant::new(PlantParams::new(car), track, start).unwrap();
        let (input, state) = ([1.0; 2], [(1.0, 0.0); 6]);
        Self { plant, input, state, every: 1, count: 0, last: [0.0; 6] }
    }
}

impl TrialCar for Wrong {
    type Error = Infallible;

    fn drive(&mut self, u: Input, dt: f64) -> Result<[f64; 6], Infallible> {
        let u = Input { a: self.input[0] * u.a, delta: self.input[1] * u.delta };
        self.plant.apply(u, dt);
        if self.count.is_multiple_of(self.every) {
            let g = self.plant.global();
            let mut q = [g.v_x, g.v_y, g.omega_z, g.x, g.y, g.psi];
            for (value, (factor, offset)) in q.iter_mut().zip(self.state) {
                *value = factor * *value + offset;
            }
            self.last = q;
        }
        self.count += 1;
        Ok(self.last)
    }
}

fn tried(wrong: &mut Wrong) -> Trial {
    let car = CarParams::builtin("barc").unwrap();
    trial(wrong, &car, 0.01).unwrap()
}

/// Factor and offset found of a quantity.
fn found(trial: &Trial, quantity: &str) -> (f64, f64) {
    let finding = trial.findings.iter().find(|f| f.quantity == quantity).unwrap();
    (finding.factor, finding.offset)
}

#[test]
fn a_right_map_stays_as_it_is() {
    let trial = tried(&mut Wrong::new(|_| {}));
    for finding in &trial.findings {
        assert_eq!((finding.factor, finding.offset), (1.0, 0.0), "{finding:?}");
        assert!(finding.sure || finding.quantity == "v_y", "{finding:?}");
    }
    assert!(trial.throttle.delay < 0.02 && trial.throttle.lag < 0.02, "{trial:?}");
    assert!(trial.period <= 0.011, "{trial:?}");
}

#[test]
fn every_wrong_sense_and_unit_is_found_alone_and_together() {
    let degrees = PI / 180.0;
    // Which of the six measurements, what the map makes of it, and what puts it right.
    let states = [
        ("v_x", 0, (3.6, 0.0), (1.0 / 3.6, 0.0)),
        ("v_y", 1, (-1.0, 0.0), (-1.0, 0.0)),
        ("omega_z", 2, (-1.0 / degrees, 0.0), (-degrees, 0.0)),
        // Clockwise from north.
        ("psi", 5, (-1.0, FRAC_PI_2), (-1.0, FRAC_PI_2)),
    ];
    let near = |trial: &Trial, quantity: &str, right: (f64, f64)| {
        let (factor, offset) = found(trial, quantity);
        let off = (factor - right.0).abs().max(wrap_angle(offset - right.1).abs());
        assert!(off < 1e-9, "{quantity}: {:?}", trial.findings);
    };
    let mut all = Wrong::new(|_| {});
    for (quantity, place, wrong, right) in states {
        let mut one = Wrong::new(|_| {});
        (one.state[place], all.state[place]) = (wrong, wrong);
        near(&tried(&mut one), quantity, right);
    }
    // Named in km/h, but in m/s.
    let mut named = Wrong::new(|_| {});
    named.state[0] = (1.0 / 3.6, 0.0);
    near(&tried(&mut named), "v_x", (3.6, 0.0));
    let trial = tried(&mut all);
    for (quantity, _, _, right) in states {
        near(&trial, quantity, right);
    }
    for (quantity, place, wrong) in
        [("a", 0, -1.0), ("a", 0, 9.806_65), ("delta", 1, -1.0), ("delta", 1, degrees)]
    {
        let mut one = Wrong::new(|car| (car.a_max, car.a_min) = (30.0, -30.0));
        one.input[place] = wrong;
        if wrong == degrees {
            // A turn too small to see is named, not guessed.
            let car = CarParams::builtin("barc").unwrap();
            let turned = super::trial(&mut one, &car, 0.01);
            if let Ok(trial) = turned {
                near(&trial, quantity, (wrong, 0.0));
            }
            continue;
        }
        near(&tried(&mut one), quantity, (wrong, 0.0));
    }
}

#[test]
fn all_senses_at_once_may_be_a_mirrored_world() {
    let mut mirrored = Wrong::new(|_| {});
    mirrored.state[4] = (-1.0, 0.0);
    let trial = tried(&mut mirrored);
    for quantity in ["delta", "omega_z", "psi"] {
        let finding = trial.findings.iter().find(|f| f.quantity == quantity).unwrap();
        assert!(!finding.sure && finding.note.contains("mirrored"), "{finding:?}");
    }
}

#[test]
fn delay_lag_and_period_are_measured() {
    let mut slow = Wrong::new(|car| (car.actuator_delay, car.actuator_lag) = (0.1, 0.2));
    let trial = tried(&mut slow);
    let Response { delay, lag } = trial.throttle;
    assert!((delay - 0.1).abs() < 0.03 && (lag - 0.2).abs() < 0.04, "{trial:?}");
    let mut seldom = Wrong::new(|_| {});
    seldom.every = 5;
    assert!((tried(&mut seldom).period - 0.05).abs() < 0.006);
}

#[test]
fn a_car_that_does_not_move_is_named() {
    let mut still = Wrong::new(|_| {});
    still.plant.reset(State::default());
    still.input = [0.0; 2];
    let car = CarParams::builtin("barc").unwrap();
    let error = trial(&mut still, &car, 0.01).unwrap_err();
    assert!(matches!(error, TrialError::Still { .. }), "{error}");
}
