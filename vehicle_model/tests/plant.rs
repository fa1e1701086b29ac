//! The simulated car: parity with the model, actuators, noise, disturbances, saving.

#![allow(clippy::unwrap_used)]

use std::sync::Arc;

use vehicle_model::{
    CarParams, Discretized, Disturbance, GripChange, Input, Model, ModelKind, Plant, PlantParams,
    PlantState, SensorNoise, State, Track,
};

const DT: f64 = 0.1;

fn track() -> Arc<Track> {
    Arc::new(Track::builtin("l").unwrap())
}

fn barc() -> CarParams {
    CarParams::builtin("barc").unwrap()
}

fn start() -> State {
    State { v_x: 1.5, ..State::default() }
}

fn plant(params: PlantParams) -> Plant {
    Plant::new(params, track(), start()).unwrap()
}

/// A crude driver along the centre line; enough to see corners and the line.
fn drive(x: &State, track: &Track) -> Input {
    let feed_forward = (0.26 * track.kappa(x.s)).atan();
    Input { a: 1.5 - x.v_x, delta: feed_forward - 1.5 * x.e_psi - 2.0 * x.e_y }
}

#[test]
fn plain_plant_is_the_model_bit_for_bit() {
    let track = track();
    let mut plant = plant(PlantParams::new(barc()));
    let step = Discretized { model: Model::new(ModelKind::Dynamic, barc()), dt: DT, substeps: 10 };
    let mut x = start();
    for _ in 0..400 {
        let u = drive(&x, &track);
        let u = Input { a: u.a.clamp(-2.0, 2.0), delta: u.delta.clamp(-0.436, 0.436) };
        plant.apply(u, DT);
        x = step.next(&x, &u, track.road());
        assert_eq!(plant.progress(), x.s);
        assert_eq!(plant.truth(), State { s: track.wrap(x.s), ..x });
        assert_eq!(plant.measure(), plant.truth());
        assert_eq!(plant.applied(), u);
    }
    assert!(plant.lap() >= 2);
    assert_eq!(plant.lap(), (x.s / track.length()).floor() as i64);
    assert!(x.e_y.abs() < 0.3);
    assert!((plant.time() - 40.0).abs() < 1e-9);
}

#[test]
fn short_and_long_calls_agree() {
    let params = PlantParams { substep: 0.001, ..PlantParams::new(barc()) };
    let (mut long, mut short) = (plant(params.clone()), plant(params));
    let u = Input { a: 0.5, delta: 0.15 };
    for _ in 0..5 {
        long.apply(u, DT);
        for _ in 0..100 {
            short.apply(u, 0.001);
        }
    }
    let difference = long.truth().to_vector() - short.truth().to_vector();
    assert!(difference.amax() < 1e-10, "{difference:?}");
}

#[test]
fn the_substep_converges_to_the_same_car() {
    let u = Input { a: 0.5, delta: 0.2 };
    let end = |substep| {
        let mut plant = plant(PlantParams { substep, ..PlantParams::new(barc()) });
        plant.apply(u, 1.0);
        plant.truth().to_vector()
    };
    let fine = end(0.0005);
    let (coarse, medium) = ((end(0.01) - fine).amax(), (end(0.001) - fine).amax());
    assert!(medium < 1e-8 && coarse < 1e-4 && medium < coarse, "{medium:e} {coarse:e}");
}

/// A delay of D seconds is the same command given D later, for any D.
#[test]
fn delay_is_exact_for_any_time() {
    for delay in [0.1, 0.05, 0.0337, 0.2718] {
        let car = CarParams { actuator_delay: delay, ..barc() };
        let mut delayed = plant(PlantParams { substep: 0.001, ..PlantParams::new(car) });
        let mut prompt = plant(PlantParams { substep: 0.001, ..PlantParams::new(barc()) });
        let commands =
            [0.2, -0.1, 0.3, 0.0, 0.1, -0.3].map(|delta| Input { a: 5.0 * delta, delta });
        for u in commands {
            delayed.apply(u, DT);
        }
        // The prompt car waits, then gets the same commands until the same end.
        prompt.apply(Input::default(), delay);
        let mut left = 0.6 - delay;
        for u in commands {
            prompt.apply(u, left.min(DT));
            left = (left - DT).max(0.0);
        }
        let difference = delayed.truth().to_vector() - prompt.truth().to_vector();
        assert!(difference.amax() < 1e-9, "delay {delay}: {difference:?}");
    }
}

#[test]
fn lag_answers_a_step_as_a_first_order_system() {
    let lag = 0.1;
    let car = CarParams { actuator_lag: lag, ..barc() };
    let mut plant = plant(PlantParams { substep: 0.001, ..PlantParams::new(car) });
    for i in 1..=50 {
        plant.apply(Input { a: 1.0, delta: 0.1 }, 0.01);
        let expected = 1.0 - (-f64::from(i) * 0.01 / lag).exp();
        let found = plant.applied();
        // What acted last is the mean over a millisecond.
        assert!((found.a - expected).abs() < 0.006, "{found:?} {expected}");
        assert!((found.delta - 0.1 * expected).abs() < 0.0006);
    }
    // v_x' = a on a straight line: what the lag withheld is its time constant.
    let mut straight = Plant::new(
        PlantParams::new(CarParams { actuator_lag: lag, ..barc() }),
        track(),
        State { v_x: 1.0, ..State::default() },
    )
    .unwrap();
    straight.apply(Input { a: 1.0, delta: 0.0 }, 1.0);
    let expected = 1.0 + 1.0 - lag * (1.0 - (-1.0 / lag).exp());
    assert!((straight.truth().v_x - expected).abs() < 1e-3);
}

#[test]
fn rates_and_limits_hold_and_odd_commands_do_no_harm() {
    let car = CarParams { delta_rate_max: Some(0.66), a_rate_max: Some(10.0), ..barc() };
    let mut plant = plant(PlantParams { substep: 0.001, ..PlantParams::new(car) });
    let mut last = plant.applied();
    for i in 0..60 {
        let sign = if i < 30 { 1.0 } else { -1.0 };
        plant.apply(Input { a: 9.0 * sign, delta: 9.0 * sign }, 0.01);
        let now = plant.applied();
        assert!((now.delta - last.delta).abs() <= 0.66 * 0.01 + 1e-12);
        assert!((now.a - last.a).abs() <= 10.0 * 0.01 + 1e-12);
        assert!(now.a.abs() <= 2.0 && now.delta.abs() <= 0.436);
        last = now;
    }
    let mut plain = Plant::new(PlantParams::new(barc()), track(), start()).unwrap();
    plain.apply(Input { a: 9.0, delta: -9.0 }, DT);
    assert_eq!(plain.applied(), Input { a: 2.0, delta: -0.436 });
    plain.apply(Input { a: f64::NAN, delta: f64::INFINITY }, DT);
    assert_eq!(plain.applied(), Input { a: 2.0, delta: -0.436 });
    let before = plain.truth();
    for dt in [0.0, -1.0, f64::NAN] {
        plain.apply(Input::default(), dt);
    }
    assert_eq!(plain.truth(), before);
}

#[test]
fn brakes_stop_the_car_and_hold_it() {
    for name in CarParams::builtin_names() {
        let car = CarParams::builtin(name).unwrap();
        let brake = Input { a: car.a_min, delta: 0.5 * car.delta_max };
        let start = State { v_x: 0.2, v_y: 0.02, omega_z: 0.1, ..State::default() };
        let mut plant = Plant::new(PlantParams::new(car), track(), start).unwrap();
        for _ in 0..100 {
            plant.apply(brake, DT);
            let x = plant.truth();
            assert!(x.is_finite() && x.v_x >= 0.0, "{name} {x:?}");
        }
        let x = plant.truth();
        assert!(x.v_x < 1e-9 && x.v_y.abs() < 1e-6 && x.omega_z.abs() < 1e-6, "{name} {x:?}");
        // And it drives off again.
        plant.apply(Input { a: plant.params().car.a_max, delta: 0.0 }, 0.5);
        assert!(plant.truth().v_x > 0.1, "{name}");
    }
}

fn noisy(seed: u64) -> PlantParams {
    PlantParams {
        noise: SensorNoise::laboratory(),
        disturbance: Disturbance { process_std: [0.02, 0.02, 0.05], ..Disturbance::default() },
        seed,
        ..PlantParams::new(barc())
    }
}

fn record(plant: &mut Plant, steps: usize) -> Vec<State> {
    let track = plant.track().clone();
    (0..steps)
        .map(|_| {
            let x = plant.measure();
            plant.apply(drive(&x, &track), DT);
            x
        })
        .collect()
}

#[test]
fn a_seed_gives_one_run() {
    let run = |seed| record(&mut plant(noisy(seed)), 100);
    assert_eq!(run(3), run(3));
    assert_ne!(run(3), run(4));
    let mut again = plant(noisy(3));
    record(&mut again, 17);
    again.reset(start());
    assert_eq!(record(&mut again, 100), run(3));
}

#[test]
fn measuring_does_not_change_the_car() {
    let (mut once, mut often) = (plant(noisy(1)), plant(noisy(1)));
    for _ in 0..50 {
        let _ = often.measure();
        let u = Input { a: 0.1, delta: 0.05 };
        once.apply(u, DT);
        often.apply(u, DT);
        assert_eq!(once.truth(), often.truth());
    }
}

#[test]
fn noise_has_its_deviation() {
    let mut plant = plant(noisy(5));
    let n = 20_000;
    let truth = plant.truth();
    let track = plant.track().clone();
    let mut squares = [0.0; 6];
    for _ in 0..n {
        let error = plant.measure().to_vector() - truth.to_vector();
        for (i, square) in squares.iter_mut().enumerate() {
            // Around the line s may be measured at the end of the lap before.
            let e = if i == 4 && error[4] > 1.0 { error[4] - track.length() } else { error[i] };
            *square += e * e / f64::from(n);
        }
    }
    for (square, std) in squares.iter().zip([0.01, 0.01, 0.01, 1e-3, 1e-3, 1e-3]) {
        assert!((square.sqrt() / std - 1.0).abs() < 0.03, "{square} {std}");
    }
}

#[test]
fn process_noise_has_its_deviation_and_its_clip() {
    let mut shaken = plant(PlantParams { noise: SensorNoise::default(), ..noisy(9) });
    let mut calm = plant(PlantParams::new(barc()));
    let (n, mut square, mut most) = (4000, 0.0, 0.0_f64);
    for _ in 0..n {
        let u = drive(&shaken.truth(), shaken.track());
        calm.reset(shaken.truth());
        shaken.apply(u, DT);
        calm.apply(u, DT);
        let kick = shaken.truth().v_x - calm.truth().v_x;
        square += kick * kick / f64::from(n);
        most = most.max(kick.abs());
    }
    assert!((square.sqrt() / 0.02 - 1.0).abs() < 0.05, "{}", square.sqrt());
    assert!(most <= 0.06 + 1e-12 && most > 0.05);
}

#[test]
fn grip_changes_in_its_windows() {
    let change = |time_s, s_m| Disturbance {
        grip: vec![GripChange { factor: [0.5, 0.7], time_s, s_m }],
        ..Disturbance::default()
    };
    let forces = |disturbance, s, wait: f64| {
        let params = PlantParams { disturbance, ..PlantParams::new(barc()) };
        let mut plant = Plant::new(params, track(), State { s, ..start() }).unwrap();
        plant.apply(Input { a: 0.0, delta: 0.1 }, wait);
        let tyres = plant.tyres();
        let peak = |i: usize| tyres.lateral[i] / ((5.0 * tyres.slip[i]).atan() * 2.28).sin();
        [peak(0), peak(1)].map(|peak| peak / (0.9 * 0.5 * 2.2187 * 9.81))
    };
    let close = |found: [f64; 2], expected: [f64; 2]| {
        assert!(
            (found[0] - expected[0]).abs() < 1e-9 && (found[1] - expected[1]).abs() < 1e-9,
            "{found:?} {expected:?}"
        );
    };
    close(forces(change(None, None), 0.0, 0.1), [0.5, 0.7]);
    close(forces(change(Some([0.2, 9.0]), None), 0.0, 0.1), [1.0, 1.0]);
    close(forces(change(Some([0.2, 9.0]), None), 0.0, 0.3), [0.5, 0.7]);
    close(forces(change(None, Some([5.0, 6.0])), 5.3, 0.1), [0.5, 0.7]);
    close(forces(change(None, Some([5.0, 6.0])), 6.3, 0.1), [1.0, 1.0]);
    // A window across the line.
    close(forces(change(None, Some([17.0, 0.5])), 17.2, 0.1), [0.5, 0.7]);
    close(forces(change(None, Some([17.0, 0.5])), 0.1, 0.1), [0.5, 0.7]);
    close(forces(change(None, Some([17.0, 0.5])), 1.0, 0.1), [1.0, 1.0]);
}

#[test]
fn wind_pushes_in_its_direction() {
    let pushed = |disturbance| {
        let params = PlantParams { disturbance, ..PlantParams::new(barc()) };
        let mut plant = Plant::new(params, track(), start()).unwrap();
        plant.apply(Input::default(), 0.01);
        plant.truth()
    };
    // The L track starts along X: a wind along X and a push forward are the same.
    let body = Disturbance { force_body_n: [0.5, 0.0], ..Disturbance::default() };
    let wind = Disturbance { force_global_n: [0.5, 0.0], ..Disturbance::default() };
    assert!((pushed(body).v_x - (1.5 + 0.01 * 0.5 / 2.2187)).abs() < 1e-9);
    assert!((pushed(wind).v_x - (1.5 + 0.01 * 0.5 / 2.2187)).abs() < 1e-9);
    let side = Disturbance { force_global_n: [0.0, 0.5], ..Disturbance::default() };
    assert!(pushed(side).v_y > 0.0);
}

#[test]
fn utilisation_is_one_at_the_peak_slip() {
    let mut plant = plant(PlantParams::new(barc()));
    let peak = barc().tyre_front.peak_slip();
    plant.apply(Input { a: 0.0, delta: peak }, 1e-9);
    let tyres = plant.tyres();
    assert!((tyres.slip[0] - peak).abs() < 1e-6);
    assert!((plant.utilisation()[0] - 1.0).abs() < 1e-6);
    assert!(plant.utilisation()[1] < 1e-3);
}

#[test]
fn a_saved_plant_goes_on_as_if_nothing_happened() {
    let mut params = noisy(11);
    params.car.actuator_delay = 0.137;
    params.car.actuator_lag = 0.05;
    let mut first = plant(params.clone());
    record(&mut first, 60);
    let text = serde_json::to_string(first.state()).unwrap();
    let saved: PlantState = serde_json::from_str(&text).unwrap();
    let mut second = plant(params);
    second.restore(saved);
    assert_eq!(record(&mut first, 60), record(&mut second, 60));
    assert_eq!(first.state(), second.state());
    let text = serde_json::to_string(first.params()).unwrap();
    assert_eq!(&serde_json::from_str::<PlantParams>(&text).unwrap(), first.params());
}

#[test]
fn bad_parameters_are_refused_together() {
    let mut params = noisy(0);
    params.substep = 0.0;
    params.noise.v_y = -1.0;
    params.disturbance.process_std[2] = f64::NAN;
    params.car.mass = 0.0;
    let message = Plant::new(params, track(), start()).unwrap_err().to_string();
    for key in
        ["mass_kg", "plant.substep_s", "plant.noise.v_y_mps", "plant.disturbance.process_std"]
    {
        assert!(message.contains(key), "{key} is not in: {message}");
    }
    let lost = State { e_y: f64::NAN, ..start() };
    assert!(Plant::new(PlantParams::new(barc()), track(), lost).is_err());
}
