//! The tracker of the initial laps on the simulated car.
#![allow(clippy::unwrap_used)]

use std::sync::Arc;

use vehicle_model::{CarParams, Plant, PlantParams, State, Track, Tracker};

/// Greatest distance from the centre line in a lap after the first quarter \[m\].
fn astray(car: &CarParams, known: &CarParams, track: &Arc<Track>, v: f64, dt: f64) -> f64 {
    let start = State { v_x: v, ..State::default() };
    let mut plant = Plant::new(PlantParams::new(car.clone()), Arc::clone(track), start).unwrap();
    let tracker = Tracker::new(known);
    let mut worst: f64 = 0.0;
    while plant.progress() < 1.25 * track.length() {
        let x = plant.measure();
        plant.apply(tracker.track(&x, track, v), dt);
        if plant.progress() > 0.25 * track.length() {
            worst = worst.max(plant.truth().e_y.abs());
        }
    }
    worst
}

#[test]
fn steady_bends_do_not_lead_the_car_away_from_the_centre_line() {
    let track = Arc::new(Track::builtin("l").unwrap());
    let half = track.width_left(0.0);
    for name in ["barc", "f1tenth"] {
        let car = CarParams::builtin(name).unwrap();
        let off = astray(&car, &car, &track, 1.1, 0.1);
        assert!(off < 0.06 * half, "{name}: {off} m");
        // With another grip than known, what is left is for the feedback.
        let slippery = car.clone().with_mu(0.75 * car.tyre_front.mu);
        let off = astray(&slippery, &car, &track, 1.1, 0.1);
        assert!(off < 0.15 * half, "{name} on a slippery road: {off} m");
    }
}
