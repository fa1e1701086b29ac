//! Exact Jacobians against central differences, with every effect switched on and off.

#![allow(clippy::unwrap_used)]

use nalgebra::Vector6;
use vehicle_model::{CarParams, Discretized, Input, Model, ModelKind, PoseConvention, State};

/// Half width of a central difference: error of the difference about 1e-9 of the third
/// derivative plus 1e-10 of rounding.
const H: f64 = 1e-5;
const TOLERANCE: f64 = 2e-6;

fn barc() -> CarParams {
    CarParams::builtin("barc").unwrap()
}

/// A small car with every effect the model knows.
fn everything() -> CarParams {
    CarParams {
        h_cg: 0.04,
        cd: 0.6,
        cl_front: 0.8,
        cl_rear: 1.1,
        area: 0.02,
        rho: 1.2,
        rolling: 0.015,
        linear_drag: 0.1,
        drive_front: 0.4,
        brake_front: 0.6,
        combined_slip: true,
        power_max: Some(6.0),
        drive_force_max: Some(3.5),
        brake_force_max: Some(4.0),
        ..barc()
    }
}

/// States and inputs over the range a race car sees; a stays off its kink at 0.
fn grid() -> Vec<(State, Input)> {
    let mut points = Vec::new();
    for v_x in [0.2, 0.55, 1.1, 2.3, 3.9] {
        for (v_y, omega_z) in [(0.0, 0.0), (0.15, -0.8), (-0.4, 2.6)] {
            for (e_psi, e_y) in [(0.0, 0.0), (0.5, -0.4), (-0.7, 0.45)] {
                for a in [-1.9, -0.6, 0.7, 1.4] {
                    for delta in [-0.4, 0.02, 0.25] {
                        let x = State { v_x, v_y, omega_z, e_psi, s: 3.0, e_y };
                        points.push((x, Input { a, delta }));
                    }
                }
            }
        }
    }
    points
}

/// Smooth in s, so that what the Jacobian freezes is visible if it were not frozen.
const KAPPA: f64 = 0.85;

fn assert_close(found: f64, expected: f64, what: &str) {
    let error = (found - expected).abs() / expected.abs().max(1.0);
    assert!(error < TOLERANCE, "{what}: found {found}, difference {expected}");
}

fn check(step: &Discretized) {
    let next = |x: &Vector6<f64>, u: [f64; 2]| {
        step.next(&State::from_vector(x), &Input { a: u[0], delta: u[1] }, |_| KAPPA).to_vector()
    };
    for (x, u) in grid() {
        let found = step.linearize(&x, &u, |_| KAPPA);
        assert_eq!(found.next, step.next(&x, &u, |_| KAPPA).to_vector());
        let (x, u) = (x.to_vector(), [u.a, u.delta]);
        for j in 0..6 {
            let shifted = |h: f64| {
                let mut x = x;
                x[j] += h;
                next(&x, u)
            };
            let difference = (shifted(H) - shifted(-H)) / (2.0 * H);
            for i in 0..6 {
                assert_close(found.a[(i, j)], difference[i], &format!("A[{i},{j}] at {x:?} {u:?}"));
            }
        }
        for j in 0..2 {
            let shifted = |h: f64| {
                let mut u = u;
                u[j] += h;
                next(&x, u)
            };
            let difference = (shifted(H) - shifted(-H)) / (2.0 * H);
            for i in 0..6 {
                assert_close(found.b[(i, j)], difference[i], &format!("B[{i},{j}] at {x:?} {u:?}"));
            }
        }
    }
}

#[test]
fn jacobians_of_the_plain_model() {
    check(&Discretized { model: Model::new(ModelKind::Dynamic, barc()), dt: 0.1, substeps: 10 });
}

#[test]
fn jacobians_with_every_effect_on() {
    let model = Model::new(ModelKind::Dynamic, everything());
    check(&Discretized { model, dt: 0.1, substeps: 10 });
}

#[test]
fn jacobians_of_the_kinematic_model_in_every_convention() {
    for pose in [PoseConvention::Interpolated, PoseConvention::Held, PoseConvention::Algebraic] {
        for car in [barc(), everything()] {
            let model = Model { pose, ..Model::new(ModelKind::Kinematic, car) };
            check(&Discretized { model, dt: 0.1, substeps: 10 });
        }
    }
}

#[test]
fn grip_jacobian_is_the_difference_by_grip() {
    for car in [barc(), everything()] {
        let mut step =
            Discretized { model: Model::new(ModelKind::Dynamic, car), dt: 0.1, substeps: 10 };
        let points = grid();
        step.model.grip = [0.8, 1.1];
        let mut all = Vec::new();
        step.grip_jacobians(&points, &|_| KAPPA, &mut |i, next, by| all.push((i, next, by)));
        assert!(all.iter().map(|found| found.0).eq(0..points.len()));
        let mut alone = Vec::new();
        step.velocities_all(&points, &|_| KAPPA, &mut |_, next| alone.push(next));
        for (((x, u), (_, next, found)), alone) in points.iter().zip(all).zip(alone) {
            step.model.grip = [0.8, 1.1];
            let whole = step.next(x, u, |_| KAPPA);
            assert_eq!(next, [whole.v_x, whole.v_y, whole.omega_z]);
            assert_eq!(next, alone);
            for j in 0..2 {
                let mut shifted = |h: f64| {
                    step.model.grip = [0.8, 1.1];
                    step.model.grip[j] += h;
                    step.next(x, u, |_| KAPPA).to_vector()
                };
                let difference = (shifted(H) - shifted(-H)) / (2.0 * H);
                for (by_grip, difference) in found.iter().zip(difference.iter()) {
                    assert_close(by_grip[j], *difference, "grip");
                }
            }
        }
    }
}

#[test]
fn curvature_is_frozen_across_a_jump() {
    let kappa = |s: f64| if s < 3.1 { 0.0 } else { 0.85 };
    let step = Discretized { model: Model::new(ModelKind::Dynamic, barc()), dt: 0.1, substeps: 10 };
    let x = State { v_x: 2.0, s: 3.0, e_y: 0.1, ..State::default() };
    let found = step.linearize(&x, &Input { a: 0.5, delta: 0.1 }, kappa);
    // Nothing depends on s, and nothing is of the size of a difference across the jump.
    assert_eq!(found.a.column(4).as_slice(), &[0.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
    assert!(found.a.amax() < 20.0 && found.b.amax() < 20.0, "{found:?}");
    // The step itself does see the curve behind the jump.
    let straight = step.next(&x, &Input { a: 0.5, delta: 0.1 }, |_| 0.0);
    assert!(found.next[3] < straight.e_psi - 0.05);
}

/// Full-size speeds, where drag and downforce matter and functions of v_x may overflow.
#[test]
fn jacobians_at_full_size_speeds() {
    let iac = CarParams::builtin("iac").unwrap();
    let step = Discretized { model: Model::new(ModelKind::Dynamic, iac), dt: 0.1, substeps: 10 };
    for v_x in [5.0, 20.0, 60.0, 100.0] {
        let x = State { v_x, v_y: 0.2, omega_z: 0.1, e_psi: 0.05, s: 3.0, e_y: 1.5 };
        for a in [-9.0, 6.0] {
            let u = Input { a, delta: 0.02 };
            let found = step.linearize(&x, &u, |_| 0.01);
            for j in 0..6 {
                let shifted = |h: f64| {
                    let mut x = x.to_vector();
                    x[j] += h;
                    step.next(&State::from_vector(&x), &u, |_| 0.01).to_vector()
                };
                let difference = (shifted(H) - shifted(-H)) / (2.0 * H);
                for i in 0..6 {
                    assert_close(found.a[(i, j)], difference[i], &format!("A[{i},{j}] at {v_x}"));
                }
            }
        }
    }
}
