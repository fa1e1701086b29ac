//! The variational equations against dual numbers of another crate through the whole step.

#![allow(clippy::unwrap_used)]

use num_dual::DualSVec64;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use super::{DIRECTIONS, Discretized, Linearization};
use crate::model::{Model, ModelKind, PoseConvention, state_array};
use crate::number::{Mask, Number};
use crate::params::CarParams;
use crate::road::{Road, Surface};
use crate::state::{Input, NX, State};

type Oracle = DualSVec64<DIRECTIONS>;

impl Number for Oracle {
    type Real = f64;

    fn real(self) -> f64 {
        self.re
    }

    fn constant(self, value: f64) -> Self {
        Self::from_re(value)
    }

    fn scale(self, by: f64) -> Self {
        self * by
    }

    fn recip(self) -> Self {
        num_dual::DualNum::recip(&self)
    }

    fn sqrt(self) -> Self {
        num_dual::DualNum::sqrt(&self)
    }

    fn sin_cos(self) -> (Self, Self) {
        num_dual::DualNum::sin_cos(&self)
    }

    fn atan(self) -> Self {
        num_dual::DualNum::atan(&self)
    }

    fn select(mask: Mask<Self>, yes: Self, no: Self) -> Self {
        if mask { yes } else { no }
    }
}

/// A wavy road: the curvature differs at every stage of the integration.
fn kappa(s: f64) -> f64 {
    0.02 + 0.01 * s.sin()
}

/// The same bends on hills with banks of changing grip.
#[derive(Clone, Copy)]
struct Hills;

impl Road for Hills {
    fn kappa(&self, s: f64) -> f64 {
        kappa(s)
    }

    fn is_flat(&self) -> bool {
        false
    }

    fn surface(&self, s: f64) -> Surface {
        Surface {
            bank: 0.3 * (0.1 * s).sin(),
            slope: 0.1 * (0.2 * s).cos(),
            bank_rate: 0.03 * (0.1 * s).cos(),
            slope_rate: -0.02 * (0.2 * s).sin(),
            friction: 0.9 + 0.1 * s.cos(),
        }
    }
}

/// Dual numbers of the whole step, the same equations and nothing else in common.
fn expected(step: &Discretized, x: &State, u: &Input, road: &impl Road) -> [Oracle; NX] {
    let values = state_array(x);
    let state = std::array::from_fn(|i| Oracle::from_re(values[i]).derivative(i));
    let input = [Oracle::from_re(u.a).derivative(NX), Oracle::from_re(u.delta).derivative(NX + 1)];
    step.step::<_, false>(&state, &input, &step.model.grip.map(Oracle::from_re), road)
}

/// Largest deviation relative to the largest entry of the row [-].
fn deviation(found: &Linearization, expected: &[Oracle; NX]) -> f64 {
    let mut worst = 0.0_f64;
    for (row, expected) in expected.iter().enumerate() {
        let gradient = expected.eps.unwrap_generic(nalgebra::Const::<DIRECTIONS>, nalgebra::U1);
        let largest = gradient.amax().max(1.0);
        for (column, expected) in gradient.iter().enumerate() {
            let found = match column {
                NX.. => found.b[(row, column - NX)],
                _ => found.a[(row, column)],
            };
            worst = worst.max((found - expected).abs() / largest);
        }
        worst = worst.max((found.next[row] - expected.re).abs() / expected.re.abs().max(1.0));
    }
    worst
}

/// States and inputs of a car between standstill and `speed`, its low-speed blend included.
fn points(random: &mut Pcg64Mcg, speed: f64, many: usize) -> Vec<(State, Input)> {
    let mut within = |limit: f64| random.random_range(-limit..limit);
    (0..many)
        .map(|_| {
            let v_x = within(speed).abs();
            let lateral = 0.1 * v_x.min(10.0) + 0.01;
            let x = State {
                v_x,
                v_y: within(lateral),
                omega_z: within(0.5),
                e_psi: within(0.8),
                s: within(300.0),
                e_y: within(2.0),
            };
            (x, Input { a: within(6.0), delta: within(0.35) })
        })
        .collect()
}

#[test]
fn jacobians_agree_with_dual_numbers_of_another_crate() {
    agree(kappa, 1e-12);
}

#[test]
fn jacobians_on_hills_agree_with_dual_numbers_of_another_crate() {
    agree(Hills, 1e-11);
}

fn agree(road: impl Road + Copy, tolerance: f64) {
    let mut random = Pcg64Mcg::seed_from_u64(6);
    for (car, speed) in [("barc", 4.0), ("mini", 4.0), ("kart", 20.0), ("iac", 90.0)] {
        let params = CarParams::builtin(car).unwrap();
        let loaded = CarParams {
            combined_slip: true,
            drive_front: 0.4,
            brake_front: 0.6,
            h_cg: 0.1,
            drive_force_max: Some(3.0 * params.mass),
            brake_force_max: Some(4.0 * params.mass),
            power_max: Some(2.0 * params.mass * speed),
            ..params.clone()
        };
        for params in [params, loaded] {
            for kind in [ModelKind::Dynamic, ModelKind::Kinematic] {
                let model =
                    Model { pose: PoseConvention::Algebraic, ..Model::new(kind, params.clone()) };
                let step = Discretized { model, dt: 0.1, substeps: 10 };
                // Groups of every size, of cars on both sides of every branch.
                for many in [1, 2, 3, 4, 5, 60, 203] {
                    let points = points(&mut random, speed, many);
                    let mut seen = 0;
                    step.linearize_all(&points, road, |i, found| {
                        assert_eq!(i, seen);
                        seen += 1;
                        let (x, u) = &points[i];
                        let worst = deviation(&found, &expected(&step, x, u, &road));
                        assert!(worst < tolerance, "{car} {kind:?}: {worst:e} at {x:?} {u:?}");
                        // One by one, and without derivatives: the same to the last bit.
                        assert_eq!(found, step.linearize(x, u, road));
                        assert_eq!(found.next, step.next(x, u, road).to_vector());
                    });
                    assert_eq!(seen, many);
                }
            }
        }
    }
}
