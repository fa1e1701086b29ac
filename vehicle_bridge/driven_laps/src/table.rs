//! A drive from a table in CSV: `trajectory.csv` of a race, an exported channel, any other logger's.

use std::path::Path;

use anyhow::{Context as _, Result, bail};
use bounded_file::Limit;
use controller::Pose;
use csv::StringRecord;
use lcm_types::VehicleState;
use vehicle_model::{GlobalState, Input, State};

use super::clock::ClockStart;
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
    let (valid, steer, inputs) = (find(VALID), find(STEER), [find(A), find(DELTA)]);
    let place = if global.iter().all(Option::is_some) { global } else { frenet };
    let start = table.start(time);
    let mut recording = Recording { rows: "lines", ..Recording::default() };
    for row in 0..table.rows.len() {
        let line = table.line(row);
        let bits = valid.and_then(|column| table.number(row, column));
        let has = |bit: i32| bits.is_none_or(|bits| bits as i64 & i64::from(bit) != 0);
        let at = |column: Option<usize>| table.number(row, column?);
        let fault = |columns: &[Option<usize>]| match table.empty(row, columns) {
            Some(name) => format!("no number in {name}"),
            None => "not marked as valid".to_owned(),
        };
        let (Some(time), Some(pose)) = (
            start.and_then(|start| start.seconds(table.text(row, time.0)?, time.1)),
            pose(row).filter(|_| has(VehicleState::POSE)),
        ) else {
            let [x, y, angle] = place;
            recording.left_out.add(line, &fault(&[Some(time.0), x, y, angle]));
            continue;
        };
        let measured = match velocities.map(at) {
            [Some(v_x), Some(v_y), Some(omega_z)] if has(VehicleState::VEL) => {
                Some([v_x, v_y, omega_z])
            }
            _ => None,
        };
        let steering = at(steer).filter(|_| has(VehicleState::STEER));
        let all = velocities.iter().all(Option::is_some);
        for (lacks, columns) in [
            (all && measured.is_none(), &velocities[..]),
            (steer.is_some() && steering.is_none(), &[steer]),
        ] {
            if lacks {
                recording.lacks.push((line, fault(columns).into()));
            }
        }
        recording.states.push(Recorded {
            time,
            row: line,
            pose,
            velocities: measured,
            steer: steering,
        });
        match inputs.map(at) {
            [Some(a), Some(delta)] => recording.inputs.push((time, Input { a, delta })),
            _ if inputs.iter().all(Option::is_some) => {
                recording.inputs_left_out.add(line, &fault(&inputs));
            }
            _ => {}
        }
    }
    if recording.states.is_empty() {
        bail!(
            "{shown}: none of {} rows holds a state; left out were lines {}",
            table.rows.len(),
            recording.left_out
        );
    }
    let reports = path.with_file_name(REPORTS);
    if recording.inputs.is_empty() && reports.exists() && find(VALID).is_some() {
        recording.inputs = applied(&reports, start)?;
        recording.applied = true;
    }
    Ok(recording)
}

/// The reports beside an exported channel of states.
fn applied(path: &Path, start: Option<ClockStart>) -> Result<Vec<(f64, Input)>> {
    let table = Table::open(path)?;
    let columns = (table.time(), table.column(&["accel"]), table.column(STEER));
    let (Some(time), Some(a), Some(delta)) = columns else {
        bail!("{}: expected columns accel and steer of an export", path.display());
    };
    let row = |row| {
        let (a, delta) = (table.number(row, a)?, table.number(row, delta)?);
        Some((start?.seconds(table.text(row, time.0)?, time.1)?, Input { a, delta }))
    };
    Ok(until_then((0..table.rows.len()).filter_map(row).collect()))
}

/// A row in whose numbers a comma is the decimal point.
fn with_points(row: StringRecord) -> StringRecord {
    if !row.iter().any(|word| word.contains(',')) {
        return row;
    }
    let point =
        |word: &str| if word.contains('.') { word.to_owned() } else { word.replacen(',', ".", 1) };
    let mut with: StringRecord = row.iter().map(point).collect();
    with.set_position(row.position().cloned());
    with
}

/// Rows of text under a header.
struct Table {
    header: Vec<String>,
    rows: Vec<StringRecord>,
}

/// A column of time and its unit \[s\].
type Clock = (usize, f64);

impl Table {
    fn open(path: &Path) -> Result<Self> {
        let shown = path.display();
        let text = bounded_file::text(path, Limit::RECORDING)?;
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
        let decimal = |row: StringRecord| if delimiter == b',' { row } else { with_points(row) };
        let rows = reader.records().map(|row| row.map(decimal)).collect::<Result<_, _>>();
        let rows = rows.with_context(|| format!("cannot read {shown}"))?;
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

    /// Where the clock starts: with the first row that has a time.
    fn start(&self, clock: Clock) -> Option<ClockStart> {
        let mut rows = 0..self.rows.len();
        rows.find_map(|row| ClockStart::of(self.text(row, clock.0)?, clock.1))
    }

    /// Line of a row in the file, from 1.
    fn line(&self, row: usize) -> u64 {
        self.rows[row].position().map_or(0, csv::Position::line)
    }

    fn text(&self, row: usize, column: usize) -> Option<&str> {
        self.rows[row].get(column)
    }

    fn number(&self, row: usize, column: usize) -> Option<f64> {
        self.text(row, column)?.parse().ok().filter(|v: &f64| v.is_finite())
    }

    /// The name of the first of these columns that there is without a number in this row.
    fn empty(&self, row: usize, columns: &[Option<usize>]) -> Option<&str> {
        let mut there = columns.iter().flatten();
        let column = there.find(|column| self.number(row, **column).is_none())?;
        Some(&self.header[*column])
    }
}
