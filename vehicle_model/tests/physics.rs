//! Signs, balances and limits of the models.

#![allow(clippy::unwrap_used)]

use vehicle_model::{
    CarParams, Discretized, Input, Model, ModelKind, SlipAngles, State, params::GRAVITY,
};

fn barc() -> CarParams {
    CarParams::builtin("barc").unwrap()
}

fn dynamic(car: CarParams) -> Model {
    Model::new(ModelKind::Dynamic, car)
}

/// A thousand states from a fixed linear congruence, spread over the range of a race car.
fn states() -> impl Iterator<Item = (State, Input, f64)> {
    let mut seed = 12345_u64;
    let mut uniform = move |low: f64, high: f64| {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        low + (high - low) * (seed >> 11) as f64 / (1_u64 << 53) as f64
    };
    std::iter::repeat_with(move || {
        let x = State {
            v_x: uniform(0.9, 4.5),
            v_y: uniform(-0.8, 0.8),
            omega_z: uniform(-4.0, 4.0),
            e_psi: uniform(-0.8, 0.8),
            s: uniform(0.0, 17.0),
            e_y: uniform(-0.5, 0.5),
        };
        (x, Input { a: uniform(-2.0, 2.0), delta: uniform(-0.43, 0.43) }, uniform(-0.9, 0.9))
    })
    .take(1000)
}

/// The plain single-track equations, written out a second time as a paper prints them.
fn printed_equations(car: &CarParams, x: &State, u: &Input, kappa: f64) -> [f64; 6] {
    let State { v_x, v_y, omega_z, e_psi, e_y, .. } = *x;
    let (m, l) = (car.mass, car.l_f + car.l_r);
    let alpha_f = u.delta - ((v_y + omega_z * car.l_f) * (1.0 / v_x)).atan();
    let alpha_r = -((v_y - omega_z * car.l_r) * (1.0 / v_x)).atan();
    let peak_f = m * GRAVITY * (car.l_r / l) * car.tyre_front.mu;
    let peak_r = m * GRAVITY * (car.l_f / l) * car.tyre_rear.mu;
    let f_f = peak_f * ((alpha_f * car.tyre_front.b).atan() * car.tyre_front.c).sin();
    let f_r = peak_r * ((alpha_r * car.tyre_rear.b).atan() * car.tyre_rear.c).sin();
    let (sin, cos) = u.delta.sin_cos();
    let (sin_psi, cos_psi) = e_psi.sin_cos();
    let s_dot = (v_x * cos_psi - v_y * sin_psi) * (1.0 / (1.0 - e_y * kappa));
    [
        u.a - f_f * sin / m + omega_z * v_y,
        (f_f * cos + f_r) / m - omega_z * v_x,
        (f_f * cos * car.l_f - f_r * car.l_r) / car.inertia_z,
        omega_z - s_dot * kappa,
        s_dot,
        v_x * sin_psi + v_y * cos_psi,
    ]
}

#[test]
fn switched_off_leaves_the_printed_equations() {
    // The blend is on: above its upper speed it must not be there. The model has its own sine and
    // inverse tangent, so that rounding differs, and nothing else.
    let car = barc();
    for (x, u, kappa) in states() {
        let found = dynamic(car.clone()).derivative(&x, &u, kappa);
        for (found, printed) in found.into_iter().zip(printed_equations(&car, &x, &u, kappa)) {
            assert!((found - printed).abs() < 1e-13 * printed.abs().max(1.0), "{x:?} {u:?}");
        }
    }
}

/// Each effect by itself changes something: none of the switches is dead.
#[test]
fn every_effect_acts() {
    let air = CarParams { area: 0.02, rho: 1.2, ..barc() };
    let driven = CarParams { drive_front: 0.5, brake_front: 0.5, ..barc() };
    let with = [
        (barc(), CarParams { h_cg: 0.04, ..barc() }),
        (air.clone(), CarParams { cd: 0.5, ..air.clone() }),
        (air.clone(), CarParams { cl_front: 0.5, ..air.clone() }),
        (air.clone(), CarParams { cl_rear: 0.5, ..air }),
        (barc(), CarParams { rolling: 0.01, ..barc() }),
        (barc(), CarParams { linear_drag: 0.1, ..barc() }),
        (barc(), CarParams { drive_front: 0.3, ..barc() }),
        (barc(), CarParams { power_max: Some(4.0), ..barc() }),
        (barc(), CarParams { drive_force_max: Some(2.0), ..barc() }),
        (barc(), CarParams { combined_slip: true, ..barc() }),
        (driven.clone(), CarParams { front_force_yaw: false, ..driven }),
    ];
    let x = State { v_x: 2.5, v_y: 0.1, omega_z: 0.5, ..State::default() };
    let u = Input { a: 1.8, delta: 0.2 };
    for (i, (without, with)) in with.into_iter().enumerate() {
        let rate = |car| dynamic(car).derivative(&x, &u, 0.0);
        assert_ne!(rate(without), rate(with), "effect {i}");
    }
    let brake = Input { a: -1.8, delta: 0.2 };
    for with in [
        CarParams { brake_front: 0.5, ..barc() },
        CarParams { brake_force_max: Some(2.0), ..barc() },
    ] {
        let rate = |car| dynamic(car).derivative(&x, &brake, 0.0);
        assert_ne!(rate(barc()), rate(with));
    }
}

#[test]
fn a_left_turn_is_positive() {
    let x = State { v_x: 2.0, ..State::default() };
    let rate = dynamic(barc()).derivative(&x, &Input { a: 0.0, delta: 0.1 }, 0.0);
    assert!(rate[0] < 0.0, "steering brakes");
    assert!(rate[1] > 0.0 && rate[2] > 0.0, "left force, left yaw");
    // The path turns left under a car that goes straight: its heading error turns right.
    assert!(dynamic(barc()).derivative(&x, &Input::default(), 0.5)[3] < 0.0);
}

/// Power balance: tyre forces are the only thing that changes the energy of a coasting car, and
/// they only take: F_y is against the slip of its axle.
#[test]
fn tyres_only_take_energy() {
    let car = CarParams { h_cg: 0.03, ..barc() };
    let model = dynamic(car.clone());
    for (x, u, kappa) in states() {
        let u = Input { a: 0.0, ..u };
        let rate = model.derivative(&x, &u, kappa);
        let power =
            car.mass * (x.v_x * rate[0] + x.v_y * rate[1]) + car.inertia_z * x.omega_z * rate[2];
        let [f_f, f_r] = model.forces(&x, &u).lateral;
        // Speed of each contact patch across its wheel.
        let v_f = (x.v_y + car.l_f * x.omega_z) * u.delta.cos() - x.v_x * u.delta.sin();
        let v_r = x.v_y - car.l_r * x.omega_z;
        assert!((power - (f_f * v_f + f_r * v_r)).abs() < 1e-10 * (1.0 + power.abs()));
        assert!(power <= 1e-12, "{x:?} {u:?} gains {power} W");
    }
}

#[test]
fn loads_carry_the_car_and_move_with_acceleration() {
    let car = CarParams { h_cg: 0.05, ..barc() };
    let weight = car.mass * GRAVITY;
    for (x, u, _) in states() {
        let [front, rear] = dynamic(car.clone()).forces(&x, &u).vertical;
        assert!((front + rear - weight).abs() < 1e-9);
        let moment = car.l_f * front - car.l_r * rear;
        assert!((moment + car.mass * u.a * car.h_cg).abs() < 1e-9, "balance about the axle");
    }
    let iac = CarParams::builtin("iac").unwrap();
    let x = State { v_x: 60.0, ..State::default() };
    let [front, rear] = dynamic(iac.clone()).forces(&x, &Input::default()).vertical;
    let downforce = front + rear - iac.mass * GRAVITY;
    assert!((downforce - 2.0 * 0.5 * 1.2 * 3600.0).abs() < 1e-6);
}

#[test]
fn the_ellipse_bounds_the_force() {
    let car = CarParams { combined_slip: true, ..barc() }.with_mu(0.3);
    for (x, u, _) in states() {
        let forces = dynamic(car.clone()).forces(&x, &Input { a: 3.0 * u.a, ..u });
        for (i, mu) in [0.3, 0.3].into_iter().enumerate() {
            let (long, lateral) = (forces.long[i], forces.lateral[i]);
            let peak = mu * forces.vertical[i];
            assert!(long.hypot(lateral) <= peak * 1.002, "{long} {lateral} {peak}");
        }
    }
}

#[test]
fn power_and_force_limits_hold() {
    let car = CarParams {
        power_max: Some(5.0),
        drive_force_max: Some(3.0),
        brake_force_max: Some(2.0),
        ..barc()
    };
    for (x, u, _) in states() {
        let [_, force] = dynamic(car.clone()).forces(&x, &u).long;
        assert!((-2.0 - 1e-9..=3.0 + 1e-9).contains(&force) && force * x.v_x <= 5.0 + 1e-9);
    }
}

#[test]
fn slip_gradients_are_differences() {
    let h = 1e-6;
    for (x, u, _) in states() {
        let found = SlipAngles::new(&x, &u, &barc());
        let forces = dynamic(barc()).forces(&x, &u);
        assert!((found.front - forces.slip[0]).abs() < 1e-14);
        assert!((found.rear - forces.slip[1]).abs() < 1e-14);
        for j in 0..3 {
            let at = |h: f64| {
                let mut v = x.to_vector();
                v[j] += h;
                SlipAngles::new(&State::from_vector(&v), &u, &barc())
            };
            let front = (at(h).front - at(-h).front) / (2.0 * h);
            let rear = (at(h).rear - at(-h).rear) / (2.0 * h);
            assert!((found.front_gradient[j] - front).abs() < 1e-8);
            assert!((found.rear_gradient[j] - rear).abs() < 1e-8);
        }
    }
    assert!((barc().tyre_front.peak_slip() - 0.1647).abs() < 1e-4);
}

/// Every car settles from a disturbance at any speed, with the step the controller uses.
#[test]
fn low_speed_is_stable() {
    for (name, dt, top) in
        [("barc", 0.1, 1.5), ("iac", 0.1, 6.0), ("kart", 0.1, 4.0), ("mini", 0.02, 0.8)]
    {
        let car = CarParams::builtin(name).unwrap();
        for car in [car.clone(), car.with_mu(1.2)] {
            let step = Discretized { model: dynamic(car.clone()), dt, substeps: 10 };
            for i in -4..=60 {
                let v = top * f64::from(i) / 60.0;
                let mut x = State { v_x: v, v_y: 0.02 * top, omega_z: 0.3, ..State::default() };
                let u = Input { a: 0.0, delta: 0.05 };
                for _ in 0..40 {
                    // The speed is held: a stability test of the lateral modes.
                    x = State { v_x: v, ..step.next(&x, &u, |_| 0.0) };
                    let jacobian = step.linearize(&x, &u, |_| 0.0);
                    assert!(jacobian.a.iter().chain(jacobian.b.iter()).all(|v| v.is_finite()));
                }
                let rolling = v * 0.05_f64.tan() / car.wheelbase();
                assert!(
                    (x.omega_z - rolling).abs() < 0.2 * rolling.abs() + 0.02,
                    "{name} at {v} m/s: omega_z {}, rolling {rolling}",
                    x.omega_z
                );
            }
        }
    }
}
