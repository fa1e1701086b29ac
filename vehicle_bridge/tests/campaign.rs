//! Campaigns from a file: shards, a kill in the middle, the merge, limits, what the file refuses.

#![allow(clippy::unwrap_used, clippy::panic, reason = "code of tests")]

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::thread::sleep;
use std::time::Duration;

type Row = BTreeMap<String, String>;

const CAMPAIGN: &str = r#"
title = "Grip, horizon and cars"
laps = 1
seeds = 2

[set]
plant.noise = 0.0005
"config.regression.neighbors" = 30

[[axis]]
join = [
  { key = "car", values = ["barc", "mini"] },
  { key = "nominal_mu", values = [1.1, 0.9] },
]

[[axis]]
key = "plant.mu"
random = { from = 0.7, to = 1.0, count = 2, seed = 3 }

[[axis]]
key = "config.horizon.steps"
range = { from = 11, to = 15, step = 2 }

[[axis]]
key = "track.width_left_m"
values = [0.6, 0.8]

[[when]]
is = { "config.horizon.steps" = 13 }
set = { "config.cost.control_rate" = 0.3 }

[[when]]
is = { car = "mini", "config.horizon.steps" = 11 }
skip = true

[[record]]
column = "v_x_mps"
take = ["max", 0.9]

[limits]
failed_runs = 40
"#;

fn lmpc(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_lmpc"));
    command.arg("study").args(arguments);
    command
}

fn run(arguments: &[&str]) -> Output {
    lmpc(arguments).output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

fn rows(out: &Path) -> Vec<Row> {
    let mut reader = csv::Reader::from_path(out.join("runs.csv")).unwrap();
    reader.deserialize().map(Result::unwrap).collect()
}

fn campaign(folder: &Path, text: &str) -> String {
    let file = folder.join("grip.toml");
    fs::write(&file, text).unwrap();
    file.display().to_string()
}

#[test]
fn shards_one_of_them_killed_and_resumed_merge_to_the_rows_of_one_run() {
    let folder = tempfile::tempdir().unwrap();
    let file = campaign(folder.path(), CAMPAIGN);
    let path = |name: &str| folder.path().join(name).display().to_string();
    let (whole, parts) = (path("whole"), path("parts"));
    let one = run(&[&file, "--out", &whole]);
    assert_eq!(one.status.code(), Some(0), "{}{}", text(&one.stdout), text(&one.stderr));
    let all = rows(Path::new(&whole));
    // 2 cars x 2 grips x 3 horizons x 2 widths x 2 seeds, less one horizon of one car.
    assert_eq!(all.len(), 40);

    let folder_of = |part: usize| Path::new(&parts).join(format!("shard-{part}-of-3"));
    // Killed with a row or two on record.
    let second = ["--shard", "2/3", "--jobs", "1", "--out", &parts];
    let mut killed = lmpc(&[&[file.as_str()], &second[..]].concat())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let table = folder_of(2).join("runs.csv");
    let lines = || fs::read_to_string(&table).unwrap_or_default().lines().count();
    while lines() < 3 {
        sleep(Duration::from_millis(5));
        assert!(killed.try_wait().unwrap().is_none() || lines() >= 3, "ended before it was killed");
    }
    killed.kill().unwrap();
    killed.wait().unwrap();
    let kept = rows(&folder_of(2)).len();
    assert!((1..13).contains(&kept), "{kept} runs before the kill");
    // And in the middle of a line.
    let torn = fs::read_to_string(&table).unwrap() + "39,barc,";
    fs::write(&table, torn).unwrap();

    for part in ["1/3", "3/3"] {
        let shard = run(&[&file, "--shard", part, "--out", &parts]);
        assert_eq!(shard.status.code(), Some(0), "{}", text(&shard.stderr));
    }
    let shards: Vec<String> = (1..=3).map(|i| folder_of(i).display().to_string()).collect();
    let shards: Vec<&str> = shards.iter().map(String::as_str).collect();
    let merged = path("merged");
    let merge = |out: &str| run(&[&["merge"], &shards[..], &["--out", out]].concat());
    let early = merge(&path("early"));
    assert_eq!(early.status.code(), Some(1), "incomplete");
    assert!(text(&early.stdout).contains("runs are missing"), "{}", text(&early.stdout));

    let resumed = run(&[&[file.as_str()], &second[..]].concat());
    let shown = text(&resumed.stderr);
    assert!(shown.contains(&format!("13 runs of shard 2/3, {kept} kept")), "{shown}");
    let merge_of_all = merge(&merged);
    assert_eq!(merge_of_all.status.code(), Some(0), "{}", text(&merge_of_all.stderr));
    let bytes = |out: &str| fs::read(Path::new(out).join("runs.csv")).unwrap();
    assert!(bytes(&merged) == bytes(&whole), "the merged table differs from that of one run");

    // Rows are what `lmpc race` drives.
    let row = all.iter().find(|row| row["config.horizon.steps"] == "13" && row["seed"] == "1");
    let row = row.unwrap();
    let track = folder.path().join("track.toml");
    let l = include_str!("../../tracks/l.toml");
    let lines: Vec<String> = l
        .lines()
        .map(|line| match line.split_once('=') {
            Some((key, _)) if key.trim() == "width_left_m" => {
                format!("{key}= {}", row["track.width_left_m"])
            }
            _ => line.to_owned(),
        })
        .collect();
    fs::write(&track, lines.join("\n")).unwrap();
    let plant = format!("noise=0.0005,mu={}", row["plant.mu"]);
    let race = Command::new(env!("CARGO_BIN_EXE_lmpc"))
        .args(["race", "--car", &row["car"], "--track", &track.display().to_string()])
        .args(["--nominal-mu", &row["nominal_mu"], "--plant", &plant, "--laps", "1", "--json"])
        .args(["--set", "horizon.steps=13", "--set", "cost.control_rate=0.3"])
        .args(["--set", "regression.neighbors=30", "--seed", "1", "--out", &path("race")])
        .output()
        .unwrap();
    let summary: serde_json::Value = serde_json::from_slice(&race.stdout).unwrap();
    let best = summary["best_lap_s"].as_f64().map_or(String::new(), |best| best.to_string());
    assert_eq!(best, row["best_lap_s"], "{row:?}");
    let speeds = csv::Reader::from_path(folder.path().join("race/trajectory.csv"));
    let steps: Vec<Row> = speeds.unwrap().deserialize().map(Result::unwrap).collect();
    let learned = steps.iter().skip_while(|step| step["action"] != "learned");
    let fastest = learned.map(|step| step["v_x_mps"].parse::<f64>().unwrap()).fold(0.0, f64::max);
    assert_eq!(fastest.to_string(), row["v_x_mps_max"]);
}

#[test]
fn limits_make_it_fail_and_changed_settings_run_anew() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out").display().to_string();
    let write = |more: &str| {
        let axis = "[[axis]]\nkey = \"plant.mu\"\nvalues = [0.9, 0.02]\n";
        campaign(folder.path(), &format!("laps = 2\n{axis}{more}"))
    };
    let file = write("[limits]\nfailed_runs = 1\nbest_lap_s = { most = 100 }\n");
    let first = run(&[&file, "--out", &out]);
    assert_eq!(first.status.code(), Some(0), "{}", text(&first.stderr));
    assert!(text(&first.stderr).contains("plant.mu 0.02, seed 0: the car"), "shown as they come");
    let found = rows(Path::new(&out));
    assert_eq!(found[0]["failure"], "");
    assert!(!found[1]["failure"].is_empty() && found[1]["limits"].is_empty());

    // Other limits judge the rows on record.
    let file = write("[limits]\nfailed_runs = 1\nbest_lap_s = { most = 1.0 }\n");
    let second = run(&[&file, "--out", &out]);
    assert_eq!(second.status.code(), Some(3), "{}", text(&second.stdout));
    assert!(text(&second.stderr).contains("2 kept"), "{}", text(&second.stderr));
    assert_eq!(rows(Path::new(&out))[0]["limits"], "best_lap_s");
    let file = write("");
    assert_eq!(run(&[&file, "--out", &out]).status.code(), Some(3), "no run may fail");

    // Other settings: the rows before stay below, without a number.
    let file = write("[set]\nconfig.horizon.steps = 12\n[limits]\nfailed_runs = 2\n");
    let third = run(&[&file, "--out", &out, "--json"]);
    let summary: serde_json::Value = serde_json::from_slice(&third.stdout).unwrap();
    assert_eq!((&summary["runs"], &summary["failed"]), (&2.into(), &1.into()));
    let numbers: Vec<String> = rows(Path::new(&out)).iter().map(|r| r["run"].clone()).collect();
    assert_eq!(numbers, ["0", "1", "", ""]);
    // A row of another campaign is no part of a merge.
    let merged = folder.path().join("merged").display().to_string();
    assert_eq!(run(&["merge", &out, "--out", &merged]).status.code(), Some(0));
    assert_eq!(rows(Path::new(&merged)).len(), 2);
    // Fresh: all anew.
    let fresh = run(&[&file, "--out", &out, "--fresh"]);
    assert!(text(&fresh.stderr).contains("0 kept") && rows(Path::new(&out)).len() == 2);
    assert!(Path::new(&out).join("runs.before.csv").exists());
}

#[test]
fn runs_with_the_same_axes_are_kept_each() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out").display().to_string();
    let file = campaign(
        folder.path(),
        "[set]\nplant.mu = 0.02\n[limits]\nfailed_runs = 6\n[[axis]]\nkey = \"laps\"\n\
         random = { from = 1, to = 2, count = 6, whole = true }\n",
    );
    assert_eq!(run(&[&file, "--out", &out]).status.code(), Some(0));
    let first = rows(Path::new(&out));
    assert_eq!(first.len(), 6);
    let again = run(&[&file, "--out", &out]);
    assert!(text(&again.stderr).contains("6 kept"), "{}", text(&again.stderr));
    assert_eq!(rows(Path::new(&out)), first);
}

#[test]
fn files_beside_the_campaign_are_found_and_the_runs_are_listed() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("mine.toml"), include_str!("../../cars/kart.toml")).unwrap();
    fs::write(folder.path().join("base.toml"), "[horizon]\nsteps = 9\n").unwrap();
    let file = campaign(
        folder.path(),
        "car = \"mine.toml\"\nconfig = \"base.toml\"\nseeds = [4, 9]\n\
         [[axis]]\nkey = \"track\"\nvalues = [\"random-1\", \"road_course\"]\n\
         [[axis]]\nkey = \"car.mass_kg\"\nlog_range = {from = 100, to = 400, count = 3}\n\
         [[axis]]\nkey = \"plant\"\nvalues = [\"none\", \"noise=0.001,delay=0.1\"]\n",
    );
    let list = run(&[&file, "--list"]);
    let lines = text(&list.stdout);
    let mut reader = csv::Reader::from_reader(lines.as_bytes());
    let rows: Vec<Row> = reader.deserialize().map(Result::unwrap).collect();
    assert_eq!(rows.len(), 24, "{lines}{}", text(&list.stderr));
    assert_eq!(
        (rows[3]["seed"].as_str(), rows[3]["plant"].as_str()),
        ("9", "noise=0.001,delay=0.1")
    );
    let middle: f64 = rows[4]["car.mass_kg"].parse().unwrap();
    assert!((middle - 200.0).abs() < 1e-9, "{middle}");
    let mut settings: Vec<&String> = rows.iter().map(|row| &row["settings"]).collect();
    settings.sort();
    settings.dedup();
    assert_eq!(settings.len(), 12, "each cell has its own fingerprint, seeds share it");
    let shard = run(&[&file, "--list", "--shard", "2/5"]);
    let runs: Vec<String> =
        text(&shard.stdout).lines().skip(1).map(|l| l.split(',').next().unwrap().into()).collect();
    assert_eq!(runs, ["1", "6", "11", "16", "21"]);
}

#[test]
fn the_script_of_an_array_runs_every_shard() {
    let folder = tempfile::tempdir().unwrap();
    let file = campaign(folder.path(), "laps = 1\nseeds = 3\n[limits]\nfailed_runs = 3\n");
    let out = folder.path().join("an out");
    let given = out.display().to_string();
    let slurm = run(&[&file, "--slurm", "--shards", "2", "--jobs", "1", "--out", &given]);
    let script = text(&slurm.stdout);
    assert!(
        script.starts_with("#!/bin/sh\n#SBATCH ") && script.contains("--array=1-2\n"),
        "{script}"
    );
    // What Slurm does with it.
    let job = folder.path().join("job.sh");
    fs::write(&job, script).unwrap();
    for task in ["1", "2"] {
        let mut command = Command::new("sh");
        command.arg(&job).env("SLURM_ARRAY_TASK_ID", task).env("SLURM_CPUS_PER_TASK", "1");
        let ran = command.output().unwrap();
        assert!(ran.status.success(), "{}", text(&ran.stderr));
    }
    let shards: Vec<PathBuf> = [1, 2].map(|i| out.join(format!("shard-{i}-of-2"))).into();
    assert_eq!(shards.iter().map(|shard| rows(shard).len()).collect::<Vec<_>>(), [2, 1]);
}

#[test]
fn what_a_file_has_wrong_is_named() {
    let folder = tempfile::tempdir().unwrap();
    for (content, message) in [
        ("lap = 3", "unknown field `lap`"),
        ("seeds = 0", "no runs"),
        ("seeds = [1, 1]", "twice"),
        ("car = \"bark\"", "no car of that name"),
        ("[set]\ngrip = 1", "unknown key `grip`"),
        ("[set]\nconfig.warm_up.seed = 1", "that of `seeds`"),
        ("[[axis]]\nkey = \"config.horizon.stepz\"\nvalues = [1]", "stepz"),
        (
            "[[axis]]\nkey = \"config.horizon.steps\"\nvalues = [12, 1]",
            "run 1 (config.horizon.steps = 1)",
        ),
        (
            "[[axis]]\nkey = \"plant.mu\"\nvalues = [1]\n[[axis]]\nkey = \"plant.mu\"\nvalues = [2]",
            "two axes vary `plant.mu`",
        ),
        ("[[axis]]\nkey = \"car.mass\"\nvalues = [1]", "mass"),
        ("[[axis]]\nkey = \"track.width_m\"\nvalues = [1]", "width_m"),
        ("[[when]]\nis = { car = \"barc\" }\nskip = true", "`car` is no axis"),
        ("[limits]\nbest_lap = { most = 4 }", "no column `best_lap`"),
        ("[limits]\nbest_lap_s = 4", "`least` or `most`"),
    ] {
        let file = campaign(folder.path(), content);
        let out = folder.path().join("out").display().to_string();
        let ran = run(&[&file, "--out", &out]);
        let shown = text(&ran.stderr);
        assert!(matches!(ran.status.code(), Some(1 | 2)), "{content}: {:?}", ran.status);
        assert!(shown.contains(message) && shown.contains("grip.toml"), "{content}: {shown}");
    }
    assert_eq!(run(&["none.toml"]).status.code(), Some(1));
    assert_eq!(run(&["none.toml", "--shard", "3/2"]).status.code(), Some(2));
}

#[test]
fn the_file_of_the_documents_and_the_examples_are_campaigns() {
    let folder = tempfile::tempdir().unwrap();
    let page = include_str!("../../docs/howto/campaign.md");
    let block = page.split("```toml\n").nth(1).unwrap().split("```").next().unwrap();
    let file = campaign(folder.path(), block);
    let list = run(&[&file, "--list"]);
    assert_eq!(text(&list.stdout).lines().count(), 61, "{}", text(&list.stderr));
    let examples = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/studies");
    let mut count = 0;
    for entry in fs::read_dir(examples).unwrap() {
        let list = run(&[&entry.unwrap().path().display().to_string(), "--list"]);
        assert!(text(&list.stdout).lines().count() > 40, "{}", text(&list.stderr));
        count += 1;
    }
    assert_eq!(count, 5);
}
