//! `lmpc track`: what it prints and writes.

#![allow(clippy::unwrap_used)]

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use vehicle_model::{CarParams, Track, track};

fn lmpc(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_lmpc")).current_dir(folder).args(arguments).output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// A fresh folder with a noisy circle of 60 points on a radius of 20 m, and its spiky points.
fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    let mut csv = "# x_m,y_m,w_tr_right_m,w_tr_left_m\n".to_owned();
    let mut plain = String::new();
    for i in 0..60 {
        let (sin, cos) = (std::f64::consts::TAU * f64::from(i) / 60.0).sin_cos();
        let radius = if i % 2 == 0 { 20.05 } else { 19.95 };
        let (x, y) = (radius * cos, radius * sin);
        writeln!(csv, "{x},{y},4.0,4.0").unwrap();
        writeln!(plain, "{x},{y}").unwrap();
    }
    fs::write(folder.join("circle.csv"), csv).unwrap();
    fs::write(folder.join("plain.csv"), plain).unwrap();
    folder
}

#[test]
fn show_lists_what_was_changed_and_draws_it() {
    let folder = folder("track_show");
    let output = lmpc(&folder, &["track", "show", "circle.csv", "--out", "track.html"]);
    let printed = text(&output.stdout);
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert!(printed.contains("smoothed 60 points with a noise of 0.0"), "{printed}");
    let page = fs::read_to_string(folder.join("track.html")).unwrap();
    for part in ["kappa [1/m]", "psi [rad]", "distance to the edge", "smoothed 60 points", "given"]
    {
        assert!(page.contains(part), "{part}");
    }
    assert!(!page.contains("NaN"));
    let output = lmpc(&folder, &["track", "show", "circle.csv", "--smooth", "0"]);
    assert!(text(&output.stdout).contains("nothing changed"), "{}", text(&output.stdout));
}

#[test]
fn convert_writes_the_track_that_is_raced() {
    let folder = folder("track_convert");
    let output = lmpc(&folder, &["track", "convert", "circle.csv", "circle.toml"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let [csv, toml] =
        ["circle.csv", "circle.toml"].map(|f| fs::read_to_string(folder.join(f)).unwrap());
    let (from, to) = (Track::parse("circle.csv", &csv).unwrap(), Track::from_toml(&toml).unwrap());
    assert_eq!(from, to);
    // A file without widths needs one.
    let output = lmpc(&folder, &["track", "convert", "plain.csv", "plain.toml"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(text(&output.stderr).contains("--width"), "{}", text(&output.stderr));
    let output = lmpc(&folder, &["track", "convert", "plain.csv", "plain.toml", "--width", "8"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let plain = fs::read_to_string(folder.join("plain.toml")).unwrap();
    assert_eq!(Track::from_toml(&plain).unwrap().fingerprint(), to.fingerprint());
}

#[test]
fn random_writes_the_seeds_track() {
    let folder = folder("track_random");
    let arguments = ["track", "random", "--car", "kart", "--seed", "3", "--out", "r.toml"];
    let output = lmpc(&folder, &arguments);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let read = Track::from_toml(&fs::read_to_string(folder.join("r.toml")).unwrap()).unwrap();
    assert_eq!(read, track::random(3, &CarParams::builtin("kart").unwrap()).unwrap());
}

#[test]
fn a_car_too_wide_for_the_track_is_refused_with_the_place() {
    let folder = folder("track_narrow");
    let arguments = ["track", "show", "plain.csv", "--width", "0.5", "--smooth", "0"];
    let output = lmpc(&folder, &[&arguments[..], &["--car", "barc"]].concat());
    assert!(output.status.success(), "{}", text(&output.stdout));
    let output = lmpc(&folder, &[&arguments[..], &["--car", "iac"]].concat());
    assert_eq!(output.status.code(), Some(1));
    assert!(text(&output.stdout).contains("too narrow at s = "), "{}", text(&output.stdout));
    let output = lmpc(&folder, &["track", "convert", "plain.csv", "thin.toml", "--width", "0.5"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let output = lmpc(&folder, &["race", "--car", "iac", "--track", "thin.toml"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(text(&output.stderr).contains("too narrow at s = "), "{}", text(&output.stderr));
}

#[test]
fn a_figure_of_eight_is_raced() {
    let folder = folder("track_eight");
    let straight = |length: f64| format!("[[segment]]\nlength_m = {length}\n");
    let bend = |radius: f64| format!("[[segment]]\nradius_m = {radius}\nangle_deg = 270.0\n");
    let eight = [
        "name = \"eight\"\nwidth_left_m = 0.55\nwidth_right_m = 0.55\n".to_owned(),
        straight(1.5),
        bend(2.0),
        straight(4.0),
        bend(-2.0),
        straight(2.5),
    ];
    fs::write(folder.join("eight.toml"), eight.concat()).unwrap();
    let race = ["race", "--car", "barc", "--track", "eight.toml", "--laps", "20", "--out", "out"];
    let output = lmpc(&folder, &[&race[..], &["--plant", "noise=0.001"]].concat());
    assert!(output.status.success(), "{}", text(&output.stdout));
    let printed = text(&output.stdout);
    assert!(printed.contains("  24  learning") && printed.contains("best lap 5."), "{printed}");
}

#[test]
fn a_race_says_what_its_track_file_was_changed_to() {
    let folder = folder("track_race");
    // Learned data that does not exist ends it before the first lap.
    let race = ["race", "--car", "kart", "--track", "circle.csv", "--load", "none.lmpc"];
    let output = lmpc(&folder, &race);
    assert!(text(&output.stderr).contains("smoothed 60 points"), "{}", text(&output.stderr));
}
