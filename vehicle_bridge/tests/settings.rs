//! `lmpc check` and `lmpc config`: problems of files, and where each setting comes from.
#![allow(clippy::unwrap_used, reason = "a test that cannot set up its files has failed")]

#[path = "common/command.rs"]
mod command;

use std::fs;
use std::path::Path;

use command::{Folder, lmpc, text};

#[test]
fn check_finds_everything_at_once() {
    let folder = Folder::new("check");
    let config = folder.file(
        "config.toml",
        "preset = \"paper\"\n[horizon]\nstepz = 12\nperiod_s = \"fast\"\nsubsteps = 1000\n\
         [safe_set]\nneighbors = 1\nselection = \"slowest\"\n[regression]\nridge =\n\
         bandwidth = -1.0\n[tyres]\nmu = 1\nlist = [1,\n2]\n",
    );
    let output = lmpc(&["check", &config, "--json"]);
    assert_eq!(output.status.code(), Some(1));
    let checked: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let problems = checked[0]["problems"].as_array().unwrap();
    let lines: Vec<u64> = problems.iter().map(|p| p["line"].as_u64().unwrap()).collect();
    assert_eq!(lines, [3, 4, 5, 7, 8, 10, 11, 12], "{problems:#?}");
    let nearest = problems[0]["message"].as_str().unwrap();
    assert!(nearest.contains("nearest known one is `steps`"), "{nearest}");
    assert!(problems[2]["message"].as_str().unwrap().contains("1 to 200"));

    let car = folder.file(
        "car.toml",
        "mass_kg = \"heavy\"\nl_f_m = -0.13\nwheels = 4\n[tyre_front]\nb = 5.0\nmu = 0.9\n",
    );
    let found = text(&lmpc(&["check", &car]).stdout);
    for part in [
        "car, ",
        "line 1",
        "heavy",
        "line 2: l_f_m",
        "line 3",
        "tyre_front.c: found none, expected the shape factor C",
        "`l_r_m`",
    ] {
        assert!(found.contains(part), "{part}: {found}");
    }
    assert!(!found.contains("missing field `mass_kg`"), "it is there, but wrong: {found}");

    let track = folder.file("oval.csv", "# x_m,y_m,w_tr_right_m,w_tr_left_m\n0,0,1\n1,x,1,1\n");
    let found = text(&lmpc(&["check", &track]).stdout);
    assert!(
        found.contains("track, ") && found.contains("line 2") && found.contains("line 3"),
        "{found}"
    );
}

#[test]
fn every_setting_is_shown_with_its_origin() {
    let folder = Folder::new("config");
    let file = folder.file("race.toml", "[cost]\nslip = 300\n[horizon]\nsteps = 20\n");
    let options = ["--car", "kart", "--track", "road_course", "--config", &file];
    let more = ["--set", "horizon.steps=21", "--set", "regression.mode=full", "--bandwidth", "3"];
    let config = |last: &[&str]| lmpc(&[&["config"], &options[..], &more, last].concat());
    let output = config(&["--json"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let rows: Vec<serde_json::Value> = serde_json::from_slice(&output.stdout).unwrap();
    let of = |key: &str| rows.iter().find(|row| row["key"] == key).unwrap();
    for (key, origin) in [
        ("horizon.steps", "command line"),
        ("regression.mode", "command line"),
        ("regression.bandwidth", "command line"),
        ("cost.slip", file.as_str()),
        ("limits.front_slip_rad", "car"),
        ("warm_up.speed_mps", "car and track"),
        ("safe_set.laps", "preset race"),
    ] {
        assert_eq!(of(key)["origin"], origin, "{key}");
    }
    assert_eq!(
        (of("horizon.steps")["value"].as_u64(), of("cost.slip")["value"].as_f64()),
        (Some(21), Some(300.0))
    );
    assert!(of("limits.lane_margin_m")["rule"].as_str().unwrap().contains("width"));

    // A file of all settings gives the same settings again.
    let all = folder.file("all.toml", &text(&config(&["--toml"]).stdout));
    let again = lmpc(&["config", "--car", "kart", "--config", &all, "--json"]);
    let again: Vec<serde_json::Value> = serde_json::from_slice(&again.stdout).unwrap();
    assert_eq!(again.len(), rows.len());
    for (row, again) in rows.iter().zip(&again) {
        assert_eq!((&row["key"], &row["value"]), (&again["key"], &again["value"]));
        assert_eq!(again["origin"], all, "{row}");
    }
    let checked = lmpc(&["check", &all]);
    assert_eq!(checked.status.code(), Some(0), "{}", text(&checked.stdout));

    // The schema has those keys and no others; every value is within it.
    let schema: serde_json::Value =
        serde_json::from_slice(&lmpc(&["config", "--schema"]).stdout).unwrap();
    let sections = schema["properties"].as_object().unwrap();
    let names =
        sections.iter().filter_map(|(name, of)| Some((name, of["properties"].as_object()?)));
    let names: Vec<String> =
        names.flat_map(|(name, of)| of.keys().map(move |key| format!("{name}.{key}"))).collect();
    assert_eq!(names.len(), rows.len());
    for row in &rows {
        let (section, key) = row["key"].as_str().unwrap().split_once('.').unwrap();
        let of = &schema["properties"][section]["properties"][key];
        let kind = of["type"].as_str().unwrap();
        let value = &row["value"];
        let fits = match kind {
            "integer" => value.is_u64(),
            "number" => value.is_number(),
            "boolean" => value.is_boolean(),
            "string" => of["enum"].as_array().unwrap().contains(value),
            _ => value.as_array().unwrap().len() as u64 == of["minItems"].as_u64().unwrap(),
        };
        assert!(fits, "{row}: {of}");
        if let (Some(least), Some(value)) = (of["minimum"].as_f64(), value.as_f64()) {
            assert!(least <= value && value <= of["maximum"].as_f64().unwrap(), "{row}");
        }
    }

    // The terminal: one section, one key; a name that is neither is a wrong command line.
    let some = text(&lmpc(&["config", "recovery", "horizon.steps"]).stdout);
    assert!(some.contains("horizon.steps") && some.contains("recovery.active"), "{some}");
    assert!(!some.contains("horizon.period_s"), "{some}");
    let wrong = lmpc(&["config", "horizon.stepz"]);
    assert_eq!(wrong.status.code(), Some(2), "{}", text(&wrong.stderr));
}

#[test]
fn check_shows_what_is_derived_from_a_file() {
    let folder = Folder::new("derived");
    let kart = text(&lmpc(&["car", "show", "kart"]).stdout);
    assert!(kart.contains("# kart: ") && kart.contains("cornering stiffness"), "{kart}");
    let car = folder.file("my_kart.toml", &kart);
    let config = folder.file("race.toml", "[cost]\nslip = 300\n");
    let shown = text(&lmpc(&["check", &car, &config, "--track", "road_course"]).stdout);
    for part in [
        "on road_course",
        "from car and track: horizon.steps ",
        "from car: regression.metric [",
        &format!("from {config}: cost.slip 300 1/rad"),
    ] {
        assert!(shown.contains(part), "{part}: {shown}");
    }
    // The settings of a car file are those of `lmpc config` with it.
    let json = |arguments: &[&str]| -> serde_json::Value {
        serde_json::from_slice(&lmpc(arguments).stdout).unwrap()
    };
    let checked = json(&["check", &car, "--track", "road_course", "--json"]);
    assert_eq!(
        checked[0]["settings"],
        json(&["config", "--car", &car, "--track", "road_course", "--json"])
    );
    // A damaged file has problems and no settings.
    let bad = folder.file("bad.toml", "[cost]\nslip = -1\n");
    let checked = json(&["check", &bad, "--json"]);
    assert_eq!(checked[0]["settings"].as_array().unwrap().len(), 0);
    assert_eq!(checked[0]["problems"].as_array().unwrap().len(), 1);
}

#[test]
fn what_ships_has_no_problems() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let files: Vec<String> = ["cars", "tracks"]
        .iter()
        .flat_map(|folder| fs::read_dir(root.join(folder)).unwrap())
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|e| e == "toml" || e == "csv"))
        .map(|path| path.display().to_string())
        .collect();
    assert!(files.len() >= 5);
    let arguments: Vec<&str> =
        ["check"].into_iter().chain(files.iter().map(String::as_str)).collect();
    let output = lmpc(&arguments);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stdout));
}
