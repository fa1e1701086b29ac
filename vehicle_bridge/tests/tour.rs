//! `lmpc` alone, and `lmpc tour`: each command that it shows runs, and does what it did there.

#![allow(clippy::unwrap_used, clippy::panic, reason = "code of tests")]

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

fn lmpc() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_lmpc"));
    command.env("NO_COLOR", "1");
    command
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

fn tour(folder: &Path) -> Output {
    lmpc().arg("tour").current_dir(folder).output().unwrap()
}

#[test]
fn without_arguments_it_names_commands_that_exist() {
    let output = lmpc().output().unwrap();
    assert_eq!(output.status.code(), Some(0));
    let page = text(&output.stdout);
    assert!(page.lines().count() < 24, "{page}");
    let shown: Vec<&str> = page.lines().filter(|line| line.starts_with("  lmpc ")).collect();
    assert!(shown.len() >= 6, "{page}");
    for line in shown {
        let words = line.split_whitespace().skip(1);
        let name = words.take(1).map(|word| word.trim_end_matches(';'));
        let help = lmpc().args(name).arg("--help").output().unwrap();
        assert!(help.status.success(), "{line}");
    }
}

#[test]
fn the_tour_shows_its_commands_and_ends_well() {
    let folder = tempfile::tempdir().unwrap();
    let output = tour(folder.path());
    let (out, err) = (text(&output.stdout), text(&output.stderr));
    assert_eq!(output.status.code(), Some(0), "{out}{err}");
    let shown: Vec<&str> = out.lines().filter_map(|line| line.strip_prefix("$ lmpc ")).collect();
    let first: Vec<&str> = shown.iter().filter_map(|line| line.split(' ').next()).collect();
    assert_eq!(first, ["race", "serve", "vehicle", "replay"], "{out}");
    // Without FMUs that part says what it needs.
    assert!(out.contains("Passed over") && out.contains("make fmu"), "{out}");
    assert!(out.contains("commands identical") && out.contains("Done."), "{out}");
    for file in ["race/report.html", "race/laps.csv", "learned.lmpc", "drive.log"] {
        assert!(folder.path().join("out/tour").join(file).is_file(), "{file}");
    }
    // What it showed for the race gives the same race.
    let laps = || fs::read(folder.path().join("out/tour/race/laps.csv")).unwrap();
    let before = laps();
    let again = lmpc().args(shown[0].split(' ')).current_dir(folder.path()).output().unwrap();
    assert!(again.status.success() && laps() == before);
    // And a second tour is not in the way of the first.
    assert_eq!(tour(folder.path()).status.code(), Some(0));
}

#[test]
fn a_tour_that_cannot_write_ends_with_the_reason() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("out"), "a file").unwrap();
    let output = tour(folder.path());
    assert_eq!(output.status.code(), Some(1));
    assert!(text(&output.stderr).contains("out/tour"), "{}", text(&output.stderr));
}
