//! `lmpc study tracks`: a small matrix from the command line to its table and page.

#![allow(clippy::unwrap_used, clippy::panic)]

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::{Command, Output};

/// A row of `runs.csv` by the names of its columns.
type Row = BTreeMap<String, String>;

fn study(arguments: &[&str], out: &Path) -> Output {
    Command::new(env!("CARGO_BIN_EXE_lmpc"))
        .args(["study", "tracks"])
        .args(arguments)
        .args(["--out", &out.display().to_string()])
        .output()
        .unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

fn rows(out: &Path) -> Vec<Row> {
    let mut reader = csv::Reader::from_path(out.join("runs.csv")).unwrap();
    reader.deserialize().map(Result::unwrap).collect()
}

/// A row without what differs from run to run on one computer: the times of the steps.
fn without_times(row: &Row) -> Row {
    row.iter()
        .filter(|(name, _)| !name.ends_with("_us"))
        .map(|(n, v)| (n.clone(), v.clone()))
        .collect()
}

#[test]
fn a_small_matrix_is_driven_and_resumed() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("matrix");
    let optima = folder.path().join("optima.csv");
    fs::write(&optima, "car,track,seconds\nbarc,l,3.823\nmini,l,3.974\n").unwrap();
    let optima = optima.display().to_string();
    let cells = ["--car", "barc", "mini", "--track", "l", "--plant", "none", "--plant", "mu=0.8"];
    let size = ["--seeds", "1", "--laps", "3", "--centre-of-gravity", "--optimum", &optima];
    let arguments = [&cells[..], &size].concat();
    let whole = study(&arguments, &out);
    assert_eq!(whole.status.code(), Some(0), "{}{}", text(&whole.stdout), text(&whole.stderr));
    let first = rows(&out);
    assert_eq!(first.len(), 4);
    for row in &first {
        assert_eq!((row["failure"].as_str(), row["laps"].as_str()), ("", "3"), "{row:?}");
        let [best, optimum, ratio] =
            ["best_lap_s", "optimum_s", "ratio"].map(|name| row[name].parse::<f64>().unwrap());
        assert!((ratio - best / optimum).abs() < 1e-12 && ratio > 1.0, "{row:?}");
        let times: Vec<f64> =
            row["lap_times_s"].split(' ').map(|time| time.parse().unwrap()).collect();
        let least = times.iter().copied().fold(f64::INFINITY, f64::min);
        assert!(times.len() == 3 && (least - best).abs() < 1e-3, "{row:?}");
    }
    let page = fs::read_to_string(out.join("matrix.html")).unwrap();
    assert_eq!(page.matches("<td class=\"ok\"").count(), 4, "one cell for each car and plant");

    // As a kill leaves it: two runs missing and a torn line.
    let table = fs::read_to_string(out.join("runs.csv")).unwrap();
    let kept: String = table.lines().take(3).map(|line| format!("{line}\n")).collect();
    fs::write(out.join("runs.csv"), kept + "mini,l,no").unwrap();
    let resumed = study(&[&arguments[..], &["--resume"]].concat(), &out);
    assert!(text(&resumed.stderr).contains("2 kept"), "{}", text(&resumed.stderr));
    let again: Vec<Row> = rows(&out).iter().map(without_times).collect();
    assert_eq!(again, first.iter().map(without_times).collect::<Vec<Row>>());
}

#[test]
fn a_failed_run_has_its_place_and_the_study_ends_with_3() {
    let folder = tempfile::tempdir().unwrap();
    let tracks = folder.path().join("tracks");
    fs::create_dir(&tracks).unwrap();
    fs::write(tracks.join("bend.toml"), include_str!("../../tracks/l.toml")).unwrap();
    fs::write(tracks.join("wrong.csv"), "x_m,y_m\n1,2\n").unwrap();
    let tracks = tracks.display().to_string();
    let out = folder.path().join("out");
    // Without grip the car cannot follow the first bend.
    let slippery = ["--track", &tracks, "--plant", "mu=0.02", "--seeds", "1", "--laps", "1"];
    let run = study(&slippery, &out);
    let said = text(&run.stderr);
    assert_eq!(run.status.code(), Some(3), "{said}");
    assert!(said.contains("wrong.csv") && said.contains("barc on bend, mu=0.02, seed 0"), "{said}");
    let row = &rows(&out)[0];
    assert!(["off_track", "spin"].contains(&row["failure"].as_str()), "{row:?}");
    assert_eq!(row["fail_lap"], "0", "in a warm-up lap: {row:?}");
    assert!(
        row["fail_s_m"].parse::<f64>().unwrap() > 0.0 && row["fail_last_steps"].contains("warm_up")
    );
    let steps = fs::read_to_string(out.join("failures/barc-bend-mu=0.02-0.csv")).unwrap();
    assert!(steps.lines().count() > 10);
    let page = fs::read_to_string(out.join("matrix.html")).unwrap();
    for part in ["\u{2717} 1 of 1", "<figure>", "wrong.csv", "class=\"off\"", "failures/barc-bend"]
    {
        assert!(page.contains(part), "{part}");
    }
}

#[test]
fn the_body_counts_unless_asked_otherwise() {
    // A lane in which the centre of the wandering car stays inside and its sides do not.
    let folder = tempfile::tempdir().unwrap();
    let narrow = include_str!("../../tracks/l.toml");
    let file = folder.path().join("narrow.toml");
    let lines: Vec<String> = narrow
        .lines()
        .map(|line| match line.split_once('=') {
            Some((key, _)) if key.trim().starts_with("width_") => format!("{key}= 0.15"),
            _ => line.to_owned(),
        })
        .collect();
    fs::write(&file, lines.join("\n")).unwrap();
    let file = file.display().to_string();
    let wander = ["--set", "limits.lane_margin_m=0", "--set", "warm_up.noise_delta_rad=0.05"];
    let cell = [&["--track", &file, "--seeds", "1", "--laps", "1"][..], &wander].concat();
    let (body, centre) = (folder.path().join("body"), folder.path().join("centre"));
    assert_eq!(study(&cell, &body).status.code(), Some(3));
    let row = &rows(&body)[0];
    assert_eq!((row["failure"].as_str(), row["fail_lap"].as_str()), ("off_track", "0"));
    study(&[&cell[..], &["--centre-of-gravity"]].concat(), &centre);
    let paper = ["--preset", "paper", "--set", "warm_up.speed_mps=1.2"];
    let (alone, asked) = (folder.path().join("paper"), folder.path().join("paper-body"));
    study(&[&cell[..], &paper].concat(), &alone);
    assert_ne!(rows(&alone)[0]["fail_lap"], "0", "the paper's rule is the centre of gravity");
    assert_eq!(study(&[&cell[..], &paper, &["--body"]].concat(), &asked).status.code(), Some(3));
    let row = &rows(&asked)[0];
    assert_eq!((row["failure"].as_str(), row["fail_lap"].as_str()), ("off_track", "0"));
    let row = &rows(&centre)[0];
    assert_ne!((row["failure"].as_str(), row["fail_lap"].as_str()), ("off_track", "0"), "{row:?}");
}

/// Cars of random numbers learn on tracks of their own with no setting chosen for them.
#[test]
fn random_cars_stay_on_generated_tracks() {
    let folder = tempfile::tempdir().unwrap();
    let cars: Vec<String> = (0..6)
        .map(|seed| {
            let file = folder.path().join(format!("{seed}.toml")).display().to_string();
            let new = ["car", "random", "--seed", &seed.to_string(), "--out", &file];
            let run = Command::new(env!("CARGO_BIN_EXE_lmpc")).args(new).output().unwrap();
            assert_eq!(run.status.code(), Some(0), "{}", text(&run.stderr));
            file
        })
        .collect();
    let cars: Vec<&str> = std::iter::once("--car").chain(cars.iter().map(String::as_str)).collect();
    let size = ["--random", "1", "--random-seed", "40", "--seeds", "1", "--laps", "12"];
    let run = study(&[&cars[..], &size].concat(), &folder.path().join("out"));
    assert_eq!(run.status.code(), Some(0), "{}{}", text(&run.stdout), text(&run.stderr));
}

#[test]
fn generated_tracks_belong_to_each_car() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let size = ["--random", "2", "--random-seed", "7", "--seeds", "1", "--laps", "2"];
    let cars = ["--car", "barc", "mini", "--centre-of-gravity"];
    let run = study(&[&size[..], &cars].concat(), &out);
    assert!(matches!(run.status.code(), Some(0 | 3)), "{}", text(&run.stderr));
    let rows = rows(&out);
    let names: Vec<(&str, &str)> =
        rows.iter().map(|row| (row["car"].as_str(), row["track"].as_str())).collect();
    let wanted = ["barc", "mini"].map(|car| ["random-7", "random-8"].map(|track| (car, track)));
    assert_eq!(names, wanted.concat());
    for row in &rows {
        assert_ne!(row["failure"], "refused", "{row:?}");
        let kept = out.join(format!("failures/{}-{}-none-0.csv", row["car"], row["track"]));
        assert_eq!(kept.exists(), !row["failure"].is_empty(), "{row:?}");
    }
    assert!(rows.iter().all(|row| row["car"] != "barc" || row["laps"] == "2"), "{rows:?}");
    let table = text(&run.stdout);
    assert_eq!(table.matches("(generated)").count(), 2, "one line for each car: {table}");
}
