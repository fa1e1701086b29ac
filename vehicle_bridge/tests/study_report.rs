//! `lmpc study report`: pages that a browser can read, of every kind of table, and what it refuses.

#![allow(clippy::unwrap_used, clippy::panic, reason = "code of tests")]

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

const CAMPAIGN: &str = r#"
title = "Grip < horizon"
laps = 2
seeds = 2

[[axis]]
key = "plant.mu"
values = [0.1, 0.9, 1.0]

[[axis]]
key = "config.horizon.steps"
values = [10, 14]

[limits]
failed_runs = 12
"#;

fn study(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_lmpc")).arg("study").args(arguments).output().unwrap()
}

fn done(arguments: &[&str]) -> String {
    let output = study(arguments);
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    assert_eq!(output.status.code(), Some(0), "{arguments:?}: {}", text(&output.stderr));
    text(&output.stdout)
}

fn refused(arguments: &[&str]) -> String {
    let output = study(arguments);
    assert!(!output.status.success(), "{arguments:?}");
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// The drawings of a page as XML, so that what a browser would forgive fails here.
fn drawings(page: &str) -> Vec<String> {
    let parts = page.split("<svg class=\"chart facets\"").skip(1);
    let own = |part: &str| format!("<svg{}</svg>", part.split("</svg>").next().unwrap());
    let drawings: Vec<String> = parts.map(own).collect();
    for drawing in &drawings {
        roxmltree::Document::parse(drawing).unwrap_or_else(|e| panic!("{e}: {drawing}"));
        assert!(!drawing.contains("NaN") && !drawing.contains("inf"), "{drawing}");
    }
    drawings
}

#[test]
fn a_campaign_is_drawn_along_its_axes_with_its_failures() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).display().to_string();
    let (file, out) = (path("grip.toml"), path("out"));
    fs::write(&file, CAMPAIGN).unwrap();
    done(&[&file, "--out", &out]);
    let table = fs::read_to_string(Path::new(&out).join("runs.csv")).unwrap();
    let failed = |mu: &str| {
        table.lines().filter(|l| l.split(',').nth(1) == Some(mu) && l.contains("off_track")).count()
    };
    assert_eq!(failed("0.1"), 4, "{table}");

    let line = done(&["report", &out]);
    let page = fs::read_to_string(Path::new(&out).join("report.html")).unwrap();
    assert!(line.contains("of 12 runs") && page.contains("Grip &lt; horizon"), "{line}");
    assert!(drawings(&page).len() >= 5 && !page.contains("http"));

    let figure = path("figure.html");
    let axes = ["--x", "plant.mu", "--y", "best_lap_s", "--across", "config.horizon.steps"];
    done(&[&["report", &out, "--out", &figure], &axes[..]].concat());
    let page = fs::read_to_string(&figure).unwrap();
    let [drawing] = &drawings(&page)[..] else { panic!("one figure") };
    // A panel a horizon, in each the two runs that failed with the least grip.
    assert_eq!(drawing.matches(">steps 1").count(), 2);
    assert_eq!(
        (drawing.matches("class=\"cross").count(), drawing.matches(">2</text>").count()),
        (2, 2)
    );
}

#[test]
fn the_papers_figures_have_the_papers_numbers_beside_them() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("crc").display().to_string();
    done(&["crc", "--seeds", "1", "--laps", "1", "--out", &out]);
    done(&["report", &out, "--template", "crc"]);
    let page = fs::read_to_string(Path::new(&out).join("report.html")).unwrap();
    assert!(drawings(&page).len() >= 2);
    assert!(page.contains("error, paper: 5.6 at 0.1") && page.contains("full, paper: 6.4 at 1"));
    let error = refused(&["report", &out, "--x", "grip", "--y", "best_lap_s"]);
    assert!(error.contains("no column `grip`") && error.contains("control_rate_cost"), "{error}");
}

#[test]
fn what_is_no_table_of_runs_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().display().to_string();
    assert!(refused(&["report", &out]).contains("lmpc study merge"));
    let table = folder.path().join("runs.csv");
    fs::write(&table, "car,seed,failure,best_lap_s\nbarc,0,,5\n").unwrap();
    let error = refused(&["report", &out, "--template", "bandwidth"]);
    assert!(
        error.contains("config.regression.bandwidth") && error.contains("bandwidth.toml"),
        "{error}"
    );
    fs::write(&table, "car,seed\n").unwrap();
    assert!(refused(&["report", &out]).contains("no run"));
}
