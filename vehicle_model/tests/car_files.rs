//! Car files: what ships, and what a user may get wrong.

#![allow(clippy::unwrap_used)]

use vehicle_model::{CarParams, ModelError, params::GRAVITY};

const BARC: &str = include_str!("../../cars/barc.toml");

#[test]
fn every_builtin_car_is_valid_and_differs() {
    let mut seen = Vec::new();
    for name in CarParams::builtin_names() {
        let car = CarParams::builtin(name).unwrap();
        assert_eq!(car.name, name);
        assert_eq!(car.validate(), []);
        assert!(!seen.contains(&car.fingerprint()));
        seen.push(car.fingerprint());
    }
    let unknown = CarParams::builtin("tank").unwrap_err().to_string();
    assert!(unknown.contains("tank") && unknown.contains("barc, iac, kart, mini"), "{unknown}");
}

#[test]
fn fingerprint_sees_numbers_and_switches_but_not_the_name() {
    let car = CarParams::builtin("barc").unwrap();
    let renamed = CarParams { name: "other".into(), ..car.clone() };
    assert_eq!(car.fingerprint(), renamed.fingerprint());
    let others = [
        car.clone().with_mu(0.901),
        CarParams { combined_slip: true, ..car.clone() },
        CarParams { front_force_yaw: false, ..car.clone() },
        CarParams { a_rate_max: Some(40.0), ..car.clone() },
        CarParams { power_max: Some(40.0), ..car.clone() },
        car.clone().without_blend(),
    ];
    for other in &others {
        assert_ne!(other.fingerprint(), car.fingerprint());
    }
}

/// The value is part of the format of learned data: it may not move between versions or machines.
#[test]
fn fingerprint_is_fnv_1a_over_the_fields() {
    let car = CarParams::builtin("barc").unwrap();
    let none = f64::INFINITY;
    let fields: [f64; 34] = [
        2.2187, 0.02723, 0.13, 0.13, 5.0, 2.28, 0.9, 5.0, 2.28, 0.9, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0,
        0.0, 0.0, 0.0, 0.0, none, none, none, 0.37, 0.195, -2.0, 2.0, 0.436, none, none, 0.0, 0.0,
        0.3, 0.8,
    ];
    let words = fields.map(f64::to_bits).into_iter().chain([1, 0]);
    let hash = words.flat_map(u64::to_le_bytes).fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3)
    });
    assert_eq!(car.fingerprint(), hash);
}

#[test]
fn friction_of_the_small_car_gives_its_peak_forces_back() {
    let car = CarParams::builtin("mini").unwrap();
    let front = 0.041 * GRAVITY * 0.033 / 0.062;
    let rear = 0.041 * GRAVITY * 0.029 / 0.062;
    assert!((car.tyre_front.mu * front - 0.192).abs() < 1e-15);
    assert!((car.tyre_rear.mu * rear - 0.1737).abs() < 1e-15);
    let [static_front, static_rear] = car.static_loads();
    assert!((static_front - front).abs() < 1e-15 && (static_rear - rear).abs() < 1e-15);
}

#[test]
fn all_bad_values_are_named_at_once_with_their_lines() {
    let text = BARC
        .replace("mass_kg = 2.2187", "mass_kg = -1.0")
        .replace("delta_max_rad = 0.436", "delta_max_rad = 25.0")
        .replacen("c = 2.28", "c = 0.0", 1);
    let Err(ModelError::CarInvalid(problems)) = CarParams::from_toml(&text) else {
        unreachable!("three values are out of range")
    };
    let line = |start: &str| text.lines().position(|line| line.starts_with(start)).unwrap() + 1;
    let found: Vec<_> = problems.iter().map(|p| (p.section, p.key, p.line.unwrap())).collect();
    assert_eq!(
        found,
        [
            ("", "mass_kg", line("mass_kg")),
            ("", "delta_max_rad", line("delta_max_rad")),
            ("tyre_front", "c", line("c =")),
        ]
    );
    let message = ModelError::CarInvalid(problems).to_string();
    assert!(message.contains("mass_kg: found -1, expected a number above 0"), "{message}");
}

/// Each is in its range, and no car has it.
#[test]
fn absurd_values_are_named_with_what_is_plausible() {
    let with = |line: &str| format!("{line}\n{BARC}");
    let replaced = |from: &str, to: &str| BARC.replacen(from, to, 1);
    let cases = [
        (
            replaced("delta_max_rad = 0.436", "delta_max_rad = 1.5"),
            "delta_max_rad: found 1.5, expected an angle of the wheels above 0 and at most 1.2 rad",
        ),
        (
            replaced("mass_kg = 2.2187", "mass_kg = 1e9").replace("0.02723", "1e7"),
            "mass_kg: found 1000000000",
        ),
        (
            BARC.replace("= 0.13 ", "= 1e-6 ")
                .replace("0.02723", "1e-12")
                .replace("0.37 ", "3e-6 ")
                .replace("0.195", "1e-6"),
            "l_f_m: found 0.000001",
        ),
        (
            replaced("mu = 0.9", "mu = 1e-9"),
            "tyre_front.mu: found 0.000000001, expected a coefficient of at least",
        ),
        (replaced("c = 2.28", "c = 1e-3"), "tyre_front.c: found 0.001, expected a shape factor"),
        (replaced("c = 2.28", "c = 40.0"), "tyre_front.c: found 40"),
        (replaced("b = 5.0", "b = 1e6"), "tyre_front.b: found 1000000 with c = 2.28"),
        (
            with("power_max_w = 0.08"),
            "power_max_w: found 0.08, expected at least 0.1 for each kilogram; it is in W, not in kW",
        ),
        (with("drive_force_max_n = 1e-3"), "drive_force_max_n: found 0.001"),
        (with("brake_force_max_n = 1e-3"), "brake_force_max_n: found 0.001"),
        (with("speed_max_mps = 1e-3"), "speed_max_mps: found 0.001"),
        (with("delta_rate_max_radps = 1e-9"), "delta_rate_max_radps: found 0.000000001"),
        (with("a_rate_max_mps3 = 1e-9"), "a_rate_max_mps3: found 0.000000001"),
        (
            with("actuator_lag_s = 50.0"),
            "actuator_lag_s: found 50, expected at most 10; it is in s",
        ),
        (with("actuator_delay_s = 20.0"), "actuator_delay_s: found 20"),
        (with("rolling = 0.5"), "rolling: found 0.5, expected less than what the engine gives"),
        (with("linear_drag_per_s = 1e9"), "linear_drag_per_s: found 1000000000"),
        (with("cd = 1e9\narea_m2 = 0.01\nrho_kgpm3 = 1.2"), "cd: found 1000000000"),
        (with("cd = 1.0\narea_m2 = 100.0\nrho_kgpm3 = 1.2"), "area_m2: found 100"),
        (with("cd = 1.0\narea_m2 = 0.01\nrho_kgpm3 = 1200.0"), "rho_kgpm3: found 1200"),
        (
            replaced("blend_speed_high_mps = 0.8", "blend_speed_high_mps = 1e6"),
            "blend_speed_high_mps: found 1000000",
        ),
    ];
    for (text, expected) in cases {
        let message = CarParams::from_toml(&text).unwrap_err().to_string();
        assert!(message.contains(expected), "expected '{expected}' in: {message}");
        assert!(message.starts_with("car file: line "), "{message}");
    }
}

#[test]
fn the_sign_of_zero_is_no_part_of_a_car() {
    let car = CarParams::from_toml(BARC).unwrap();
    let negative = BARC.replace("drive_front = 0.0", "drive_front = -0.0");
    assert_ne!(negative, BARC);
    let negative = CarParams::from_toml(&negative).unwrap();
    assert_eq!(negative.fingerprint(), car.fingerprint());
    assert_eq!(negative.drive_front.to_bits(), 0.0_f64.to_bits());
}

#[test]
fn damaged_files_say_what_is_wrong() {
    let cases = [
        (BARC.replace("mass_kg", "mass"), "unknown key `mass`, the nearest known one is `mass_kg`"),
        (BARC.replace("l_f_m = 0.13", "l_f_m = \"far\""), "expected f64"),
        (BARC.replace("width_m = 0.195", ""), "missing field `width_m`"),
        (BARC.replacen("mu = 0.9 ", "peak_n = 9.8\nmu = 0.9 ", 1), "either mu or peak_n"),
        (BARC.replacen("mu = 0.9 ", "# ", 1), "either mu or peak_n"),
        (BARC.replace("blend_speed_low_mps = 0.3", "blend_speed_low_mps = 1.0"), "below blend"),
        (BARC.replace("a_max_mps2 = 2.0", "a_max_mps2 = nan"), "a_max_mps2: found NaN"),
        (format!("cd = 0.5\n{BARC}"), "area_m2: found 0"),
        ("mass_kg = ".to_owned(), "line 1"),
    ];
    for (text, expected) in cases {
        let message = CarParams::from_toml(&text).unwrap_err().to_string();
        assert!(message.contains(expected), "expected '{expected}' in: {message}");
    }
}

/// The published stiffness of the linear tyre is the slope of the curve at 0, per friction.
#[test]
fn published_cornering_stiffness_is_the_slope_of_the_tyre_curve() {
    for (name, front, rear) in [("f1tenth", 4.718, 5.4562), ("road", 20.89, 20.89)] {
        let car = CarParams::builtin(name).unwrap();
        for (tyre, published) in [(&car.tyre_front, front), (&car.tyre_rear, rear)] {
            let alpha = 1e-6_f64;
            let slope = (tyre.c * (tyre.b * alpha).atan()).sin() / alpha;
            assert!((slope / published - 1.0).abs() < 1e-4, "{name}: {slope}");
        }
        let switch = car.power_max.unwrap() / (car.mass * car.a_max);
        assert!((switch - 7.319).abs() < 1e-2, "{name}: {switch}");
    }
}

#[test]
fn numbers_in_another_unit_are_named_with_what_they_do_not_fit() {
    for name in CarParams::builtin_names() {
        assert!(CarParams::builtin(name).is_ok(), "{name}");
    }
    let cases = [
        ("l_f_m = 0.13 ", "l_f_m = 130 ", "length_m: found 0.37 beside a wheelbase of 130.13"),
        ("length_m = 0.37", "length_m = 370", "length_m: found 370 beside a wheelbase of 0.26"),
        ("width_m = 0.195", "width_m = 19.5", "width_m: found 19.5 beside a length of 0.37"),
        ("0.02723", "27.23", "inertia_z_kgm2: found 2.723e1 beside a mass"),
        ("2.2187", "1e300", "inertia_z_kgm2: found 2.723e-2 beside a mass of 1e300 kg"),
        ("a_max_mps2 = 2.0", "a_max_mps2 = 2000.0", "a_max_mps2: found 2000, expected at most 100"),
        ("mu = 0.9 ", "mu = 90 ", "tyre_front.mu: found 90, expected a coefficient of at most 5"),
        ("b = 5.0 ", "b = 0.087 ", "a peak at 9.5 rad of slip, expected one below pi/2"),
        ("width_m", "h_cg_m = 74\nwidth_m", "h_cg_m: found 74 beside a wheelbase of 0.26"),
    ];
    for (from, to, expected) in cases {
        let message = CarParams::from_toml(&BARC.replacen(from, to, 1)).unwrap_err().to_string();
        assert!(message.contains(expected) && message.contains("line "), "{to}: {message}");
    }
}
