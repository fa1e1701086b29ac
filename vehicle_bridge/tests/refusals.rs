//! What `lmpc` refuses at its process boundary: once, before any work, with the cure.
#![allow(clippy::unwrap_used, reason = "a test that cannot set up its files has failed")]

use std::fmt::Write as _;
use std::fs;
use std::process::Command;

/// Exit code, standard output and standard error of a run in a folder.
fn lmpc(folder: &std::path::Path, arguments: &[&str]) -> (i32, String, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_lmpc"))
        .args(arguments)
        .current_dir(folder)
        .env("NO_COLOR", "1")
        .output()
        .unwrap();
    let text = |bytes| String::from_utf8_lossy(bytes).into_owned();
    (output.status.code().unwrap_or(-1), text(&output.stdout), text(&output.stderr))
}

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
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    file("ms.csv", &drive("t,x,y,yaw", 1000.0));
    file("units.csv", &drive("t [s],x [m],y [m],yaw [rad]", 1.0));
    file("empty.log", "");
    fs::create_dir(folder.path().join("below")).unwrap();
    let cases: &[(&[&str], i32, &str)] = &[
        (&["race", "--save", "below"], 1, "it is a folder, expected a file"),
        (&["optimum", "--margin", "-1"], 2, "expected a distance of 0 or above"),
        (&["race", "--bandwidth", "-1"], 2, "-1 is out of range"),
        (&["car", "new", ""], 1, "`` is no name of a car"),
        (&["car", "new", "below/x"], 1, "the folder with --out"),
        (&["learn", "ms.csv", "--out", "a.lmpc"], 1, "check that the times are in seconds"),
        (&["learn", "units.csv", "--out", "a.lmpc"], 1, "no lap goes from line to line"),
        (&["replay", "empty.log"], 1, "no commands of a controller"),
    ];
    for (arguments, code, words) in cases {
        let (found, out, err) = lmpc(folder.path(), arguments);
        assert_eq!((found, out.as_str()), (*code, ""), "{arguments:?}: {err}");
        assert!(err.contains(words), "{arguments:?}: {err}");
    }
}
