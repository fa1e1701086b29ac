//! `lmpc export`: what is in the tables is what was in the log, by the generated types.
#![allow(
    clippy::unwrap_used,
    clippy::panic,
    reason = "a test that cannot set up its files has failed"
)]

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use lcm_types::eventlog::EventWriter;
use lcm_types::{
    ActuationCommand, ActuationReport, Checked as _, Header, Message as _, MpcTelemetry, PredPoint,
    VehicleState, channels,
};
use serde_json::Value;
use tempfile::TempDir;

const STEPS: i16 = 12;

fn state(n: i16) -> VehicleState {
    let t = f64::from(n);
    VehicleState {
        h: Header { seq: n.into(), sender: "car, \"one\"".to_owned(), ..Header::default() },
        vx: t / 3.0,
        wheel_speed: [t, 1e-7 * t, -t, 1e9 * t],
        ..VehicleState::default()
    }
}

/// The prediction of step n has n points.
fn telemetry(n: i16) -> MpcTelemetry {
    let point = |i: i16| PredPoint { x: 0.1 * f32::from(i), ..PredPoint::default() };
    MpcTelemetry {
        terminal_cost: f64::NAN,
        n_pred: n,
        pred: (0..n).map(point).collect(),
        n_x: 2,
        n_ss: n.min(1),
        ss: vec![vec![0.7, -0.7]; usize::from(n > 0)],
        ss_cost: vec![3.0; usize::from(n > 0)],
        ss_lambda: vec![0.0; usize::from(n > 0)],
        ..MpcTelemetry::default()
    }
}

fn log() -> Vec<u8> {
    let mut log = EventWriter::new(Vec::new());
    let mut bytes = Vec::new();
    for n in 0..STEPS {
        let utime = 1_700_000_000_000_000 + i64::from(n) * 100_001;
        state(n).seal_into(&mut bytes).unwrap();
        log.write(utime, channels::STATE, &bytes).unwrap();
        telemetry(n).encode_into(&mut bytes).unwrap();
        log.write(utime, channels::TELEMETRY, &bytes).unwrap();
        log.write(utime, "OTHER", b"not a message of ours").unwrap();
    }
    log.into_inner()
}

fn export(folder: &Path, log: &[u8], arguments: &[&str]) -> Output {
    fs::write(folder.join("drive.log"), log).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_lmpc"));
    command.current_dir(folder).args(["export", "drive.log"]).args(arguments).output().unwrap()
}

/// A table as the rows of the named columns.
fn column(folder: &Path, file: &str, name: &str) -> Vec<String> {
    let mut table = csv::Reader::from_path(folder.join("out").join(file)).unwrap();
    let position = table.headers().unwrap().iter().position(|header| header == name);
    let position = position.unwrap_or_else(|| panic!("no column {name} in {file}"));
    table.records().map(|row| row.unwrap()[position].to_owned()).collect()
}

#[test]
fn the_tables_hold_what_was_sent() {
    let folder = TempDir::new().unwrap();
    let output = export(folder.path(), &log(), &["--csv", "out", "--json"]);
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    let account: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(account["streams"][0]["messages"], STEPS);
    assert_eq!(account["unknown"]["OTHER"], STEPS);
    let of = |file: &str, name: &str| column(folder.path(), file, name);
    let number = |text: &String| text.parse::<f64>().unwrap();
    for n in 0..STEPS {
        let row = usize::try_from(n).unwrap();
        let sent = state(n);
        assert_eq!(
            of("CAR_STATE.csv", "time_s")[row],
            format!(
                "{}.{:06}",
                1_700_000_000 + i64::from(n) / 10,
                i64::from(n) % 10 * 100_000 + i64::from(n)
            )
        );
        assert_eq!(of("CAR_STATE.csv", "h.sender")[row], sent.h.sender);
        assert_eq!(number(&of("CAR_STATE.csv", "vx")[row]).to_bits(), sent.vx.to_bits());
        let wheel = number(&of("CAR_STATE.csv", "wheel_speed[1]")[row]);
        assert_eq!(wheel.to_bits(), sent.wheel_speed[1].to_bits());
        let told = telemetry(n);
        assert!(number(&of("LMPC_TELEM.csv", "terminal_cost")[row]).is_nan());
        for i in 0..usize::try_from(STEPS - 1).unwrap() {
            let cell = &of("LMPC_TELEM.csv", &format!("pred[{i}].x"))[row];
            let point = cell.parse::<f32>().ok();
            assert_eq!(point, told.pred.get(i).map(|point| point.x), "row {row}, point {i}");
        }
        assert_eq!(of("LMPC_TELEM.csv", "ss[0][1]")[row].is_empty(), n == 0);
    }
}

#[test]
fn damage_is_counted_and_the_rest_is_exported() {
    let folder = TempDir::new().unwrap();
    let mut bytes = log();
    let second = bytes[4..].windows(4).position(|w| w == [0xed, 0xa1, 0xda, 0x01]).unwrap() + 4;
    bytes.splice(second..second, [0x55; 99]);
    let output = export(folder.path(), &bytes, &["--csv", "out", "--channel", "CAR/STATE"]);
    assert_eq!(output.status.code(), Some(3), "{output:?}");
    let talk = String::from_utf8(output.stderr).unwrap();
    assert!(talk.contains("99 bytes skipped at 1 damaged place"), "{talk}");
    assert_eq!(column(folder.path(), "CAR_STATE.csv", "vx").len(), usize::try_from(STEPS).unwrap());
    assert!(!folder.path().join("out/LMPC_TELEM.csv").exists());
}

#[test]
fn foreign_types_come_from_files_and_a_silent_channel_is_an_error() {
    let folder = TempDir::new().unwrap();
    let text = "package bot; struct pose_t { int64_t utime; double pos[3]; byte raw[2]; }";
    fs::write(folder.path().join("pose.lcm"), text).unwrap();
    let schema = lcm_types::schema::Schema::parse(&[("pose.lcm", text)]).unwrap();
    let pose = schema.zero("bot.pose_t").unwrap();
    let mut message = Vec::new();
    schema.encode_into("bot.pose_t", &pose, &mut message).unwrap();
    let mut log = EventWriter::new(Vec::new());
    log.write(5, "POSE", &message).unwrap();
    let log = log.into_inner();
    let arguments = ["--csv", "out", "--types", "pose.lcm"];
    let output = export(folder.path(), &log, &arguments);
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    let table = fs::read_to_string(folder.path().join("out/POSE.csv")).unwrap();
    assert_eq!(table, "time_s,utime,pos[0],pos[1],pos[2],raw\n0.000005,0,0,0,0,0000\n");
    let output = export(folder.path(), &log, &["--csv", "out", "--channel", "NOPE"]);
    assert_eq!(output.status.code(), Some(1), "{output:?}");
}

/// The smallest drive that shows everything: a track, a state, a step, a command and its report.
fn drive() -> Vec<u8> {
    let track = vehicle_model::Track::builtin("l").unwrap();
    let mut log = EventWriter::new(Vec::new());
    let mut bytes = Vec::new();
    let posed = VehicleState { valid: VehicleState::POSE, x: 1.25, yaw: 0.5, ..state(7) };
    posed.seal_into(&mut bytes).unwrap();
    log.write(1_000_001, channels::STATE, &bytes).unwrap();
    ActuationCommand::default().seal_into(&mut bytes).unwrap();
    log.write(1_000_002, channels::COMMAND, &bytes).unwrap();
    ActuationReport::default().seal_into(&mut bytes).unwrap();
    log.write(1_000_003, channels::ACTUATION, &bytes).unwrap();
    let told = MpcTelemetry {
        n_slack: 1,
        slack: vec![0.01],
        n_x: 6,
        ss: vec![vec![1.0, 0.0, 0.0, 0.0, 0.5, 0.1]],
        ..telemetry(3)
    };
    told.encode_into(&mut bytes).unwrap();
    log.write(1_000_004, channels::TELEMETRY, &bytes).unwrap();
    let map = protocol::telemetry::track_message(&track);
    for utime in [1_000_005, 2_000_005] {
        map.seal_into(&mut bytes).unwrap();
        log.write(utime, channels::TRACK, &bytes).unwrap();
    }
    log.into_inner()
}

/// Topics of an exported drive, with the schema, the log times and the messages of each.
fn exported() -> BTreeMap<String, (Value, Vec<(u64, Value)>)> {
    let folder = TempDir::new().unwrap();
    let output = export(folder.path(), &drive(), &["--mcap", "drive.mcap"]);
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    let file = fs::read(folder.path().join("drive.mcap")).unwrap();
    let mut topics: BTreeMap<String, (Value, Vec<(u64, Value)>)> = BTreeMap::new();
    for message in mcap::MessageStream::new(&file).unwrap() {
        let message = message.unwrap();
        let schema = serde_json::from_slice(&message.channel.schema.as_ref().unwrap().data);
        let topic = topics.entry(message.channel.topic.clone());
        let (_, messages) = topic.or_insert_with(|| (schema.unwrap(), Vec::new()));
        messages.push((message.log_time, serde_json::from_slice(&message.data).unwrap()));
    }
    topics
}

#[test]
fn the_scene_shows_track_car_prediction_and_safe_set() {
    let topics = exported();
    let (schema, states) = &topics["CAR/STATE"];
    let speed = &schema["properties"]["vx"];
    assert_eq!(speed["type"], "number");
    assert!(speed["description"].as_str().unwrap().contains("[m/s]"));
    assert_eq!((states[0].0, &states[0].1["x"]), (1_000_001_000, &Value::from(1.25)));
    let only = |topic: &str| {
        let messages = &topics[topic].1;
        assert_eq!(messages.len(), 1, "{topic}");
        messages[0].1["entities"][0].clone()
    };
    let pose = &only("scene/car")["cubes"][0]["pose"];
    assert_eq!(pose["position"]["x"], 1.25);
    assert!((pose["orientation"]["z"].as_f64().unwrap() - 0.25_f64.sin()).abs() < 1e-12);
    assert_eq!(topics["tf"].1[0].1["translation"]["x"], 1.25);
    assert_eq!(only("scene/prediction")["lines"][0]["points"].as_array().unwrap().len(), 3);
    // The safe set's point stands where the track puts it; the track was said after it.
    let place = vehicle_model::State { s: 0.5, e_y: 0.1, ..Default::default() };
    let place = vehicle_model::Track::builtin("l").unwrap().to_global(&place);
    let sphere = &only("scene/safe_set")["spheres"][0]["pose"]["position"];
    assert!((sphere["x"].as_f64().unwrap() - place.x).abs() < 1e-3);
    assert!((sphere["y"].as_f64().unwrap() - place.y).abs() < 1e-3);
    assert_eq!(only("scene/track")["lines"].as_array().unwrap().len(), 2);
}

/// Every message path and topic in a panel's configuration.
fn paths(of: &Value, found: &mut Vec<String>) {
    let Value::Object(entries) = of else {
        of.as_array().into_iter().flatten().for_each(|inner| paths(inner, found));
        return;
    };
    for (key, value) in entries {
        match (key.as_str(), value) {
            ("value" | "path", Value::String(path)) => found.push(path.clone()),
            ("topics", Value::Object(topics)) => found.extend(topics.keys().cloned()),
            _ => paths(value, found),
        }
    }
}

#[test]
fn every_path_of_the_foxglove_layout_is_in_an_export() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/foxglove-layout.json");
    let layout: Value = serde_json::from_str(&fs::read_to_string(file).unwrap()).unwrap();
    let mut found = Vec::new();
    paths(&layout["configById"], &mut found);
    assert!(found.len() >= 14, "{found:?}");
    let topics = exported();
    for path in found {
        let (topic, fields) = path.split_once('.').unwrap_or((&path, ""));
        let message = &topics.get(topic).unwrap_or_else(|| panic!("no topic of {path}")).1[0].1;
        let pointer = format!("/{}", fields.replace('[', "/").replace(']', "").replace('.', "/"));
        let value = if fields.is_empty() { Some(message) } else { message.pointer(&pointer) };
        assert!(value.is_some_and(|v| !v.is_null()), "{path}");
    }
    for panel in layout["configById"].as_object().unwrap().keys() {
        assert!(layout["layout"].to_string().contains(&format!("\"{panel}\"")), "{panel}");
    }
}
