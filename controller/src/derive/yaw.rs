//! How fast a braking car's yaw grows by itself, and the sampling period that is short enough for it.

use vehicle_model::CarParams;

/// Growth of the yaw instability within one sampling period, as its exponent, that is still steered
/// against by a car that brakes straight ahead.
const GROWTH: f64 = 0.35;
/// The same of a car that corners while it brakes: it does so for a shorter time, and on tyres that saturate.
const CORNERING_GROWTH: f64 = 1.1;

/// Longest sampling period in which a car that brakes, up to this speed, can still be steered against its yaw
/// instability \[s\]. The guards bound the slip angles, front and rear \[rad\].
pub(super) fn longest_period(car: &CarParams, guards: [f64; 2], top: f64) -> f64 {
    let fastest = |cornering: f64| {
        let speeds = (1..=50).map(|i| top * f64::from(i) / 50.0);
        speeds.map(|v| growth_rate(car, guards, v, cornering)).fold(1e-6, f64::max)
    };
    let cornering = (1..=20).map(|i| fastest(f64::from(i) / 20.0)).fold(0.0, f64::max);
    (GROWTH / fastest(0.0)).min(CORNERING_GROWTH / cornering)
}

/// Growth rate of the yaw instability at the hardest braking and this speed \[1/s\]; negative for a car
/// that stays stable. `cornering` is the lateral acceleration as a share of what the slip guards allow.
///
/// Single track with the tyres' tangent stiffness C, loads moved by braking. The greatest real
/// eigenvalue of [[-(C_f + C_r)/(m v), (l_r C_r - l_f C_f)/(m v) - v],
/// [(l_r C_r - l_f C_f)/(I v), -(l_f^2 C_f + l_r^2 C_r)/(I v)]].
fn growth_rate(car: &CarParams, guards: [f64; 2], v: f64, cornering: f64) -> f64 {
    let peaks = peak_forces(car, v);
    let slips = slips(car, guards, peaks, cornering);
    let c_f = peaks[0] * car.tyre_front.force_share(slips[0]).1;
    let c_r = peaks[1] * car.tyre_rear.force_share(slips[1]).1;
    let moment = car.l_r * c_r - car.l_f * c_f;
    let damping = car.l_f * car.l_f * c_f + car.l_r * car.l_r * c_r;
    let (a, b) = (-(c_f + c_r) / (car.mass * v), moment / (car.mass * v) - v);
    let (c, d) = (moment / (car.inertia_z * v), -damping / (car.inertia_z * v));
    let (half, product) = (0.5 * (a + d), a * d - b * c);
    let root = half * half - product;
    if root > 0.0 { half + root.sqrt() } else { half }
}

/// Greatest lateral force of the front and the rear axle at the hardest braking \[N\].
fn peak_forces(car: &CarParams, v: f64) -> [f64; 2] {
    let moved = car.moved_load(car.hardest_braking());
    let [front, rear] = car.loads_at(v);
    [(front + moved).max(0.0) * car.tyre_front.mu, (rear - moved).max(0.0) * car.tyre_rear.mu]
}

/// Slip angles of axles with these peak forces at a share of the lateral acceleration that the guards
/// allow, front and rear \[rad\].
fn slips(car: &CarParams, guards: [f64; 2], peaks: [f64; 2], cornering: f64) -> [f64; 2] {
    let tyres = [&car.tyre_front, &car.tyre_rear];
    // An axle bears the share of the lateral force that the other one's distance is of the wheelbase.
    let borne = [car.l_r, car.l_f].map(|distance| distance / car.wheelbase());
    let most = |i: usize| peaks[i] * tyres[i].force_share(guards[i]).0 / borne[i];
    let force = cornering * most(0).min(most(1));
    [0, 1].map(|i| tyres[i].slip_of(force * borne[i] / peaks[i].max(f64::MIN_POSITIVE)))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use vehicle_model::{Input, Model, ModelKind, State};

    use super::*;

    /// Eigenvalue of the differences of the model's own accelerations, in a bend while it brakes.
    #[test]
    fn yaw_grows_as_in_the_nonlinear_model() {
        for (name, v) in [("f1tenth", 6.0), ("road", 30.0), ("formula_student", 20.0)] {
            let car = CarParams::builtin(name).unwrap();
            let model = Model::new(ModelKind::Dynamic, car.clone());
            for cornering in [0.0, 0.6, 0.9] {
                let [front, rear] = slips(&car, [0.1, 0.1], peak_forces(&car, v), cornering);
                // The yaw rate is that of some bend; the slips are those of the axles.
                let omega_z = 0.5 * v / 10.0;
                let v_y = car.l_r * omega_z - v * libm::tan(rear);
                let delta = front + libm::atan((v_y + car.l_f * omega_z) / v);
                let rates = |v_y: f64, omega_z: f64| {
                    let x = State { v_x: v, v_y, omega_z, ..State::default() };
                    let u = Input { a: -car.hardest_braking(), delta };
                    let [_, v_y, omega_z, ..] = model.derivative(&x, &u, 0.0);
                    [v_y, omega_z]
                };
                let h = 1e-5;
                let by =
                    |high: [f64; 2], low: [f64; 2]| [0, 1].map(|i| (high[i] - low[i]) / (2.0 * h));
                let [a, c] = by(rates(v_y + h, omega_z), rates(v_y - h, omega_z));
                let [b, d] = by(rates(v_y, omega_z + h), rates(v_y, omega_z - h));
                let jacobian = nalgebra::Matrix2::new(a, b, c, d);
                let values = jacobian.complex_eigenvalues();
                let expected = values.iter().map(|value| value.re).fold(f64::MIN, f64::max);
                let found = growth_rate(&car, [0.1, 0.1], v, cornering);
                let far = (found - expected).abs() / expected.abs().max(1.0);
                assert!(far < 0.06, "{name}, {cornering}: {found} 1/s, differences {expected} 1/s");
            }
        }
    }

    /// A car that spins when it brakes in bends, though it is stable when it brakes straight ahead.
    #[test]
    fn a_car_that_only_spins_in_bends_is_controlled_in_shorter_periods() {
        let mut car = CarParams::builtin("barc").unwrap();
        let period = |car: &CarParams| longest_period(car, [0.2, 0.17], 5.0);
        (car.tyre_rear.b, car.h_cg) = (1.1 * car.tyre_rear.b, 0.0);
        let low = period(&car);
        (car.h_cg, car.a_min) = (0.25 * car.wheelbase(), -7.0);
        let high = period(&car);
        let straight = growth_rate(&car, [0.2, 0.17], 5.0, 0.0);
        assert!(straight < 0.0 && high < 0.1 && low > 0.1, "{straight} 1/s, {high} s, {low} s");
    }
}
