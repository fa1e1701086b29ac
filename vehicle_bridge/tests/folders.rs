//! Folders of results are looked at before the work.
#![allow(clippy::unwrap_used, reason = "a test that cannot set up its files has failed")]

#[path = "common/command.rs"]
mod command;

use std::fs;

use command::{lmpc, text};

#[test]
fn a_folder_that_cannot_be_written_is_named_before_the_work() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).display().to_string();
    let data = at("none/learned.lmpc");
    let output = lmpc(&["race", "--laps", "1", "--out", &at("race"), "--save", &data]);
    assert_eq!(output.status.code(), Some(1));
    let said = text(&output.stderr);
    assert!(said.contains(&format!("cannot save {data}")) && said.contains("none"), "{said}");
    assert_eq!(text(&output.stdout), "", "no lap was driven");
    // A file stands where the folder should be.
    let file = at("taken");
    fs::write(&file, "").unwrap();
    let output = lmpc(&["optimum", "--out", &file]);
    assert_eq!((output.status.code(), text(&output.stdout)), (Some(1), String::new()));
    assert!(text(&output.stderr).contains("cannot make the folder"), "{output:?}");
    assert!(!text(&output.stderr).contains("intervals"), "nothing was solved: {output:?}");
}
