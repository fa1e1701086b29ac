//! Recordings with faults, against the same recording without them.

use std::fmt::Write as _;
use std::path::PathBuf;

use controller::Config;
use vehicle_model::{CarParams, State, Track};

use super::*;

/// Time between rows [s].
const INTERVAL: f64 = 0.05;
/// Speed of the drive [m/s].
const SPEED: f64 = 1.5;
/// Laps from line to line: the first starts on the line and does not count.
const LAPS: usize = 2;
/// Line of the first row.
const FIRST_LINE: usize = 2;

/// A drive along the centre line of the L track for a bit more than three laps; each time as `time` writes
/// the one from zero.
fn table(time: impl Fn(f64) -> String) -> Vec<String> {
    let track = Track::builtin("l").unwrap();
    let count = (3.3 * track.length() / SPEED / INTERVAL) as usize;
    let mut lines =
        vec!["time_s,x_m,y_m,psi_rad,v_x_mps,v_y_mps,omega_z_radps,a_mps2,delta_rad".into()];
    for i in 0..count {
        let t = i as f64 * INTERVAL;
        let s = track.wrap(SPEED * t);
        let at = track.to_global(&State { s, v_x: SPEED, ..State::default() });
        let omega_z = SPEED * track.kappa(s);
        let mut line = time(t);
        let delta = (0.26 * track.kappa(s)).atan();
        write!(line, ",{},{},{},{SPEED},0,{omega_z},0,{delta}", at.x, at.y, at.psi).unwrap();
        lines.push(line);
    }
    lines
}

fn from_zero(t: f64) -> String {
    format!("{t:.2}")
}

struct Folder(tempfile::TempDir);

impl Folder {
    fn write(lines: &[String]) -> (Self, PathBuf) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("drive.csv");
        std::fs::write(&path, lines.join("\n")).unwrap();
        (Self(folder), path)
    }
}

fn read_lines(lines: &[String]) -> Result<Recording> {
    let (folder, path) = Folder::write(lines);
    let recording = read(&path, "CAR_STATE");
    drop(folder.0);
    recording
}

fn driven(recording: &Recording) -> ResampledDrive {
    let (car, track) = (CarParams::builtin("barc").unwrap(), Track::builtin("l").unwrap());
    drive(recording, InputChoice::Auto, true, (&Config::default(), &car, &track))
}

fn lap_times(drive: &ResampledDrive) -> Vec<f64> {
    drive.laps.iter().map(|lap| lap.lap_time).collect()
}

#[test]
fn times_since_1970_give_the_laps_of_times_from_zero() {
    let plain = driven(&read_lines(&table(from_zero)).unwrap());
    assert_eq!(plain.laps.len(), LAPS);
    let late = |t: f64| {
        let text = from_zero(t);
        let (whole, fraction) = text.split_once('.').unwrap();
        format!("{}.{fraction}", 1_700_000_000 + whole.parse::<i64>().unwrap())
    };
    let exact = driven(&read_lines(&table(late)).unwrap());
    let bits = |drive: &ResampledDrive| -> Vec<u64> {
        drive
            .steps
            .iter()
            .flat_map(|s| [s.time.to_bits(), s.x.s.to_bits(), s.x.e_y.to_bits()])
            .collect()
    };
    assert!(bits(&exact) == bits(&plain), "whole seconds change no bit");
    // As a program writes them that holds them in a float: rounded to 0.2 us.
    for start in [1_700_000_000.123_456_7, 1_699_999_999.97] {
        let rounded = driven(&read_lines(&table(|t| format!("{}", start + t))).unwrap());
        assert_eq!(rounded.steps.len(), plain.steps.len());
        for (a, b) in lap_times(&rounded).iter().zip(lap_times(&plain)) {
            assert!((a - b).abs() < 1e-5, "{a} {b}");
        }
        assert_eq!(rounded.laps.len(), LAPS);
    }
}

#[test]
fn bad_cells_cost_their_rows_alone_and_are_named() {
    let good = table(from_zero);
    let plain = driven(&read_lines(&good).unwrap());
    let mut bad = good;
    // Line, column, what stands there.
    for (line, column, cell) in
        [(50, 4, "nan"), (51, 6, ""), (200, 5, "-"), (300, 1, "inf"), (310, 7, "")]
    {
        let mut cells: Vec<&str> = bad[line - FIRST_LINE + 1].split(',').collect();
        cells[column] = cell;
        bad[line - FIRST_LINE + 1] = cells.join(",");
    }
    let recording = read_lines(&bad).unwrap();
    let left = recording.left_out.to_string();
    assert_eq!(
        left,
        "1 for no number in x_m: 300; 1 for no number in v_x_mps: 50; 1 for no number in omega_z_radps: \
         51; 1 for no number in v_y_mps: 200"
    );
    assert_eq!(recording.inputs_left_out.to_string(), "1 for no number in a_mps2: 310");
    let found = driven(&recording);
    assert!(!found.differentiated && found.stretches == 1);
    assert_eq!(found.laps.len(), plain.laps.len());
    for (a, b) in lap_times(&found).iter().zip(lap_times(&plain)) {
        assert!((a - b).abs() < 1e-3, "{a} {b}");
    }
}

#[test]
fn a_column_without_numbers_is_one_that_was_not_recorded() {
    let mut lines = table(from_zero);
    for line in &mut lines[1..] {
        let mut cells: Vec<&str> = line.split(',').collect();
        cells[5] = "";
        *line = cells.join(",");
    }
    let recording = read_lines(&lines).unwrap();
    assert_eq!(recording.left_out.count(), 0);
    let found = driven(&recording);
    assert!(found.differentiated);
    assert_eq!(found.laps.len(), LAPS);
}

#[test]
fn a_clock_that_is_set_back_is_refused_and_rows_in_reverse_are_not() {
    let lines = table(from_zero);
    let mut twice = lines.clone();
    twice.extend_from_slice(&lines[1..]);
    let error = format!("{:#}", read_lines(&twice).unwrap_err());
    let line = lines.len() + 1;
    assert!(error.contains(&format!("drive.csv, line {line}: the time goes back by")), "{error}");
    assert!(error.contains("cut the file"), "{error}");

    let mut reversed = lines.clone();
    reversed[1..].reverse();
    let found = driven(&read_lines(&reversed).unwrap());
    let plain = driven(&read_lines(&lines).unwrap());
    assert_eq!(found.laps.len(), LAPS);
    for (a, b) in lap_times(&found).iter().zip(lap_times(&plain)) {
        assert!((a - b).abs() < 1e-9, "{a} {b}");
    }

    let mut again = lines.clone();
    again.insert(40, lines[39].clone());
    let found = read_lines(&again).unwrap();
    assert_eq!(found.left_out.to_string(), "1 for the time of another: 41");
    assert_eq!(found.states.len(), lines.len() - 1);
}

#[test]
fn a_decimal_comma_between_semicolons_or_tabs_is_a_point() {
    let lines = table(from_zero);
    let plain = lap_times(&driven(&read_lines(&lines).unwrap()));
    for separator in [";", "\t"] {
        let other: Vec<String> =
            lines.iter().map(|line| line.replace(',', separator).replace('.', ",")).collect();
        assert_eq!(lap_times(&driven(&read_lines(&other).unwrap())), plain);
    }
}

#[test]
fn a_table_without_a_usable_row_says_why() {
    let lines = ["t;x;y;yaw", "now;1;2;0", "later;1;2;0"].map(str::to_owned);
    let error = format!("{:#}", read_lines(&lines).unwrap_err());
    assert!(error.contains("2 for no number in t: 2 to 3"), "{error}");
}
