//! Numbers of a car file that no car has, or that do not belong together: one of them is in another
//! unit.

use super::{CarParams, GRAVITY, ParamProblem};
use std::f64::consts::FRAC_PI_2;

/// Wheelbase in lengths of the body: least and most.
const WHEELBASE: (f64, f64) = (0.2, 1.25);
/// Width in lengths of the body: least and most.
const WIDTH: (f64, f64) = (0.05, 2.0);
/// Radius of gyration about the vertical axis in wheelbases: least and most.
const GYRATION: (f64, f64) = (0.05, 1.5);
/// Mass, from a walnut to the largest trucks \[kg\].
const MASS: (f64, f64) = (1e-3, 1e6);
/// Wheelbase, from a toy to the longest lorries \[m\].
const WHEELBASE_M: (f64, f64) = (5e-3, 50.0);
/// Friction coefficient: half of wet ice has 0.02, dragsters reach 4.
const MU: (f64, f64) = (0.01, 5.0);
/// Shape factor C: a tyre whose curve ends far below its peak, or beyond zero, is not a tyre's.
const SHAPE: (f64, f64) = (0.3, 4.0);
/// Largest slope of the lateral force at zero slip, in peak forces per radian; racing tyres reach 40.
const MOST_SLOPE: f64 = 200.0;
/// Least force and power of engine and brakes for each kilogram [N/kg, W/kg].
const LEAST_PER_KG: f64 = 0.1;
/// Longest time constant and delay of actuators, and least rate of a limit as shares of its range \[s\].
const SLOWEST: f64 = 10.0;
/// Largest acceleration and deceleration, ten times gravity [m/s^2].
const MOST_ACCELERATION: f64 = 100.0;

/// The unit mistakes of a car whose numbers are in their ranges.
pub(super) fn mistakes(car: &CarParams) -> Vec<ParamProblem> {
    let wheelbase = car.wheelbase();
    let gyration = (car.inertia_z / car.mass).sqrt() / wheelbase;
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
    problems.extend(beyond(car));
    for (section, tyre) in [("tyre_front", &car.tyre_front), ("tyre_rear", &car.tyre_rear)] {
        let mut problem = |key, found: String, expected| {
            problems.push(ParamProblem { section, key, found, expected, line: None });
        };
        if tyre.mu > MU.1 {
            problem("mu", tyre.mu.to_string(), "a coefficient of at most 5");
        }
        if tyre.mu < MU.0 {
            problem("mu", tyre.mu.to_string(), "a coefficient of at least 0.01");
        }
        if !inside(tyre.c, SHAPE) {
            problem("c", tyre.c.to_string(), "a shape factor of 0.3 to 4");
        }
        if tyre.b * tyre.c > MOST_SLOPE {
            let found = format!("{} with c = {}", tyre.b, tyre.c);
            problem("b", found, "a slope b c of at most 200 peak forces per radian");
        }
        let peak = tyre.peak_slip();
        if peak > FRAC_PI_2 && peak.is_finite() {
            let found = format!("{} with a peak at {peak:.1} rad of slip", tyre.b);
            let expected = "one below pi/2; stiffness is per radian, 57.3 times that per degree";
            problem("b", found, expected);
        }
    }
    problems
}

fn inside(value: f64, range: (f64, f64)) -> bool {
    (range.0..=range.1).contains(&value)
}

/// What no car has, whatever its size.
fn beyond(car: &CarParams) -> Vec<ParamProblem> {
    let wheelbase = car.wheelbase();
    // An engine that does not overcome the rolling resistance drives nowhere.
    let push = car.drive_force_max.map_or(f64::INFINITY, |force| force / car.mass).min(car.a_max);
    let strong = |value: Option<f64>| value.is_none_or(|value| value >= LEAST_PER_KG * car.mass);
    let quick = |rate: Option<f64>, range: f64| rate.is_none_or(|rate| rate * SLOWEST >= range);
    let slowest = 0.2 * (GRAVITY * wheelbase).sqrt();
    let per_kg = "at least 0.1 for each kilogram; it is in N";
    let in_ten = "a rate that covers the range of the input in 10 s";
    let seconds = "at most 10; it is in s";
    let air = "at most 50";
    let checks: [(&'static str, bool, Option<f64>, &'static str); 18] = [
        ("mass_kg", inside(car.mass, MASS), Some(car.mass), "0.001 to 1e6 kg"),
        (
            "l_f_m",
            inside(wheelbase, WHEELBASE_M),
            Some(car.l_f),
            "with l_r_m a wheelbase of 0.005 to 50 m",
        ),
        ("cd", car.cd <= 50.0, Some(car.cd), air),
        ("cl_front", car.cl_front <= 50.0, Some(car.cl_front), air),
        ("cl_rear", car.cl_rear <= 50.0, Some(car.cl_rear), air),
        (
            "area_m2",
            car.area <= 10.0 * car.length * car.width,
            Some(car.area),
            "at most 10 times length_m times width_m; it is in m^2",
        ),
        ("rho_kgpm3", car.rho <= 100.0, Some(car.rho), "at most 100; air at sea level has 1.2"),
        (
            "rolling",
            car.rolling * GRAVITY < push,
            Some(car.rolling),
            "less than what the engine gives, a_max_mps2 or drive_force_max_n, over weight",
        ),
        ("linear_drag_per_s", car.linear_drag <= 100.0, Some(car.linear_drag), "at most 100"),
        (
            "power_max_w",
            strong(car.power_max),
            car.power_max,
            "at least 0.1 for each kilogram; it is in W, not in kW",
        ),
        ("drive_force_max_n", strong(car.drive_force_max), car.drive_force_max, per_kg),
        ("brake_force_max_n", strong(car.brake_force_max), car.brake_force_max, per_kg),
        (
            "speed_max_mps",
            car.speed_max.is_none_or(|speed| speed >= slowest),
            car.speed_max,
            "at least 0.2 sqrt(g l), below which no tyre works",
        ),
        (
            "delta_rate_max_radps",
            quick(car.delta_rate_max, car.delta_max),
            car.delta_rate_max,
            in_ten,
        ),
        ("a_rate_max_mps3", quick(car.a_rate_max, car.a_max), car.a_rate_max, in_ten),
        ("actuator_lag_s", car.actuator_lag <= SLOWEST, Some(car.actuator_lag), seconds),
        ("actuator_delay_s", car.actuator_delay <= SLOWEST, Some(car.actuator_delay), seconds),
        (
            "blend_speed_high_mps",
            car.blend_speed_high <= 100.0 * slowest,
            Some(car.blend_speed_high),
            "at most 20 sqrt(g l); it is in m/s",
        ),
    ];
    let bad = checks.into_iter().filter(|(_, well, ..)| !well);
    bad.map(|(key, _, found, expected)| ParamProblem {
        section: "",
        key,
        found: found.map_or_else(String::new, |value| value.to_string()),
        expected,
        line: None,
    })
    .collect()
}
