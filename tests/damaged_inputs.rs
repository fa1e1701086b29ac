//! Damaged files: each is refused with what was found, what is allowed, and where.

#![allow(clippy::unwrap_used)]

use std::sync::Arc;

use controller::{Config, ConfigError, Controller, DataError, LapKind};
use file_check::check_text;
use lmpc_tests::{Drive, barc, l_track};
use vehicle_model::{CarParams, ModelError, Track};

/// Every one of `words` stands in the message.
fn says(message: &str, words: &[&str]) {
    for word in words {
        assert!(message.contains(word), "no `{word}` in: {message}");
    }
}

#[test]
fn configurations() {
    let cases: [(&str, &[&str]); 7] = [
        ("[horizon]\nstepz = 12", &["line 2", "column 1", "stepz", "nearest", "steps"]),
        ("[horizon]\nsteps = \"many\"", &["line 2", "column 9", "many"]),
        ("[horizon]\nsteps = 1", &["horizon.steps", "1 is out of range", "2 to 200"]),
        ("[cost]\ncontrol_rate = nan", &["cost.control_rate", "NaN", "0 to 1000000"]),
        ("preset = \"fast\"", &["line 1", "fast", "paper"]),
        ("[regression]\nmetric = [1.0, 2.0]", &["line 2", "metric"]),
        ("[horizon\nsteps = 12", &["line 1"]),
    ];
    for (text, words) in cases {
        let error = Config::from_toml(text).unwrap_err();
        says(&error.to_string(), words);
    }
    assert!(Config::from_toml("[horizon]\nsteps = 12").is_ok());
}

#[test]
fn two_problems_are_told_at_once() {
    let text = "[horizon]\nsteps = 1\n\n[safe_set]\nlaps = 99\n";
    let error = Config::from_toml(text).unwrap_err();
    assert!(matches!(&error, ConfigError::Values(problems) if problems.len() == 2), "{error}");
    says(&error.to_string(), &["horizon.steps", "safe_set.laps", "99"]);
    // With the lines, and unknown keys beside values.
    let checked = check_text("c.toml", "[horizon]\nsteps = 1\nstepz = 3\n[safe_set]\nlaps = 99\n");
    let lines: Vec<_> = checked.problems.iter().map(|problem| problem.line).collect();
    assert_eq!(lines, [Some(2), Some(3), Some(5)], "{:?}", checked.problems);
}

#[test]
fn a_configuration_that_does_not_fit_the_track() {
    let mut config = Config::default();
    config.limits.lane_margin = 0.6;
    let error = Controller::new(config, barc(0.9), l_track()).err().unwrap();
    says(&error.to_string(), &["lane_margin_m = 0.6", "\"l\"", "1.1 m", "less than 0.55"]);
}

/// A stadium with one number replaced.
fn stadium(found: &str, replaced: &str) -> String {
    let good = "name = \"stadium\"\nwidth_left_m = 4.5\nwidth_right_m = 4.5\n\n\
                [[segment]]\nlength_m = 100.0\n\n[[segment]]\nradius_m = 20.0\nangle_deg = 180.0\n\n\
                [[segment]]\nlength_m = 100.00\n\n[[segment]]\nradius_m = 20.00\nangle_deg = 180.0\n";
    assert!(good.contains(found));
    good.replacen(found, replaced, 1)
}

#[test]
fn tracks() {
    assert!(Track::from_toml(&stadium("", "")).is_ok());
    let cases: [(&str, &str, &[&str]); 6] = [
        ("length_m = 100.00", "length_m = 90.0", &["open track", "10", "expected a closed path"]),
        ("radius_m = 20.0\n", "radius_m = 4.0\n", &["too narrow a bend", "4.000", "4.500"]),
        ("width_left_m = 4.5", "width_left_m = nan", &["line 2", "nan", "width"]),
        ("radius_m = 20.0\n", "radius_m = inf\n", &["line 9", "inf", "expected"]),
        ("angle_deg", "angel_deg", &["line 8", "radius_m without angle_deg", "expected"]),
        (
            "length_m = 100.0\n",
            "length_m = \"far\"\n",
            &["line 6, column 12", "string", "a number above 0"],
        ),
    ];
    for (found, replaced, words) in cases {
        let error = Track::from_toml(&stadium(found, replaced)).unwrap_err();
        says(&error.to_string(), words);
    }
    // A figure of eight crosses itself on a bridge; a lap driven twice runs over itself.
    let eight = "name = \"8\"\nwidth_left_m = 4.0\nwidth_right_m = 4.0\n\
                 [[segment]]\nlength_m = 20.0\n[[segment]]\nradius_m = 30.0\nangle_deg = 270.0\n\
                 [[segment]]\nlength_m = 60.0\n[[segment]]\nradius_m = -30.0\nangle_deg = 270.0\n\
                 [[segment]]\nlength_m = 40.0\n";
    assert_eq!(Track::from_toml(eight).unwrap().bridges().len(), 1);
    let half = "[[segment]]\nlength_m = 100.0\n[[segment]]\nradius_m = 20.0\nangle_deg = 180.0\n";
    let twice =
        format!("name = \"2\"\nwidth_left_m = 4.0\nwidth_right_m = 4.0\n{}", half.repeat(4));
    let error = Track::from_toml(&twice).unwrap_err();
    says(&error.to_string(), &["crosses itself", "meets", "s = "]);
}

/// A centre line of points as text, with one line replaced.
fn circle(line: usize, replaced: &str) -> String {
    let mut lines = vec!["# x_m, y_m, w_tr_right_m, w_tr_left_m".to_owned()];
    lines.extend((0..60).map(|i| {
        let (sin, cos) = (std::f64::consts::TAU * f64::from(i) / 60.0).sin_cos();
        format!("{:.6}, {:.6}, 4.0, 4.0", 50.0 * cos, 50.0 * sin)
    }));
    if line > 0 {
        replaced.clone_into(&mut lines[line - 1]);
    }
    lines.join("\n")
}

#[test]
fn tracks_of_points() {
    assert!(Track::parse("circle.csv", &circle(0, "")).is_ok());
    let cases: [(&str, &[&str]); 5] = [
        ("49.7, 5.2, 4.0", &["line 3", "3", "expected", "4"]),
        ("nan, 5.2, 4.0, 4.0", &["line 3", "nan", "expected a"]),
        ("49.7, 5.2, -4.0, 4.0", &["line 3", "-4", "width above 0 m"]),
        ("49.7, left, 4.0, 4.0", &["line 3, column 7", "left", "expected a"]),
        ("-300.0, 5.2, 4.0, 4.0", &["line 3", "from the line through its neighbours"]),
    ];
    for (replaced, words) in cases {
        let error = Track::parse("circle.csv", &circle(3, replaced)).unwrap_err();
        says(&error.to_string(), words);
    }
    let half: Vec<_> = circle(0, "").lines().take(30).map(str::to_owned).collect();
    says(&Track::parse("half.csv", &half.join("\n")).unwrap_err().to_string(), &["open track"]);
    says(&Track::parse("none.csv", "").unwrap_err().to_string(), &["expected"]);
}

#[test]
fn cars() {
    let good = include_str!("../cars/barc.toml");
    let cases: [(&str, &str, &[&str]); 5] = [
        ("mass_kg = 2.2187", "mass_kg = -2.0", &["line 7", "mass_kg", "-2", "above 0"]),
        ("mass_kg = 2.2187", "mass = 2.2187", &["line 7", "mass"]),
        ("l_f_m = 0.13", "l_f_m = true", &["line 9", "l_f_m", "true"]),
        ("a_min_mps2 = -2.0", "a_min_mps2 = 2.0", &["a_min_mps2", "found 2", "below 0"]),
        ("mu = 0.9", "mu = nan", &["tyre_front.mu", "NaN", "above 0"]),
    ];
    for (found, replaced, words) in cases {
        assert!(good.contains(found), "{found}");
        let error = CarParams::from_toml(&good.replacen(found, replaced, 1)).unwrap_err();
        says(&error.to_string(), words);
    }
    let two = good.replace("mass_kg = 2.2187", "mass_kg = 0").replace("= 0.436", "= 9");
    let error = CarParams::from_toml(&two).unwrap_err();
    assert!(matches!(&error, ModelError::CarInvalid(problems) if problems.len() == 2), "{error}");
    says(&CarParams::builtin("tank").unwrap_err().to_string(), &["tank", "barc"]);
}

#[test]
fn learned_data() {
    let mut drive = Drive::new(Config::default());
    drive.until(LapKind::Warmup, 1);
    let saved = drive.controller.save();
    let fresh = || Controller::new(Config::default(), barc(1.2), l_track()).unwrap();
    assert!(fresh().load(&saved).is_ok());

    let refused = |mut controller: Controller, bytes: &[u8]| {
        let before = controller.save();
        let error = controller.load(bytes).unwrap_err();
        assert_eq!(controller.save(), before, "{error}: nothing is changed");
        error
    };
    // Cut anywhere, or grown.
    for cut in [0, 5, 8, 20, 24, 100, saved.len() - 1] {
        let error = refused(fresh(), &saved[..cut]);
        let fits = matches!(error, DataError::Length { .. } | DataError::Magic { .. });
        assert!(fits, "cut at {cut}: {error}");
    }
    let mut grown = saved.clone();
    grown.push(0);
    assert!(matches!(refused(fresh(), &grown), DataError::Length { .. }));
    // One bit anywhere.
    for at in (0..saved.len()).step_by(saved.len() / 97) {
        let mut flipped = saved.clone();
        flipped[at] ^= 1 << (at % 8);
        let error = refused(fresh(), &flipped);
        assert_ne!(at >= 24, matches!(error, DataError::Magic { .. }), "byte {at}: {error}");
        assert!(at < 24 || matches!(error, DataError::Checksum { .. }), "byte {at}: {error}");
    }
    // Another version, a foreign file.
    let mut newer = saved.clone();
    newer[8] += 1;
    let found = format!("format {}", newer[8]);
    let read = format!("reads format {}", saved[8]);
    says(&refused(fresh(), &newer).to_string(), &[&found, &read]);
    says(&refused(fresh(), b"PNG not learned data at all").to_string(), &["LMPCDATA"]);
    // Of another car, track or configuration.
    let of = |config: Config, car: CarParams, track: Track| {
        Controller::new(config, car, Arc::new(track)).unwrap()
    };
    let l = || Track::builtin("l").unwrap();
    let cases = [
        (of(Config::default(), barc(1.1), l()), ["another car", "fingerprint"]),
        (
            of(Config::default(), barc(1.2), Track::builtin("road_course").unwrap()),
            ["another track", "fingerprint"],
        ),
        (
            of(Config::from_toml("[horizon]\nsteps = 14").unwrap(), barc(1.2), l()),
            ["another configuration", "`steps = 15` in the data, `steps = 14` here"],
        ),
    ];
    for (controller, words) in cases {
        says(&refused(controller, &saved).to_string(), &words);
    }
    // Another seed of the initial laps is another trial of the same thing.
    let seeded = Config::from_toml("[warm_up]\nseed = 9").unwrap();
    assert!(of(seeded, barc(1.2), l()).load(&saved).is_ok());
}
