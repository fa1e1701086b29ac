//! Random cars: numbers between those of a model car and of a road car, for settings that are to hold for any.

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use super::{CarParams, GRAVITY, Secant, Tyre};

/// Wheelbase, uniform in its logarithm \[m\].
const WHEELBASE: (f64, f64) = (0.12, 3.0);
/// Mass of a car of a wheelbase of 1 m, \[kg\], and the power of the wheelbase with which it grows: a line
/// through a 1/10-scale car and a racing car.
const MASS: (f64, f64) = (60.0, 2.4);
/// Factor on that mass.
const HEAVIER: (f64, f64) = (0.6, 1.6);
/// Yaw inertia, in m l^2.
const INERTIA: (f64, f64) = (0.1, 0.3);
/// Distance of the centre of gravity from the front axle, in wheelbases.
const BALANCE: (f64, f64) = (0.45, 0.55);
/// Body length and width, in wheelbases.
const LENGTH: (f64, f64) = (1.3, 1.8);
const WIDTH: (f64, f64) = (0.45, 0.8);
/// Friction coefficient.
const FRICTION: (f64, f64) = (0.6, 1.6);
/// Shape factor C of both tyres, and slip angle of the front tyre's greatest force \[rad\].
const SHAPE: (f64, f64) = (1.2, 2.1);
const PEAK: (f64, f64) = (0.09, 0.225);
/// Stiffness factor B of the rear tyre over that of the front tyre: neutral to understeering.
const REAR_STIFFNESS: (f64, f64) = (1.0, 1.25);
/// Strongest braking and driving, in mu g.
const BRAKING: (f64, f64) = (0.4, 1.0);
const DRIVING: (f64, f64) = (0.25, 0.9);
/// Shares of the front axle: rear, all-wheel and front drive; brakes at the rear, or as on most cars.
const DRIVEN_FRONT: [f64; 3] = [0.0, 0.5, 1.0];
const BRAKED_FRONT: [f64; 4] = [0.0, 0.5, 0.6, 0.65];
/// Steering stop \[rad\]; rate, over that of a wheelbase of 1 m as its root falls \[rad/s\].
const STOP: (f64, f64) = (0.3, 0.5);
const STEERING_RATE: (f64, f64) = (0.6, 2.0);
/// Height of the centre of gravity, in wheelbases.
const HEIGHT: (f64, f64) = (0.08, 0.25);
/// Actuator lag, in sqrt(l / (mu g)).
const LAG: (f64, f64) = (0.1, 0.5);
/// Speeds between which rolling wheels give way to the tyre model, in sqrt(mu g l).
const BLEND: (f64, f64) = (0.2, 0.5);

impl CarParams {
    /// A car of random numbers, the same for the same seed: a wheelbase of 0.12 to 3 m, neutral to understeering,
    /// half of them each with a limited steering rate, with load transfer and with an actuator lag.
    #[must_use]
    pub fn random(seed: u64) -> Self {
        let mut rng = Pcg64Mcg::seed_from_u64(seed);
        let mut number = |range: (f64, f64)| range.0 + (range.1 - range.0) * rng.random::<f64>();
        let wheelbase = libm::exp(number((libm::log(WHEELBASE.0), libm::log(WHEELBASE.1))));
        let mass = MASS.0 * libm::pow(wheelbase, MASS.1) * number(HEAVIER);
        let l_f = wheelbase * number(BALANCE);
        let mu = number(FRICTION);
        let c = number(SHAPE);
        let b = libm::tan(std::f64::consts::FRAC_PI_2 / c) / number(PEAK);
        let tyre = |b: f64| Tyre { b, c, mu, secant: Secant::default() };
        let tyre_rear = tyre(b * number(REAR_STIFFNESS));
        let grip = mu * GRAVITY;
        let speed = (grip * wheelbase).sqrt();
        let [height, rate, lag] = [HEIGHT, STEERING_RATE, LAG].map(&mut number);
        let [inertia, length, width] = [INERTIA, LENGTH, WIDTH].map(&mut number);
        let [braking, driving, stop] = [BRAKING, DRIVING, STOP].map(&mut number);
        let [high, steered, slow] = [(); 3].map(|()| rng.random::<bool>());
        let drive_front = DRIVEN_FRONT[rng.random_range(0..DRIVEN_FRONT.len())];
        let brake_front = BRAKED_FRONT[rng.random_range(0..BRAKED_FRONT.len())];
        Self {
            name: format!("random_{seed}"),
            drive_front,
            brake_front,
            mass,
            inertia_z: mass * wheelbase * wheelbase * inertia,
            l_f,
            l_r: wheelbase - l_f,
            tyre_front: tyre(b),
            tyre_rear,
            h_cg: if high { wheelbase * height } else { 0.0 },
            cd: 0.0,
            cl_front: 0.0,
            cl_rear: 0.0,
            area: 0.0,
            rho: 0.0,
            rolling: 0.0,
            linear_drag: 0.0,
            front_force_yaw: false,
            combined_slip: false,
            power_max: None,
            drive_force_max: None,
            brake_force_max: None,
            speed_max: None,
            length: wheelbase * length,
            width: wheelbase * width,
            a_min: -grip * braking,
            a_max: grip * driving,
            delta_max: stop,
            delta_rate_max: steered.then_some(rate / wheelbase.sqrt()),
            a_rate_max: None,
            actuator_lag: if slow { lag * wheelbase / speed } else { 0.0 },
            actuator_delay: 0.0,
            blend_speed_low: BLEND.0 * speed,
            blend_speed_high: BLEND.1 * speed,
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    /// The numbers are those of a car file, fit together and differ from seed to seed.
    #[test]
    fn random_cars_are_cars() {
        let cars: Vec<_> = (0..200).map(CarParams::random).collect();
        for car in &cars {
            assert_eq!(car.validate(), Vec::new(), "{}", car.name);
            let peak = car.tyre_front.peak_slip();
            assert!(peak > PEAK.0 && peak < PEAK.1, "{}: {peak} rad", car.name);
            assert_eq!(&CarParams::from_toml(&car.to_toml()).unwrap(), car);
        }
        assert_eq!(CarParams::random(7), cars[7]);
        let share = |has: fn(&CarParams) -> bool| cars.iter().filter(|car| has(car)).count();
        for count in [
            share(|car| car.delta_rate_max.is_some()),
            share(|car| car.h_cg > 0.0),
            share(|car| car.actuator_lag > 0.0),
            share(|car| car.wheelbase() < 0.6),
        ] {
            assert!((70..=130).contains(&count), "{count} of 200");
        }
    }
}
