//! `lmpc export`: what is in the tables is what was in the log, by the generated types.
#![allow(
    clippy::unwrap_used,
    clippy::panic,
    reason = "a test that cannot set up its files has failed"
)]

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use lcm_types::eventlog::Writer;
use lcm_types::{
    Checked as _, Header, Message as _, MpcTelemetry, PredPoint, VehicleState, channels,
};
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
        ss_lap: vec![-1; usize::from(n > 0)],
        ..MpcTelemetry::default()
    }
}

fn log() -> Vec<u8> {
    let mut log = Writer::new(Vec::new());
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
    let mut log = Writer::new(Vec::new());
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
