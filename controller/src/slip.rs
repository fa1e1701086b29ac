//! Slip angles of a plan: rows for the guards, what slip costs, how much of the rear axle's guard a braking car has,
//! and the steering that gives a force. The paper's (4) has none of it.
//!
//! ```text
//! alpha_f = delta - atan((v_y + l_f omega_z) / v_x),   alpha_r = -atan((v_y - l_r omega_z) / v_x)
//! |alpha_f(x_t, u_t)| <= front_max share_t + f_t,      |alpha_r(x_t)| <= rear_max share_t + g_t     guards, soft
//! c (alpha - ref)^2,   c = k (N - t) dt C_alpha / (m v),   C_alpha = F_y / alpha                    dissipation
//! ```

use fhocp::SlipRow;
use nalgebra::{Matrix6, Vector3, Vector6};
use vehicle_model::{CarParams, Input, SlipAngles, State, Tyre};

use crate::controller::Setup;

/// Speed below which delay per speed is no longer the quotient [m/s].
const SLOW: f64 = 0.5;

/// Share of a guard that is left however hard the car brakes, and however noisy its velocities are.
const LEAST_SHARE: f64 = 0.3;

/// What slipping tyres cost: the curvature that the linearised v_x row lacks.
///
/// A tyre takes F_y alpha / m of the acceleration along the path (the power F_y v alpha lost in
/// the contact patch), about C_alpha alpha^2 / m, which is convex in alpha. Linearised at alpha
/// other than 0, reversing the slip looks like thrust. A speed lost now delays the car by
/// (N - t) / v steps per m/s at the horizon's end, so that the missing term is
/// `(N - t) / v dt C_alpha / m (alpha - ref)^2`, with the secant stiffness C_alpha = F_y / alpha.
pub(crate) struct Dissipation<'a> {
    car: &'a CarParams,
    grip: [f64; 2],
    /// Factor of `C_alpha / (m v)`.
    factor: f64,
}

impl<'a> Dissipation<'a> {
    pub(crate) fn new(setup: &'a Setup, grip: [f64; 2], stages: usize) -> Self {
        let factor = setup.config.cost.dissipation * stages as f64 * setup.config.horizon.period;
        Self { car: &setup.car, grip, factor }
    }

    /// Weight of the squared slip angle of an axle, front 0, rear 1, in steps [1/rad^2].
    pub(crate) fn weight(&self, v_x: f64, axle: usize, alpha: f64) -> f64 {
        let car = self.car;
        let tyre = [&car.tyre_front, &car.tyre_rear][axle];
        let load = car.loads_at(v_x)[axle];
        let alpha = alpha.abs().max(1e-3);
        let (share, _) = tyre.force_share(alpha);
        let stiffness = tyre.mu * self.grip[axle] * load * share.abs() / alpha;
        self.factor * stiffness / (car.mass * v_x.max(SLOW))
    }
}

/// The front slip angle linearised at (x, u).
pub(crate) fn front(car: &CarParams, x: &State, u: &Input) -> SlipRow {
    let slip = SlipAngles::new(x, u, car);
    let velocity = slip.front_gradient;
    let offset = slip.front - u.delta - velocity.dot(&velocities(x));
    SlipRow { velocity: velocity.into(), steering: 1.0, offset, weight: 0.0, reference: slip.front }
}

/// The rear slip angle linearised at x.
pub(crate) fn rear(car: &CarParams, x: &State) -> SlipRow {
    let slip = SlipAngles::new(x, &Input::default(), car);
    let velocity = slip.rear_gradient;
    SlipRow {
        velocity: velocity.into(),
        steering: 0.0,
        offset: slip.rear - velocity.dot(&velocities(x)),
        weight: 0.0,
        reference: slip.rear,
    }
}

/// The steering angle with which the front tyre gives the force that its linearisation promised at `delta`,
/// with no more slip than `most`:
///
/// ```text
/// F(alpha_ref) + F'(alpha_ref) (alpha - alpha_ref) = F(alpha')        delta' = delta + alpha' - alpha
/// ```
///
/// Below its peak the curve bends: a plan that unwinds the steering by the slope near the peak loses more
/// force than it wanted, and has to wind it on again in the next period. (The force as the input, and an
/// inverse tyre: Beal and Gerdes, Model Predictive Control for Vehicle Stabilization at the Limits of
/// Handling, IEEE Transactions on Control Systems Technology 21 (2013).)
pub(crate) fn steering(
    tyre: &Tyre,
    row: &SlipRow,
    (x, delta): (&Vector6<f64>, f64),
    most: f64,
) -> f64 {
    let alpha = row.angle(x, delta);
    let (force, slope) = tyre.force_share(row.reference);
    let wanted = tyre.slip_of(force + slope * (alpha - row.reference)).clamp(-most, most);
    delta + wanted - alpha
}

/// Standard deviation of a slip angle of states with this covariance \[rad\].
///
/// At its peak a tyre no longer answers the steering: a car that slips more than its plan believes runs
/// wide, and one whose rear axle does so spins.
pub(crate) fn deviation(covariance: &Matrix6<f64>, row: &SlipRow) -> f64 {
    let gradient = Vector3::from(row.velocity);
    let variance = gradient.dot(&(covariance.fixed_view::<3, 3>(0, 0) * gradient));
    variance.max(0.0).sqrt()
}

/// What is left of this share of a guard `max` where so much room is kept free.
pub(crate) fn left(share: f64, room: f64, max: f64) -> f64 {
    (share - room / max).max(LEAST_SHARE)
}

fn velocities(x: &State) -> Vector3<f64> {
    Vector3::new(x.v_x, x.v_y, x.omega_z)
}

/// Share of the rear slip guard that a car braking with `a` has: the rear axle's load as a share of
/// its load without braking.
///
/// Braking moves load to the front, where it turns the car in, from the rear, where it holds it.
/// Near the peak slip the rear then gives way to every error. 1 while the car drives on.
pub(crate) fn rear_share(car: &CarParams, v_x: f64, a: f64) -> f64 {
    let [_, rear] = car.loads_at(v_x);
    (1.0 - car.moved_load((-a).max(0.0)) / rear).max(LEAST_SHARE)
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_pcg::Pcg64;
    use vehicle_model::normal::standard_normal;

    use super::*;

    /// Slip angles of states drawn with the covariance spread as far as it says.
    #[test]
    fn the_deviation_is_the_spread_of_the_slip() {
        let car = CarParams::builtin("barc").unwrap();
        let x = State { v_x: 3.0, v_y: -0.1, omega_z: 1.5, ..State::default() };
        let u = Input { a: 0.0, delta: 0.15 };
        let [common, own] = [0.02, 0.05];
        let mut p = Matrix6::from_diagonal_element(own * own);
        p.fixed_view_mut::<3, 3>(0, 0).add_scalar_mut(common * common);
        let row = front(&car, &x, &u);
        assert_eq!(deviation(&Matrix6::zeros(), &row), 0.0);

        let mut rng = Pcg64::seed_from_u64(1);
        let mut draw = || -> f64 { standard_normal(&mut rng) };
        let n = 20_000;
        let slips: Vec<f64> = (0..n)
            .map(|_| {
                let shared = common * draw();
                let [v_x, v_y, omega_z] =
                    [x.v_x, x.v_y, x.omega_z].map(|v| v + shared + own * draw());
                SlipAngles::new(&State { v_x, v_y, omega_z, ..x }, &u, &car).front
            })
            .collect();
        let mean = slips.iter().sum::<f64>() / n as f64;
        let variance = slips.iter().map(|slip| (slip - mean).powi(2)).sum::<f64>() / n as f64;
        let sigma = deviation(&p, &row);
        assert!((sigma / variance.sqrt() - 1.0).abs() < 0.03, "{sigma} {variance}");
    }

    #[test]
    fn the_steering_gives_the_force_that_was_promised() {
        let car = CarParams::builtin("barc").unwrap();
        let x = State { v_x: 3.0, v_y: -0.05, omega_z: 1.0, ..State::default() };
        let most = 0.9 * car.tyre_front.peak_slip();
        let tyre = &car.tyre_front;
        let force = |alpha: f64| (tyre.c * (tyre.b * alpha).atan()).sin();
        for delta in [-0.1, 0.05, 0.2, 0.26] {
            let u = Input { a: 0.0, delta };
            let row = front(&car, &x, &u);
            let slip = |delta: f64| SlipAngles::new(&x, &Input { delta, ..u }, &car).front;
            let (at, h) = (slip(delta), 1e-6);
            let slope = (force(at + h) - force(at - h)) / (2.0 * h);
            for change in [-0.15, -0.02, 0.0, 0.02, 0.3] {
                let found = steering(tyre, &row, (&x.to_vector(), delta + change), most);
                let promised = force(at) + slope * change;
                let given = force(slip(found));
                if promised.abs() < force(most) {
                    assert!(
                        (given - promised).abs() < 1e-6,
                        "{delta} {change}: {given} {promised}"
                    );
                } else {
                    assert!((slip(found) - most.copysign(promised)).abs() < 1e-9);
                }
            }
        }
    }
}
