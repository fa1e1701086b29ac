//! Laps of a driver who is no controller of ours become what the first learned lap is faster than.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "code of tests")]

use std::fs::File;
use std::io::Write as _;
use std::path::Path;
use std::process::Command;
use std::sync::Arc;
use std::time::Duration;

use command::lmpc;
use common::{MULTICAST, Program, URL, isolated};
use lcm_types::eventlog::EventWriter;
use lcm_types::{
    ActuationCommand, ActuationReport, Checked as _, Header, LapResult, Message as _, VehicleState,
    channels,
};
use protocol::publisher::{Identity, Publisher};
use rand::SeedableRng as _;
use rand_distr::{Distribution as _, Normal};
use transport::{Filter, Inbox};
use vehicle_model::plant::SensorNoise;
use vehicle_model::{CarParams, GlobalState, Input, Plant, PlantParams, State, Track};

#[path = "common/command.rs"]
mod command;
mod common;

const PERIOD: f64 = 0.1;

/// Pure pursuit of a wandering line (Coulter 1992) at a speed that bends allow, with shaky hands.
struct Driver {
    rng: rand_pcg::Pcg64,
    /// Slow deviation from the centre line, and of the pace.
    wander: [f64; 2],
    speed: f64,
}

impl Driver {
    fn new(speed: f64) -> Self {
        Self { rng: rand_pcg::Pcg64::seed_from_u64(11), wander: [0.0; 2], speed }
    }

    fn noise(&mut self, sigma: f64) -> f64 {
        Normal::new(0.0, sigma).unwrap().sample(&mut self.rng)
    }

    fn drive(&mut self, x: &State, track: &Track, car: &CarParams) -> Input {
        for i in 0..2 {
            self.wander[i] = 0.95 * self.wander[i] + self.noise(0.02);
        }
        let ahead = 0.35 + 0.25 * x.v_x;
        let goal =
            track.to_global(&State { s: x.s + ahead, e_y: self.wander[0], ..State::default() });
        let here = track.to_global(x);
        let (dx, dy) = (goal.x - here.x, goal.y - here.y);
        let across = dy * here.psi.cos() - dx * here.psi.sin();
        let kappa = 2.0 * across / (dx * dx + dy * dy);
        let bend = (0..8).map(|i| track.kappa(x.s + 0.15 * f64::from(i)).abs()).fold(0.0, f64::max);
        let target = (self.speed * (1.0 + self.wander[1])).min((2.5 / bend.max(0.01)).sqrt());
        let delta = (car.wheelbase() * kappa).atan() + self.noise(0.01);
        Input { a: (1.5 * (target - x.v_x) + self.noise(0.1)).clamp(car.a_min, car.a_max), delta }
    }
}

/// One period of a drive: what was measured, what acted, and the lap.
struct Row {
    time: f64,
    measured: GlobalState,
    steer: f64,
    command: Input,
    applied: Input,
    finished: Option<f64>,
}

/// Laps of the small car, from a start in mid-lap.
fn drive(laps: usize, speed: f64, sensors: SensorNoise) -> Vec<Row> {
    let car = CarParams::builtin("barc").unwrap();
    let track = Arc::new(Track::builtin("l").unwrap());
    let start = State { v_x: 1.0, s: 5.0, ..State::default() };
    let params = PlantParams { noise: sensors, ..PlantParams::new(car.clone()) };
    let mut plant = Plant::new(params, Arc::clone(&track), start).unwrap();
    let mut driver = Driver::new(speed);
    let (mut rows, mut line): (Vec<Row>, Option<f64>) = (Vec::new(), None);
    let (mut finished, mut behind) = (0, 0);
    while behind < 5 {
        let (time, lap) = (rows.len() as f64 * PERIOD, plant.lap());
        let before = plant.progress();
        let steer = plant.applied().delta;
        let x = plant.measure();
        let command = driver.drive(&x, &track, &car);
        plant.apply(command, PERIOD);
        let mut row = Row {
            time,
            measured: track.to_global(&x),
            steer,
            command,
            applied: plant.applied(),
            finished: None,
        };
        if plant.lap() > lap {
            let end = (lap + 1) as f64 * track.length();
            let crossed = time + PERIOD * (end - before) / (plant.progress() - before);
            row.finished = line.replace(crossed).map(|begun| crossed - begun);
            finished += usize::from(row.finished.is_some());
        }
        behind += usize::from(finished == laps);
        rows.push(row);
    }
    rows
}

fn best(rows: &[Row]) -> f64 {
    rows.iter().filter_map(|row| row.finished).fold(f64::INFINITY, f64::min)
}

/// As a bridge of the car would have had it logged.
fn write_log(path: &Path, rows: &[Row]) {
    let mut log = EventWriter::new(File::create(path).unwrap());
    let mut bytes = Vec::new();
    for (seq, row) in rows.iter().enumerate() {
        let at =
            |time: f64| ((time * 1e9).round() as i64, 1_700_000_000_000_000 + (time * 1e6) as i64);
        let (mono_ns, utime) = at(row.time);
        let h = Header { utime, mono_ns, seq: seq as i64, boot_id: 7, sender: "car@kart".into() };
        let m = row.measured;
        let state = VehicleState {
            h: h.clone(),
            meas_utime: utime,
            meas_mono_ns: mono_ns,
            valid: VehicleState::POSE | VehicleState::VEL | VehicleState::STEER,
            quality: 2,
            x: m.x,
            y: m.y,
            yaw: m.psi,
            vx: m.v_x,
            vy: m.v_y,
            yaw_rate: m.omega_z,
            steer: row.steer,
            ..VehicleState::default()
        };
        bytes.clear();
        state.seal_into(&mut bytes).unwrap();
        log.write(utime + 300, channels::STATE, &bytes).unwrap();
        let report = ActuationReport {
            h,
            enabled: true,
            source: 1,
            accel: row.applied.a,
            steer: row.applied.delta,
            ..ActuationReport::default()
        };
        bytes.clear();
        report.seal_into(&mut bytes).unwrap();
        log.write(at(row.time + PERIOD).1 + 300, channels::ACTUATION, &bytes).unwrap();
    }
    log.flush().unwrap();
}

/// As some other logger has it: the pose alone, in columns of its own names.
fn write_poses(path: &Path, rows: &[Row]) {
    let mut out = File::create(path).unwrap();
    writeln!(out, "t;x;y;yaw;battery").unwrap();
    for row in rows {
        let m = row.measured;
        writeln!(out, "{};{};{};{};12.1", 100.0 + row.time, m.x, m.y, m.psi).unwrap();
    }
}

/// As a logger beside the driver's program has it: states, and the commands.
fn write_commands(path: &Path, rows: &[Row]) {
    let mut out = File::create(path).unwrap();
    writeln!(out, "time_s,x_m,y_m,psi_rad,v_x_mps,v_y_mps,omega_z_radps,a_mps2,delta_rad").unwrap();
    for Row { time, measured: m, command: u, .. } in rows {
        let (place, speeds) = ((m.x, m.y, m.psi), (m.v_x, m.v_y, m.omega_z));
        write!(out, "{time},{},{},{},", place.0, place.1, place.2).unwrap();
        writeln!(out, "{},{},{},{},{}", speeds.0, speeds.1, speeds.2, u.a, u.delta).unwrap();
    }
}

/// Learns from a file, races on from it, and returns account and the learned laps' times \[s\].
fn learn_and_race(folder: &Path, file: &Path, more: &[&str]) -> (String, Vec<f64>) {
    let learned = folder.join("learned.lmpc").display().to_string();
    let file = file.display().to_string();
    let output = lmpc(&[&["learn", &file, "--out", &learned], more].concat());
    let account = String::from_utf8(output.stdout).unwrap();
    assert!(output.status.success(), "{account}{}", String::from_utf8_lossy(&output.stderr));
    let out = folder.join("race").display().to_string();
    let output = lmpc(&["race", "--load", &learned, "--laps", "3", "--out", &out, "--json"]);
    let race: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(race["failure"], serde_json::Value::Null);
    let laps = race["laps"].as_array().unwrap();
    assert!(laps.iter().all(|lap| lap["kind"] == "learning"), "no warm-up laps of its own");
    (account, laps.iter().map(|lap| lap["lap_time_s"].as_f64().unwrap()).collect())
}

#[test]
fn learned_laps_are_faster_than_the_drivers_best() {
    [2.2, 2.6].into_iter().for_each(first_lap_after);
}

/// A driver at this speed, and what is learned from him.
fn first_lap_after(speed: f64) {
    let folder = tempfile::tempdir().unwrap();
    let rows = drive(20, speed, SensorNoise::laboratory());
    let log = folder.path().join("drive.log");
    write_log(&log, &rows);
    for more in [&[][..], &["--inputs", "reckoned"]] {
        let (account, times) = learn_and_race(folder.path(), &log, more);
        assert!(account.contains("20 of 20 laps taken"), "{account}");
        assert!(times[0] < best(&rows), "{times:?} after {}", best(&rows));
        assert!(times[2] < times[0], "{times:?}");
    }
}

/// The driver as a program of its own on a network, beside a simulated car; the official logger
/// records both.
#[test]
fn twenty_laps_over_lcm_recorded_by_the_official_logger() {
    let name = "twenty_laps_over_lcm_recorded_by_the_official_logger";
    isolated(name, MULTICAST, URL, || {
        let folder = tempfile::tempdir().unwrap();
        let log = folder.path().join("drive.log");
        let mut logger = Command::new("lcm-logger").arg(&log).spawn().expect("lcm-logger");
        let network = transport::open(URL, None).unwrap();
        let inbox = Inbox::queue(1000);
        network.subscribe(Filter::channel(channels::STATE), inbox.sink()).unwrap();
        std::thread::sleep(Duration::from_millis(500));
        let plant = ["--plant", "noise=0.001", "--start-speed", "1", "--laps", "21", "--url", URL];
        let car = Program::start(&[&["vehicle", "sim", "--lock-step"][..], &plant].concat());
        let identity = Identity::new("driver");
        let mut commands = Publisher::new(&network, &identity, channels::COMMAND);
        let (track, car_file) = (Track::builtin("l").unwrap(), CarParams::builtin("barc").unwrap());
        let mut driver = Driver::new(2.6);
        let mut answered = None;
        while let Some(received) = inbox.wait(Duration::from_secs(3)) {
            let state = VehicleState::open(&received.payload).unwrap();
            if answered.replace(state.meas_mono_ns) == Some(state.meas_mono_ns) {
                continue;
            }
            let pose = GlobalState {
                x: state.x,
                y: state.y,
                psi: state.yaw,
                v_x: state.vx,
                v_y: state.vy,
                omega_z: state.yaw_rate,
            };
            let u = driver.drive(&track.to_frenet(&pose, None), &track, &car_file);
            let limit = car_file.delta_max;
            let command = ActuationCommand {
                h: commands.header(),
                state_boot_id: state.h.boot_id,
                state_seq: state.h.seq,
                state_mono_ns: state.meas_mono_ns,
                valid_for_us: 1_000_000,
                enable: true,
                mode: ActuationCommand::MODE_DRIVE,
                accel: u.a,
                steer: u.delta.clamp(-limit, limit),
                ..ActuationCommand::default()
            };
            // A logger that writes to a disk keeps up.
            std::thread::sleep(Duration::from_millis(2));
            commands.send_sealed(&command).unwrap();
        }
        drop(car);
        // Interrupted, it writes what it has.
        let pid = logger.id().to_string();
        Command::new("kill").args(["-INT", &pid]).status().unwrap();
        logger.wait().unwrap();
        let (account, times) = learn_and_race(folder.path(), &log, &[]);
        let taken = account.lines().filter(|line| line.ends_with("taken")).count();
        assert!(taken >= 19, "{account}");
        let driven: Vec<f64> = account
            .lines()
            .filter(|line| line.starts_with("lap "))
            .map(|line| line.split_whitespace().nth(2).unwrap().parse().unwrap())
            .collect();
        let best = driven.iter().copied().fold(f64::INFINITY, f64::min);
        assert!(times[0] < best, "{times:?} after {best}");
    });
}

/// `lmpc serve` goes on from a driver's laps with no warm-up laps of its own, and keeps its own laps
/// beside them.
#[test]
fn serve_goes_on_from_a_drivers_laps() {
    isolated("serve_goes_on_from_a_drivers_laps", MULTICAST, URL, || {
        let folder = tempfile::tempdir().unwrap();
        let rows = drive(8, 2.2, SensorNoise::laboratory());
        let (log, file) = (folder.path().join("drive.log"), folder.path().join("learned.lmpc"));
        write_log(&log, &rows);
        let [log, learned] = [log, file.clone()].map(|path| path.display().to_string());
        assert!(lmpc(&["learn", &log, "--out", &learned]).status.success());
        let driven = std::fs::metadata(&file).unwrap().len();

        let network = transport::open(URL, None).unwrap();
        let (any, laps) = (Inbox::queue(1000), Inbox::queue(1000));
        network.subscribe(Filter::All, any.sink()).unwrap();
        network.subscribe(Filter::channel(channels::LAP), laps.sink()).unwrap();
        let mut service = Program::start(&["serve", "--url", URL, "--learned", &learned]);
        assert!(any.wait(Duration::from_secs(60)).is_some(), "a heartbeat of `lmpc serve`");
        let plant = ["--plant", "noise=0.001", "--laps", "4", "--url", URL];
        let mut car = Program::start(&[&["vehicle", "sim", "--lock-step"][..], &plant].concat());
        assert!(car.0.wait().unwrap().success(), "four laps");
        let pid = service.0.id().to_string();
        Command::new("kill").args(["-INT", &pid]).status().unwrap();
        assert!(service.0.wait().unwrap().success());
        let laps: Vec<LapResult> = std::iter::from_fn(|| laps.take())
            .map(|received| LapResult::decode(&received.payload).unwrap())
            .collect();
        let times: Vec<f64> = laps.iter().map(|lap| lap.lap_time).collect();
        assert!(times.len() >= 3, "{times:?}");
        assert!(times.iter().all(|time| *time < best(&rows)), "{times:?} after {}", best(&rows));
        assert!(laps.iter().all(|lap| lap.valid && lap.store_key == learned), "{laps:?}");
        assert!(std::fs::metadata(&file).unwrap().len() > driven, "its own laps are kept");
    });
}

#[test]
fn commands_do_where_nothing_was_reported() {
    let folder = tempfile::tempdir().unwrap();
    let rows = drive(6, 2.2, SensorNoise::default());
    let table = folder.path().join("drive.csv");
    write_commands(&table, &rows);
    let (account, times) = learn_and_race(folder.path(), &table, &[]);
    assert!(account.contains("inputs recorded commands"), "{account}");
    assert!(times[0] < best(&rows), "{times:?} after {}", best(&rows));
}

#[test]
fn places_and_headings_alone_are_enough() {
    let folder = tempfile::tempdir().unwrap();
    let noise = SensorNoise { s: 2e-3, e_y: 2e-3, e_psi: 2e-3, ..SensorNoise::default() };
    let rows = drive(8, 2.2, noise);
    let table = folder.path().join("poses.csv");
    write_poses(&table, &rows);
    let (account, times) = learn_and_race(folder.path(), &table, &[]);
    assert!(account.contains("8 of 8 laps taken"), "{account}");
    assert!(account.contains("velocities are derivatives"), "{account}");
    assert!(times[0] < best(&rows), "{times:?} after {}", best(&rows));
}

#[test]
fn a_lap_beyond_the_edge_is_refused_and_a_drive_elsewhere_is_none() {
    let folder = tempfile::tempdir().unwrap();
    let mut rows = drive(4, 2.2, SensorNoise::default());
    // In the second lap the car is put back from 0.2 m beside the road.
    let track = Track::builtin("l").unwrap();
    let second = rows.iter().position(|row| row.finished.is_some()).unwrap();
    for row in &mut rows[second + 20..second + 30] {
        let mut x = track.to_frenet(&row.measured, None);
        x.e_y = track.width_left(x.s) + 0.2;
        row.measured = track.to_global(&x);
    }
    let table = folder.path().join("drive.csv");
    write_poses(&table, &rows);
    let learned = folder.path().join("learned.lmpc").display().to_string();
    let file = table.display().to_string();
    let output = lmpc(&["learn", &file, "--out", &learned, "--no-smooth", "--json"]);
    let account: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let taken = account["laps"].as_array().unwrap().iter().filter(|lap| lap["taken"] == true);
    assert_eq!(taken.count(), 3, "{account}");

    for row in &mut rows {
        row.measured.x += 100.0;
    }
    write_poses(&table, &rows);
    let output = lmpc(&["learn", &file, "--out", &learned]);
    let message = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1));
    assert!(message.contains("outside track") && message.contains("same frame"), "{message}");
}
