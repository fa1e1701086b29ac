//! Numbers of a car file that do not belong together: one of them is in another unit.

use super::{CarParams, ParamProblem};
use std::f64::consts::FRAC_PI_2;

/// Wheelbase in lengths of the body: least and most.
const WHEELBASE: (f64, f64) = (0.2, 1.25);
/// Width in lengths of the body: least and most.
const WIDTH: (f64, f64) = (0.05, 2.0);
/// Radius of gyration about the vertical axis in wheelbases: least and most.
const GYRATION: (f64, f64) = (0.05, 1.5);
/// Largest friction coefficient; dragsters reach 4.
const MOST_MU: f64 = 5.0;
/// Largest acceleration and deceleration, ten times gravity [m/s^2].
const MOST_ACCELERATION: f64 = 100.0;

/// The unit mistakes of a car whose numbers are in their ranges.
pub(super) fn mistakes(car: &CarParams) -> Vec<ParamProblem> {
    let wheelbase = car.wheelbase();
    let gyration = (car.inertia_z / car.mass).sqrt() / wheelbase;
    let inside = |share: f64, range: (f64, f64)| (range.0..=range.1).contains(&share);
    let checks = [
        (
            "length_m",
            inside(wheelbase / car.length, WHEELBASE),
            format!("{} beside a wheelbase of {wheelbase}", car.length),
            "0.8 to 5 times the wheelbase l_f_m + l_r_m; lengths are in m",
        ),
        (
            "width_m",
            inside(car.width / car.length, WIDTH),
            format!("{} beside a length of {}", car.width, car.length),
            "0.05 to 2 times length_m; lengths are in m",
        ),
        (
            "h_cg_m",
            car.h_cg <= wheelbase,
            format!("{} beside a wheelbase of {wheelbase}", car.h_cg),
            "at most the wheelbase; lengths are in m",
        ),
        (
            "inertia_z_kgm2",
            inside(gyration, GYRATION),
            format!("{:e} beside a mass of {:e} kg", car.inertia_z, car.mass),
            "the mass times the square of 0.05 to 1.5 wheelbases; it is in kg m^2",
        ),
        (
            "a_min_mps2",
            -car.a_min <= MOST_ACCELERATION,
            car.a_min.to_string(),
            "at least -100 m/s^2",
        ),
        ("a_max_mps2", car.a_max <= MOST_ACCELERATION, car.a_max.to_string(), "at most 100 m/s^2"),
    ];
    let mut problems: Vec<ParamProblem> = checks
        .into_iter()
        .filter(|check| !check.1)
        .map(|(key, _, found, expected)| ParamProblem {
            section: "",
            key,
            found,
            expected,
            line: None,
        })
        .collect();
    for (section, tyre) in [("tyre_front", &car.tyre_front), ("tyre_rear", &car.tyre_rear)] {
        if tyre.mu > MOST_MU {
            let (found, expected) = (tyre.mu.to_string(), "a coefficient of at most 5");
            problems.push(ParamProblem { section, key: "mu", found, expected, line: None });
        }
        let peak = tyre.peak_slip();
        if peak > FRAC_PI_2 && peak.is_finite() {
            let found = format!("{} with a peak at {peak:.1} rad of slip", tyre.b);
            let expected = "one below pi/2; stiffness is per radian, 57.3 times that per degree";
            problems.push(ParamProblem { section, key: "b", found, expected, line: None });
        }
    }
    problems
}
