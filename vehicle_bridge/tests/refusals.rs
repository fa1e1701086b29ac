//! What `lmpc` refuses at its process boundary: once, before any work, with the cure.
#![allow(clippy::unwrap_used, reason = "a test that cannot set up its files has failed")]

use std::fmt::Write as _;
use std::fs;

#[path = "common/command.rs"]
mod command;

use command::{Folder, lmpc, text};

/// Places on a straight, 0.1 s apart in a unit of this many of them a second.
fn drive(header: &str, unit: f64) -> String {
    (0..200).fold(format!("{header}\n"), |mut text, i| {
        let time = 0.1 * f64::from(i);
        writeln!(text, "{},{},0.0,0.0", time * unit, 0.05 * time).unwrap();
        text
    })
}

#[test]
fn mistakes_are_named_before_any_work() {
    let folder = Folder::new("refusals");
    let ms = folder.file("ms.csv", &drive("t,x,y,yaw", 1000.0));
    let units = folder.file("units.csv", &drive("t [s],x [m],y [m],yaw [rad]", 1.0));
    let degrees = folder.file("degrees.csv", &drive("t [s],x [m],y [m],yaw [deg]", 1.0));
    let log = folder.file("empty.log", "");
    let study = folder.file("study.toml", "title = \"nothing\"\n");
    let l = include_str!("../../tracks/l.toml");
    let track = folder.file("track.toml", l);
    let path = |name: &str| folder.0.join(name).display().to_string();
    let (below, out, results) = (path("below"), path("a.lmpc"), path("results"));
    fs::create_dir(&below).unwrap();
    let cases: &[(&[&str], i32, &str)] = &[
        (&["race", "--save", &below], 1, "it is a folder, expected a file"),
        (&["optimum", "--margin", "-1"], 2, "expected a distance of 0 or above"),
        (&["race", "--bandwidth", "-1"], 2, "-1 is out of range"),
        (&["car", "new", ""], 1, "`` is no name of a car"),
        (&["car", "new", "below/x"], 1, "the folder with --out"),
        (&["learn", &ms, "--out", &out], 1, "check that the times are in seconds"),
        (&["learn", &units, "--out", &out], 1, "no lap goes from line to line"),
        (&["learn", &degrees, "--out", &out], 1, "found t, x, y, yaw [deg]"),
        (&["replay", &log], 1, "no commands of a controller"),
        (&["learn", &units, "--out", &units], 1, "is the file that is read"),
        (&["track", "convert", &track, &track], 1, "is the file that is read"),
        (&["track", "show", &track, "--out", &track], 1, "is the file that is read"),
        (&["race", "--plant", "noise=0.001,noise=0.002"], 2, "found noise=0.001 before it"),
        (&["race", "--plant", "mu=0.7", "--plant", "mu=0.8"], 2, "found mu=0.7 before it"),
        (&["race", "--set", "horizon.steps=9", "--set", "horizon.steps=8"], 2, "each key once"),
        (&["race", "--bandwidth", "3", "--set", "regression.bandwidth=4"], 2, "each key once"),
        (&["study", &study], 1, "nothing varies from run to run"),
        (
            &["bridge", "--doubt", "egde_m=1"],
            2,
            "doubt limit `egde_m` is not known, expected one of",
        ),
        (
            &["bridge", "--doubt", "edge_m=-1"],
            2,
            "doubt limit edge_m is -1, expected a number above 0",
        ),
        (&["bridge", "--doubt", "edge_m"], 2, "expected NAME=VALUE"),
        (&["race", "--track", &below], 1, "it is a folder, expected a file"),
        (&["race", "--load", &below, "--out", &results], 1, "it is a folder, expected a file"),
    ];
    let without_end =
        ["track", "car", "config", "load", "raceline"].map(|name| format!("--{name}"));
    let endless: Vec<[&str; 5]> = without_end
        .iter()
        .map(|option| ["race", option.as_str(), "/dev/zero", "--out", &results])
        .collect();
    let more = endless.iter().map(|arguments| (&arguments[..], 1, "without a known end"));
    for (arguments, code, words) in cases.iter().copied().chain(more) {
        let found = lmpc(arguments);
        let err = text(&found.stderr);
        assert_eq!(found.status.code(), Some(code), "{arguments:?}: {err}");
        assert_eq!(text(&found.stdout), "", "{arguments:?}: {err}");
        assert!(err.contains(words), "{arguments:?}: {err}");
    }
    assert_eq!(fs::read_to_string(&track).unwrap(), l, "nothing was written over");
}
