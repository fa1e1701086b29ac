//! A drive from a table in CSV: `trajectory.csv` of a race, an exported channel, any other logger's.

use std::path::Path;

use anyhow::{Context as _, Result, bail};
use controller::Pose;
use lcm_types::VehicleState;
use vehicle_model::{GlobalState, Input, State};

use super::log::until_then;
use super::{Recorded, Recording};

/// Units in which a column is taken.
const UNITS: [&str; 7] = ["s", "m", "rad", "m/s", "rad/s", "m/s2", "m/s^2"];
/// Names a column may have.
const TIME: &[&str] = &["time_s", "time", "t", "t_s", "timestamp"];
const X: &[&str] = &["x_m", "x"];
const Y: &[&str] = &["y_m", "y"];
const PSI: &[&str] = &["psi_rad", "psi", "yaw_rad", "yaw", "heading", "heading_rad", "theta"];
const S: &[&str] = &["s_m", "s"];
const E_Y: &[&str] = &["e_y_m", "e_y"];
const E_PSI: &[&str] = &["e_psi_rad", "e_psi"];
const V_X: &[&str] = &["v_x_mps", "vx_mps", "v_x", "vx"];
const V_Y: &[&str] = &["v_y_mps", "vy_mps", "v_y", "vy"];
const OMEGA_Z: &[&str] = &["omega_z_radps", "yaw_rate_radps", "omega_z", "yaw_rate"];
const A: &[&str] = &["a_mps2", "a", "accel", "accel_mps2"];
const DELTA: &[&str] = &["delta_rad", "delta", "steer_rad", "steering_angle", "steering_angle_rad"];
/// Steering angle that was measured, not commanded, and the states' own clock, of an export.
const STEER: &[&str] = &["steer"];
const MEASURED_NS: &[&str] = &["meas_mono_ns"];
const SENT_NS: &[&str] = &["h.mono_ns"];
/// Which groups of an exported state hold a measurement: position, velocities, steering angle.
const VALID: &[&str] = &["valid"];
/// What an export calls the reports of what was applied.
const REPORTS: &str = "CAR_ACT.csv";

/// Reads a table.
pub(super) fn read(path: &Path) -> Result<Recording> {
    let table = Table::open(path)?;
    let shown = path.display();
    let Some(time) = table.time() else {
        bail!("{shown}: no column of time; expected one of {}", TIME.join(", "));
    };
    let find = |names| table.column(names);
    let (global, frenet) = ([find(X), find(Y), find(PSI)], [find(S), find(E_Y), find(E_PSI)]);
    let pose: Box<dyn Fn(usize) -> Option<Pose>> = if let [Some(x), Some(y), Some(psi)] = global {
        let table = &table;
        Box::new(move |row| {
            let (x, y, psi) =
                (table.number(row, x)?, table.number(row, y)?, table.number(row, psi)?);
            Some(Pose::Global(GlobalState { x, y, psi, ..GlobalState::default() }))
        })
    } else if let [Some(s), Some(e_y), Some(e_psi)] = frenet {
        let table = &table;
        Box::new(move |row| {
            let s = table.number(row, s)?;
            let (e_y, e_psi) = (table.number(row, e_y)?, table.number(row, e_psi)?);
            Some(Pose::Frenet(State { s, e_y, e_psi, ..State::default() }))
        })
    } else {
        bail!(
            "{shown}: no place of the car; expected columns x_m, y_m, psi_rad (or x, y, yaw), or s_m, \
             e_y_m, e_psi_rad; found {}",
            table.header.join(", ")
        );
    };
    let velocities = [find(V_X), find(V_Y), find(OMEGA_Z)];
    let (valid, steer) = (find(VALID), find(STEER));
    let mut recording = Recording::default();
    for row in 0..table.rows.len() {
        let bits = valid.and_then(|column| table.number(row, column));
        let has = |bit: i32| bits.is_none_or(|bits| bits as i64 & i64::from(bit) != 0);
        let at = |column: Option<usize>| table.number(row, column?);
        let (Some(time), Some(pose)) =
            (table.seconds(row, time), pose(row).filter(|_| has(VehicleState::POSE)))
        else {
            recording.unusable += 1;
            continue;
        };
        let velocities = match velocities.map(at) {
            [Some(v_x), Some(v_y), Some(omega_z)] if has(VehicleState::VEL) => {
                Some([v_x, v_y, omega_z])
            }
            _ => None,
        };
        let steer = at(steer).filter(|_| has(VehicleState::STEER));
        recording.states.push(Recorded { time, pose, velocities, steer });
        if let (Some(a), Some(delta)) = (at(find(A)), at(find(DELTA))) {
            recording.inputs.push((time, Input { a, delta }));
        }
    }
    if recording.states.is_empty() {
        bail!("{shown}: none of {} rows holds a state", table.rows.len());
    }
    let reports = path.with_file_name(REPORTS);
    if recording.inputs.is_empty() && reports.exists() && find(VALID).is_some() {
        recording.inputs = applied(&reports)?;
        recording.applied = true;
    }
    Ok(recording)
}

/// The reports beside an exported channel of states.
fn applied(path: &Path) -> Result<Vec<(f64, Input)>> {
    let table = Table::open(path)?;
    let columns = (table.time(), table.column(&["accel"]), table.column(STEER));
    let (Some(time), Some(a), Some(delta)) = columns else {
        bail!("{}: expected columns accel and steer of an export", path.display());
    };
    let row = |row| {
        let (a, delta) = (table.number(row, a)?, table.number(row, delta)?);
        Some((table.seconds(row, time)?, Input { a, delta }))
    };
    Ok(until_then((0..table.rows.len()).filter_map(row).collect()))
}

/// Rows of text under a header.
struct Table {
    header: Vec<String>,
    rows: Vec<Vec<String>>,
}

/// A column of time and its unit \[s\].
type Clock = (usize, f64);

impl Table {
    fn open(path: &Path) -> Result<Self> {
        let shown = path.display();
        let text = std::fs::read_to_string(path).with_context(|| format!("cannot read {shown}"))?;
        let first = text.lines().next().unwrap_or_default();
        let delimiter = [',', ';', '\t']
            .into_iter()
            .max_by_key(|c| first.matches(*c).count())
            .map_or(b',', |c| c as u8);
        let text = text.trim_start_matches(['#', ' ', '\u{feff}']);
        let mut reader = csv::ReaderBuilder::new()
            .delimiter(delimiter)
            .trim(csv::Trim::All)
            .flexible(true)
            .from_reader(text.as_bytes());
        let header = reader.headers().with_context(|| format!("{shown} is no table in CSV"))?;
        // The unit may stand behind the name: `x [m]`, `t (s)`. A column in another unit is an unknown one.
        let name = |column: &str| {
            let column = column.to_lowercase();
            match column.split_once(['[', '(']) {
                Some((name, unit)) if UNITS.contains(&unit.trim_end_matches([']', ')'])) => {
                    name.trim_end().to_owned()
                }
                _ => column,
            }
        };
        let header = header.iter().map(name).collect();
        let rows = reader.records().map(|row| row.map(|r| r.iter().map(str::to_owned).collect()));
        let rows =
            rows.collect::<Result<_, _>>().with_context(|| format!("cannot read {shown}"))?;
        Ok(Self { header, rows })
    }

    fn column(&self, names: &[&str]) -> Option<usize> {
        names.iter().find_map(|name| self.header.iter().position(|column| column == name))
    }

    /// The measurements' own clock where there is one: that of the recorder jitters.
    fn time(&self) -> Option<Clock> {
        let own = self.column(MEASURED_NS).or_else(|| self.column(SENT_NS));
        own.map(|column| (column, 1e-9)).or_else(|| Some((self.column(TIME)?, 1.0)))
    }

    fn seconds(&self, row: usize, clock: Clock) -> Option<f64> {
        Some(self.number(row, clock.0)? * clock.1)
    }

    fn number(&self, row: usize, column: usize) -> Option<f64> {
        self.rows[row].get(column)?.parse().ok().filter(|v: &f64| v.is_finite())
    }
}
