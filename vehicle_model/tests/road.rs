//! The equations on banked and sloped roads against mechanics done another way.
#![allow(clippy::unwrap_used, reason = "code of tests")]

use nalgebra::{Matrix3, Rotation3, Vector3};
use vehicle_model::track::Station;
use vehicle_model::{
    CarParams, Discretized, GRAVITY, Input, Model, ModelKind, Road, RoadPoint, State, Surface,
    Track,
};

fn dynamic(name: &str) -> Model {
    Model::new(ModelKind::Dynamic, CarParams::builtin(name).unwrap())
}

fn cone(kappa: f64, bank: f64) -> RoadPoint {
    RoadPoint { kappa, surface: Some(Surface { bank, ..Surface::FLAT }) }
}

/// On a cone a point mass needs no force across the road at v^2 kappa = g tan(bank); its weight and
/// the centrifugal force press it on with m sqrt(g^2 + (v^2 kappa)^2).
#[test]
fn a_cone_is_driven_without_lateral_force_at_the_speed_of_a_point_mass() {
    for (kappa, bank) in [(0.02_f64, -0.16_f64), (-0.01, 0.35), (0.1, -0.7)] {
        let model = dynamic("road");
        let car = &model.params;
        let v: f64 = (GRAVITY * bank.abs().tan() / kappa.abs()).sqrt();
        // Wheels roll where they point; the centre of gravity follows the road.
        let omega_z = kappa * bank.cos() * v;
        let v_y = car.l_r * omega_z;
        let v_x = (v * v - v_y * v_y).sqrt();
        let delta = (car.wheelbase() * omega_z / v_x).atan();
        let e_psi = -v_y.atan2(v_x);
        let x = State { v_x, v_y, omega_z, e_psi, ..State::default() };
        let road = cone(kappa, bank);
        let forces = model.forces_along(&x, &Input { a: 0.0, delta }, &road);
        let pressed = car.mass * GRAVITY.hypot(v * v * kappa);
        let load = forces.vertical[0] + forces.vertical[1];
        assert!((load / pressed - 1.0).abs() < 1e-3, "{load} {pressed}");
        for force in forces.lateral {
            assert!(force.abs() < 2e-3 * pressed, "{force} of {pressed}");
        }
        let rates = model.derivative_along(&x, &Input { a: 0.0, delta }, &road);
        assert!(rates[1].abs() < 0.01 * v * v * kappa.abs(), "v_y' {}", rates[1]);
        assert!(rates[3].abs() < 1e-9 && rates[5].abs() < 1e-9 * v, "{rates:?}");
        assert!((rates[4] / v - 1.0).abs() < 1e-9, "s' {} {v}", rates[4]);
    }
}

/// The fastest steady circle on a cone: the speed at which the tyres' force across the road is all
/// that their load allows agrees with the closed form of the point mass.
#[test]
fn the_closed_form_of_corner_speed_balances_forces_on_a_cone() {
    for (kappa, bank, mu) in [(0.02_f64, -0.16_f64, 0.9), (-0.02, 0.16, 1.2), (0.02, 0.1, 0.9)] {
        let v = cone(kappa, bank).corner_speed(kappa, mu, 0.0);
        // Axes: outward horizontal and up; forces per mass.
        let outward = v * v * kappa.abs();
        let tilt = if kappa > 0.0 { -bank } else { bank };
        let normal = GRAVITY * tilt.cos() + outward * tilt.sin();
        let across = outward * tilt.cos() - GRAVITY * tilt.sin();
        assert!((across / normal / mu - 1.0).abs() < 1e-12, "{across} {normal}");
    }
    assert!(cone(0.02, -1.0).corner_speed(0.02, 1.0, 0.0).is_infinite());
}

/// Hills, banks and bends of wave lengths of their own.
struct Wavy;

impl Road for Wavy {
    fn kappa(&self, s: f64) -> f64 {
        0.01 + 0.015 * (0.03 * s).sin()
    }

    fn is_flat(&self) -> bool {
        false
    }

    fn surface(&self, s: f64) -> Surface {
        Surface {
            bank: -0.1 + 0.12 * (0.05 * s).sin(),
            slope: 0.08 * (0.04 * s).cos(),
            bank_rate: 0.12 * 0.05 * (0.05 * s).cos(),
            slope_rate: -0.08 * 0.04 * (0.04 * s).sin(),
            friction: 0.8 + 0.1 * (0.02 * s).cos(),
        }
    }
}

/// Rotation from the road's frame to the world's, with the heading of the centre line.
fn road_frame(s: f64, heading: f64) -> Matrix3<f64> {
    let surface = Wavy.surface(s);
    // nalgebra: roll, pitch, yaw; a slope upwards is a negative pitch.
    Rotation3::from_euler_angles(surface.bank, -surface.slope, heading).into_inner()
}

/// Newton and Euler in space: positions and attitudes along a simulated drive are differentiated
/// numerically; acceleration minus gravity, in the axes of the body, is what tyres and resistance
/// give, and the angular velocity about the normal is the yaw rate.
#[test]
fn forces_agree_with_numerical_differentiation_in_space() {
    for name in ["road", "iac", "barc"] {
        let model = dynamic(name);
        let (dt, count) = (1e-3, 4000);
        let step = Discretized { model: model.clone(), dt, substeps: 1 };
        let scale = model.params.wheelbase() / 2.6;
        let mut x = State { v_x: 18.0 * scale.sqrt(), e_y: 0.5, ..State::default() };
        let mut heading = 0.3;
        let (mut position, mut path, mut inputs) = (Vector3::zeros(), Vec::new(), Vec::new());
        for i in 0..count {
            let t = f64::from(i) * dt;
            let u = Input { a: 0.4 * t.cos(), delta: 0.03 + 0.02 * (1.3 * t).sin() };
            let frame = road_frame(x.s, heading);
            let body = frame * Rotation3::from_axis_angle(&Vector3::z_axis(), x.e_psi).into_inner();
            let velocity = body * Vector3::new(x.v_x, x.v_y, 0.0);
            path.push((x, body, velocity));
            inputs.push(u);
            let next = step.next(&x, &u, Wavy);
            // Heading of the centre line: the integral of kappa ds, by Simpson's rule.
            let (a, b) = (x.s, next.s);
            heading +=
                (b - a) / 6.0 * (Wavy.kappa(a) + 4.0 * Wavy.kappa(0.5 * (a + b)) + Wavy.kappa(b));
            position += velocity * dt;
            x = next;
        }
        assert!(position.norm() > 10.0);
        // Behind the quick motion at the start, which differences do not resolve.
        for i in (1000..count as usize - 10).step_by(97) {
            let (x, body, _) = path[i];
            let u = inputs[i];
            let rate = |f: &dyn Fn(usize) -> Vector3<f64>| (f(i + 1) - f(i - 1)) / (2.0 * dt);
            let acceleration = rate(&|k| path[k].2);
            let specific = body.transpose() * (acceleration + Vector3::new(0.0, 0.0, GRAVITY));
            let turned = (path[i + 1].1 - path[i - 1].1) / (2.0 * dt);
            let spin = body.transpose() * turned;
            assert!((spin[(1, 0)] - x.omega_z).abs() < 2e-5, "{} {}", spin[(1, 0)], x.omega_z);

            let forces = model.forces_along(&x, &u, &Wavy);
            let (mass, v) = (model.params.mass, x.v_x);
            let car = &model.params;
            let (sin, cos) = u.delta.sin_cos();
            let lateral = forces.lateral[0] * cos + forces.lateral[1] + forces.long[0] * sin;
            let down = 0.5 * car.rho * car.area * (car.cl_front + car.cl_rear) * v * v;
            let load = (forces.vertical[0] + forces.vertical[1] - down) / mass;
            let drag = 0.5 * car.rho * car.area * car.cd / mass * v * v
                + car.rolling * load * v / v.hypot(0.05);
            let along = (forces.long[0] * cos + forces.long[1] - forces.lateral[0] * sin) / mass;
            let expected = Vector3::new(along - drag, lateral / mass, load);
            let miss = specific - expected;
            assert!(miss.amax() < 2e-4 * GRAVITY, "{name} at {i}: {specific:?} {expected:?}");
        }
    }
}

/// The plan-view kinematics: the position in the horizontal plane moves with the horizontal part of
/// the velocity in space.
#[test]
fn the_pose_moves_as_the_plan_view_of_the_motion() {
    let track = Track::builtin("l").unwrap();
    let stations = [(0.0, -0.1, 0.05), (6.0, 0.2, -0.05), (12.0, -0.2, 0.0)];
    let station = |(s, bank, slope)| Station {
        s,
        bank: Some(bank),
        slope: Some(slope),
        ..Station::default()
    };
    let track = track.with_stations(&stations.map(station)).unwrap();
    let step = Discretized { model: dynamic("barc"), dt: 1e-3, substeps: 1 };
    let mut x = State { v_x: 1.5, e_y: 0.1, e_psi: 0.1, v_y: 0.05, ..State::default() };
    for i in 0..4000_u32 {
        let u = Input { a: 0.2, delta: 0.25 * (0.002 * f64::from(i)).sin() };
        let next = step.next(&x, &u, track.road());
        let (from, to) = (track.to_global(&x), track.to_global(&next));
        let surface = track.surface(x.s);
        let frame = Rotation3::from_euler_angles(surface.bank, -surface.slope, track.heading(x.s));
        let mean = |a: f64, b: f64| 0.5 * (a + b);
        let (v_x, v_y) = (mean(x.v_x, next.v_x), mean(x.v_y, next.v_y));
        let (sin, cos) = mean(x.e_psi, next.e_psi).sin_cos();
        let velocity = frame * Vector3::new(v_x * cos - v_y * sin, v_x * sin + v_y * cos, 0.0);
        let turned = 0.5 * track.kappa(x.s) * (next.s - x.s);
        let moved = Vector3::new(to.x - from.x, to.y - from.y, 0.0);
        let plan = Rotation3::from_axis_angle(&Vector3::z_axis(), turned)
            * Vector3::new(velocity.x, velocity.y, 0.0)
            * step.dt;
        // At a jump of the curvature the step is of neither side.
        if track.kappa(x.s) == track.kappa(next.s) {
            assert!((moved - plan).norm() < 1e-6, "{i}: {moved:?} {plan:?}");
        }
        x = State { s: track.wrap(next.s), ..next };
        if x.e_y.abs() > 0.4 {
            x = State { e_y: 0.0, e_psi: 0.0, ..x };
        }
    }
}

/// The equations with a surface that happens to be level are those without one.
#[test]
fn a_level_surface_changes_nothing() {
    struct Level;
    impl Road for Level {
        fn kappa(&self, s: f64) -> f64 {
            0.3 * s.sin()
        }

        fn is_flat(&self) -> bool {
            false
        }
    }
    for name in CarParams::builtin_names() {
        let step = Discretized { model: dynamic(name), dt: 0.05, substeps: 5 };
        let v = 2.0 * (GRAVITY * step.model.params.wheelbase()).sqrt();
        let x = State { v_x: v, v_y: -0.02 * v, omega_z: 0.1 * v, e_psi: 0.1, s: 2.0, e_y: 0.2 };
        let u = Input { a: -0.5, delta: 0.05 };
        let (flat, level) =
            (step.linearize(&x, &u, |s: f64| 0.3 * s.sin()), step.linearize(&x, &u, Level));
        assert!((flat.next - level.next).amax() < 1e-12 * v, "{name}");
        assert!((flat.a - level.a).amax() < 1e-10 * flat.a.amax(), "{name}");
        assert!((flat.b - level.b).amax() < 1e-10 * flat.b.amax().max(1.0), "{name}");
    }
}

/// A road that states its flatness, or a speed limit alone, is driven with the bits of one that
/// states nothing.
#[test]
fn flat_tracks_have_the_same_bits() {
    let plain = Track::builtin("l").unwrap();
    let stated = [0.0, 4.0, 9.0].map(|s| Station {
        s,
        bank: Some(0.0),
        slope: Some(0.0),
        friction: Some(1.0),
        speed_limit: Some(2.0),
    });
    let stated = plain.clone().with_stations(&stated).unwrap();
    assert!(stated.is_flat() && plain.is_flat());
    let step = Discretized { model: dynamic("barc"), dt: 0.1, substeps: 10 };
    let mut x = State { v_x: 1.0, ..State::default() };
    for i in 0..200_u32 {
        let u = Input { a: 0.3, delta: 0.3 * (0.1 * f64::from(i)).sin() };
        let (one, other) =
            (step.linearize(&x, &u, plain.road()), step.linearize(&x, &u, stated.road()));
        assert_eq!(one, other);
        x = State::from_vector(&one.next);
    }
}
