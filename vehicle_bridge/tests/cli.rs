//! `lmpc` at its process boundary: exit codes, streams, files.
#![allow(clippy::unwrap_used, reason = "a test that cannot set up its files has failed")]

#[path = "common/command.rs"]
mod command;

use std::fs;
use std::path::Path;
use std::process::Output;

use command::{Folder, lmpc, text};

fn race(out: &Path, more: &[&str]) -> Output {
    let out = out.display().to_string();
    lmpc(&[&["race", "--out", &out, "--laps", "2"], more].concat())
}

#[test]
fn help_shows_examples_and_exit_codes() {
    for arguments in [vec!["--help"], vec!["race", "--help"], vec!["study", "--help"]] {
        let output = lmpc(&arguments);
        assert_eq!(output.status.code(), Some(0));
        let help = text(&output.stdout);
        assert!(help.contains("Exit codes") || help.contains("Examples"), "{help}");
    }
    assert!(text(&lmpc(&["--version"]).stdout).starts_with("lmpc "));
    assert!(text(&lmpc(&["completions", "bash"]).stdout).contains("complete -F"));
}

#[test]
fn a_wrong_command_line_is_exit_code_2() {
    for arguments in [
        vec!["race", "--lapz", "3"],
        vec!["race", "--laps", "0"],
        vec!["race", "--set", "horizon.stepz=3"],
        vec!["race", "--set", "horizon.steps=100000"],
        vec!["race", "--bandwidth", "-1"],
        vec!["race", "--plant", "grip=0.9"],
        vec!["race", "--nominal-mu", "0"],
        vec!["study", "everything"],
    ] {
        let output = lmpc(&arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {}", text(&output.stderr));
        assert!(output.stdout.is_empty());
    }
}

#[cfg(not(feature = "foxglove"))]
#[test]
fn a_program_without_the_server_for_foxglove_says_how_to_build_one() {
    let output = lmpc(&["view", "--race", "--foxglove"]);
    assert_eq!(output.status.code(), Some(2));
    let error = text(&output.stderr);
    assert!(error.contains("cargo install ") && error.contains("--features foxglove"), "{error}");
    assert!(output.stdout.is_empty());
}

#[test]
fn wrong_files_are_exit_code_1_and_named() {
    let folder = Folder::new("wrong");
    let config = folder.file("c.toml", "[horizon]\nstepz = 3\n");
    let track = folder.file("t.csv", "# x_m,y_m,w_r,w_l\n0,0,1,1\nnan,0,1,1\n");
    let data = folder.file("d.lmpc", "not learned data");
    let out = folder.0.join("out").display().to_string();
    for (option, file, reason) in [
        ("--config", config.as_str(), "stepz"),
        ("--track", track.as_str(), "line 3"),
        ("--track", "nowhere.csv", "expected a file or one of"),
        ("--car", "nothing", "expected a file or one of"),
        ("--load", data.as_str(), "refused"),
        ("--load", "nowhere.lmpc", "cannot read"),
    ] {
        let output = lmpc(&["race", "--out", &out, option, file]);
        let error = text(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{option} {file}: {error}");
        assert!(error.contains(reason) && error.contains(file), "{option} {file}: {error}");
        assert!(!error.contains("panicked"), "{error}");
    }
}

#[test]
fn race_writes_its_files_the_same_each_time() {
    let folder = Folder::new("race");
    let (one, two) = (folder.0.join("one"), folder.0.join("two"));
    // The margin of the time-optimal lap that ships.
    let margin = ["--set", "limits.lane_margin_m=0.1"];
    let first = race(&one, &margin);
    assert_eq!(first.status.code(), Some(0), "{}", text(&first.stderr));
    assert_eq!(first.stdout.iter().filter(|&&b| b == b'\n').count(), 10, "head, 6 laps, 3 lines");
    race(&two, &margin);
    for name in ["laps.csv", "trajectory.csv"] {
        let bytes = fs::read(one.join(name)).unwrap();
        assert!(bytes == fs::read(two.join(name)).unwrap(), "{name} differs");
    }
    race(&two, &["--seed", "1"]);
    assert_ne!(fs::read(one.join("laps.csv")).unwrap(), fs::read(two.join("laps.csv")).unwrap());

    let laps = folder.read("one/laps.csv");
    assert!(laps.starts_with("lap,kind,iteration,lap_time_s,valid,"));
    let kinds: Vec<&str> = laps.lines().skip(1).map(|l| l.split(',').nth(1).unwrap()).collect();
    assert_eq!(kinds, ["warmup", "warmup", "warmup", "warmup", "learning", "learning"]);
    let trajectory = folder.read("one/trajectory.csv");
    assert!(trajectory.starts_with(
        "time_s,lap,v_x_mps,v_y_mps,omega_z_radps,e_psi_rad,s_m,e_y_m,a_mps2,delta_rad,x_m,y_m,"
    ));
    let columns = trajectory.lines().next().unwrap().split(',').count();
    assert!(trajectory.lines().all(|line| line.split(',').count() == columns));
    let report = folder.read("one/report.html");
    for part in ["<svg", "time-optimal 3.798 s", "data-choose=\"6\"", "prefers-color-scheme: dark"]
    {
        assert!(report.contains(part), "{part}");
    }
    assert!(!report.contains("http"), "the report needs no network");
}

#[test]
fn json_is_all_of_standard_output() {
    let folder = Folder::new("json");
    let output = race(&folder.0, &["--json", "--quiet"]);
    let value: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(value["laps"].as_array().unwrap().len(), 6);
    assert!(value["failure"].is_null() && value["best_lap_s"].as_f64().unwrap() < 14.0);
    assert!(output.stderr.is_empty());
}

#[test]
fn a_car_that_fails_is_exit_code_3_and_says_why() {
    let folder = Folder::new("fails");
    // No grip to speak of: the car slides off at warm-up speed.
    let output = race(&folder.0, &["--plant", "mu=0.01"]);
    assert_eq!(output.status.code(), Some(3), "{}", text(&output.stderr));
    let said = text(&output.stdout);
    assert!(said.contains("left the track by") && said.contains("in a warm-up lap"), "{said}");
    assert!(folder.read("report.html").contains("left the track"));
}

#[test]
fn learned_data_come_back_and_belong_to_their_configuration() {
    let folder = Folder::new("learned");
    let data = folder.0.join("learned.lmpc").display().to_string();
    assert_eq!(race(&folder.0, &["--save", &data]).status.code(), Some(0));
    let saved = fs::read(&data).unwrap();
    let more = race(&folder.0, &["--load", &data, "--save", &data]);
    assert_eq!(more.status.code(), Some(0), "{}", text(&more.stderr));
    assert!(!text(&more.stdout).contains("warmup"), "it has warmed up already");
    assert_eq!(fs::read(format!("{data}.bak")).unwrap(), saved, "the one before is kept");

    let other = race(&folder.0, &["--load", &data, "--set", "horizon.steps=14"]);
    assert_eq!(other.status.code(), Some(1));
    assert!(text(&other.stderr).contains("steps"), "{}", text(&other.stderr));

    let mut damaged = saved;
    let middle = damaged.len() / 2;
    damaged[middle] ^= 1;
    fs::write(&data, damaged).unwrap();
    let output = race(&folder.0, &["--load", &data]);
    assert_eq!(output.status.code(), Some(1));
    assert!(text(&output.stderr).contains(".bak"), "says where the one before is");
}

#[test]
fn a_study_that_was_interrupted_goes_on() {
    let folder = Folder::new("study");
    let out = folder.0.display().to_string();
    let study = ["study", "hardware", "--seeds", "2", "--laps", "1", "--out", &out];
    let whole = lmpc(&study);
    assert_eq!(whole.status.code(), Some(0), "{}", text(&whole.stderr));
    let (runs, laps) = (folder.read("runs.csv"), folder.read("laps.csv"));
    assert!(runs.starts_with(
        "regression,nominal,control_rate_cost,bandwidth,seed,laps_completed,itf,ilt20_s,best_lap_s,failure"
    ));
    assert_eq!(runs.lines().count(), 1 + 4 * 2);

    // As a kill leaves it: some runs missing, the last line torn, laps without their run.
    let kept: String = runs.lines().take(6).map(|l| format!("{l}\n")).collect();
    folder.file("runs.csv", &(kept + "error,dynamic,0.1,3.0"));
    let resumed = lmpc(&study);
    assert!(text(&resumed.stderr).contains("8 runs, 5 kept"), "{}", text(&resumed.stderr));
    assert_eq!(folder.read("runs.csv"), runs);
    assert_eq!(folder.read("laps.csv"), laps);
    assert_eq!(resumed.stdout, whole.stdout);

    // Other settings are other runs.
    let other = lmpc(&[&study[..], &["--set", "horizon.steps=11"]].concat());
    assert!(text(&other.stderr).contains("8 runs, 0 kept"), "{}", text(&other.stderr));
}

#[test]
fn a_bridge_names_what_does_not_go_together() {
    for (arguments, word) in [
        (&["--vehicle", "boat"][..], "expected sim, fmu:FILE or car"),
        (&["--vehicle", "car"], "needs the map"),
        (&["--map", "map.toml"], "--map belongs to"),
        (&["--vehicle", "sim", "--state-period-ms", "20"], "measured every tick"),
        (&["--vehicle", "car", "--map", "m.toml", "--preload", "l.so"], "--preload belongs to"),
    ] {
        let output = lmpc(&[&["bridge"], arguments].concat());
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {said}");
        assert!(said.contains(word), "{arguments:?}: {said}");
    }
}
