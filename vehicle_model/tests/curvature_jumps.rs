//! A step across a jump of the curvature against the heading, which does not know the centre line.
#![allow(clippy::unwrap_used, reason = "code of tests")]

use std::f64::consts::PI;

use vehicle_model::{
    CarParams, Discretized, Input, Model, ModelKind, Plant, PlantParams, RoadPoint, State, Track,
};

/// Greatest change of the heading beyond what the yaw rate turns, over steps that begin at places around
/// every jump of the curvature \[rad\].
fn greatest_kick(car: &str, speed: f64, step: impl Fn(&State, &Input, &Track) -> State) -> f64 {
    let track = Track::builtin("l").unwrap();
    let model = Model::new(ModelKind::Dynamic, CarParams::builtin(car).unwrap());
    let straight = Discretized { model, dt: 0.1, substeps: 100 };
    let mut greatest = 0.0_f64;
    for jump in track.curvature_jumps() {
        for (i, e_y) in (0..40_u32).flat_map(|i| [-0.3, 0.1, 0.3].map(|e_y| (i, e_y))) {
            let s = jump - 0.1 * speed * f64::from(i) / 40.0;
            let x = State { v_x: speed, v_y: 0.02, omega_z: 0.8, e_psi: -0.2, s, e_y };
            let u = Input { a: -1.0, delta: 0.1 };
            let turned = straight.next(&x, &u, RoadPoint::flat(0.0)).e_psi - x.e_psi;
            let next = step(&x, &u, &track);
            let heading = |x: &State| track.heading(track.wrap(x.s)) + x.e_psi;
            let kick = heading(&next) - heading(&x) - turned;
            greatest = greatest.max((kick - 2.0 * PI * (kick / (2.0 * PI)).round()).abs());
        }
    }
    greatest
}

/// Without the mean curvature of a step it would be 0.01, without the place beside the centre line 0.005.
const MOST: f64 = 3e-4;

#[test]
fn the_models_step_turns_the_car_by_its_yaw_rate_alone() {
    let model = Model::new(ModelKind::Dynamic, CarParams::builtin("barc").unwrap());
    let step = Discretized { model, dt: 0.1, substeps: 10 };
    let kick = greatest_kick("barc", 3.0, |x, u, track| step.next(x, u, track.road()));
    assert!(kick < MOST, "{kick}");
}

#[test]
fn the_plant_turns_the_car_by_its_yaw_rate_alone() {
    let kick = greatest_kick("barc", 3.0, |x, u, track| {
        let params = PlantParams::new(CarParams::builtin("barc").unwrap());
        let start = State { s: track.wrap(x.s), ..*x };
        let mut plant = Plant::new(params, track.clone().into(), start).unwrap();
        plant.apply(*u, 0.1);
        plant.truth()
    });
    assert!(kick < MOST, "{kick}");
}

/// The Jacobians by s and by the velocities against differences of the step, with the change of the bend
/// anywhere in it.
#[test]
fn a_linearised_step_follows_the_bend() {
    const H: f64 = 1e-3;
    let model = Model::new(ModelKind::Dynamic, CarParams::builtin("barc").unwrap());
    let step = Discretized { model, dt: 0.1, substeps: 50 };
    let track = Track::builtin("l").unwrap();
    let u = Input { a: -1.0, delta: 0.1 };
    let (mut apart, mut frozen) = (0.0_f64, 0.0_f64);
    let jumps: Vec<f64> = track.curvature_jumps();
    for jump in &jumps {
        for i in 1..10_u32 {
            let s = jump - 0.3 * f64::from(i) / 10.0;
            // Of two changes in one step only their sum is followed.
            if jumps.iter().filter(|other| (s - 0.1..s + 0.5).contains(other)).count() > 1 {
                continue;
            }
            let x = State { v_x: 3.0, v_y: 0.02, omega_z: 0.8, e_psi: 0.05, s, e_y: 0.1 };
            let without = step.linearize(&x, &u, track.road());
            let mut found = without;
            step.follow_bend(&x, &track.road(), 0.0, &mut found);
            for j in [0, 1, 3, 4, 5] {
                let shifted = |h: f64| {
                    let mut x = x.to_vector();
                    x[j] += h;
                    step.next(&State::from_vector(&x), &u, track.road()).to_vector()
                };
                let difference = (shifted(H) - shifted(-H)) / (2.0 * H);
                let largest = |a: nalgebra::Vector6<f64>| (a - difference).amax();
                apart = apart.max(largest(found.a.column(j).into_owned()));
                frozen = frozen.max(largest(without.a.column(j).into_owned()));
            }
        }
    }
    assert!(apart < 0.12 && frozen > 0.9, "{apart}, without the bend {frozen}");
}

/// What a jump adds to the Jacobians fades as the car may be farther away, and is gone where it can be past the
/// next bend.
#[test]
fn a_bend_is_followed_as_far_as_the_plan_stays_near_it() {
    let model = Model::new(ModelKind::Dynamic, CarParams::builtin("barc").unwrap());
    let step = Discretized { model, dt: 0.1, substeps: 10 };
    let track = Track::builtin("l").unwrap();
    let s = track.curvature_jumps()[0] - 0.15;
    let (x, u) = (State { v_x: 3.0, s, ..State::default() }, Input::default());
    let frozen = step.linearize(&x, &u, track.road());
    let added = |far: f64| {
        let mut found = frozen;
        step.follow_bend(&x, &track.road(), far, &mut found);
        (found.a - frozen.a).amax()
    };
    let parts: Vec<f64> = [0.0, 0.1, 1.0, 100.0].into_iter().map(added).collect();
    assert!(parts.windows(2).all(|pair| pair[0] > pair[1]), "{parts:?}");
    assert!(parts[1] > 0.9 * parts[0] && parts[3] < 1e-3 * parts[0], "{parts:?}");
}
