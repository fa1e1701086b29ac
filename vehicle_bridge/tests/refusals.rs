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
    let path = |name: &str| folder.0.join(name).display().to_string();
    let (below, out) = (path("below"), path("a.lmpc"));
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
    ];
    for (arguments, code, words) in cases {
        let found = lmpc(arguments);
        let err = text(&found.stderr);
        assert_eq!(found.status.code(), Some(*code), "{arguments:?}: {err}");
        assert_eq!(text(&found.stdout), "", "{arguments:?}: {err}");
        assert!(err.contains(words), "{arguments:?}: {err}");
    }
}
