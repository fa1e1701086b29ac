//! Any vendor's vehicle-model FMU as the car: FMI 2.0 and 3.0 co-simulation, by a table that says
//! which of its variables is which of our quantities.

mod correct;
mod element;
mod error;
mod guess;
mod heard;
pub mod map;
mod names;
mod preload;
mod reduced;
mod sense;
mod signals;
mod slave;
pub mod trial;
pub mod units;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use vehicle_model::track::wrap_angle;
use vehicle_model::{CarParams, GlobalState, Input, State, Track};

use super::{Vehicle, VehicleError};
pub use correct::correct;
use element::find;
pub use error::FmuError;
pub use guess::{is_ours, map_of_ours, propose};
use map::{Entry, Frame, Map, input_quantities, quantities_of};
pub use slave::{CoSimInstance, ImportedVariable, VariableValue};
use units::Dimension;

/// Communication steps are cut so that none is longer than the map's, give or take this share.
const STEP_SLACK: f64 = 1e-6;

/// What a vehicle FMU needs to begin.
#[derive(Debug, Clone)]
pub struct FmuOptions {
    /// The FMU.
    pub file: PathBuf,
    /// Its map; ours needs none.
    pub map: Option<Map>,
    /// A library to load first.
    pub preload: Option<PathBuf>,
    /// The car it stands for: limits, and tyres its slips are judged by.
    pub car: CarParams,
    /// What `{car}` is in the map's parameters.
    pub car_name: String,
    /// The track.
    pub track: Arc<Track>,
    /// What `{track}` is in the map's parameters.
    pub track_name: String,
    /// What `{seed}` is in the map's parameters.
    pub seed: u64,
    /// Where it starts, in the track's frame.
    pub start: State,
}

/// Variables in our order, each with factor and offset to our unit.
#[derive(Debug, Default)]
struct Group {
    variables: Vec<ImportedVariable>,
    conversions: Vec<(f64, f64)>,
    values: Vec<f64>,
    /// The first two are speed over ground and side slip.
    polar: bool,
}

impl Group {
    fn new(
        slave: &CoSimInstance,
        table: &std::collections::BTreeMap<String, Entry>,
        quantities: &[(&str, Dimension)],
    ) -> Result<Self, FmuError> {
        let mut group = Self::default();
        for (name, dimension) in quantities {
            let Some(entry) = table.get(*name) else { continue };
            let variable = slave.variable(entry.variable())?;
            let own = find(slave.inspection(), entry.variable()).map_or("", |(row, _)| &row.unit);
            let conversion = entry
                .factor(own, *dimension)
                .map_err(|what| FmuError::Map(format!("{name} = {}: {what}", variable.name)))?;
            group.variables.push(variable);
            group.conversions.push(conversion);
            group.values.push(0.0);
        }
        Ok(group)
    }

    fn read(&mut self, slave: &mut CoSimInstance) -> Result<(), FmuError> {
        slave.numbers(&self.variables, &mut self.values)?;
        for (value, (factor, offset)) in self.values.iter_mut().zip(&self.conversions) {
            *value = factor * *value + offset;
        }
        if let (true, [speed, slip, ..]) = (self.polar, &mut self.values[..]) {
            (*speed, *slip) = (*speed * slip.cos(), *speed * slip.sin());
        }
        Ok(())
    }

    fn write(&mut self, slave: &mut CoSimInstance, ours: &[f64]) -> Result<(), FmuError> {
        for ((value, ours), (factor, offset)) in
            self.values.iter_mut().zip(ours).zip(&self.conversions)
        {
            *value = (ours - offset) / factor;
        }
        slave.set_numbers(&self.variables, &self.values)
    }
}

/// A vehicle FMU on a track.
pub struct FmuVehicle {
    slave: CoSimInstance,
    name: String,
    frame: Frame,
    step: Option<f64>,
    car: CarParams,
    track: Arc<Track>,
    input: Group,
    measurement: Group,
    truth: Group,
    actuators: Group,
    time: f64,
    measured: State,
    true_state: State,
    applied: Input,
    lap: i64,
}

impl FmuVehicle {
    /// Loads an FMU and takes it through its initialisation.
    ///
    /// # Errors
    /// [`FmuError`] if FMU and map do not fit, or the FMU refuses.
    pub fn new(options: FmuOptions) -> Result<Self, FmuError> {
        let mut slave = CoSimInstance::open(&options.file, options.preload.as_deref())?;
        let map = match options.map.clone() {
            Some(map) => map,
            None => map_of_ours(slave.inspection()).ok_or_else(|| {
                let file = options.file.display();
                FmuError::Map(format!(
                    "{file} is not our vehicle FMU, so it needs a map (`lmpc vehicle inspect \
                     {file}` proposes one)"
                ))
            })?,
        };
        let input = Group::new(&slave, &map.input, &input_quantities())?;
        let states = |table| -> Result<Group, FmuError> {
            let (quantities, polar) = quantities_of(map.frame, table);
            Ok(Group { polar, ..Group::new(&slave, table, &quantities)? })
        };
        let (measurement, truth) = (states(&map.state)?, states(&map.truth)?);
        let actuators = Group::new(&slave, &map.applied, &input_quantities())?;
        for (name, value) in &map.parameters {
            let variable = slave.variable(name)?;
            slave.set(&variable, &options.parameter(name, value)?)?;
        }
        let (state, polar) = quantities_of(map.frame, &map.initial);
        let mut start = in_frame(map.frame, &options.track, &options.start);
        if polar {
            let [v_x, v_y, ..] = start;
            (start[0], start[1]) = (v_x.hypot(v_y), v_y.atan2(v_x));
        }
        let quantities = state.into_iter().zip(start);
        let (names, values): (Vec<_>, Vec<f64>) =
            quantities.filter(|((name, _), _)| map.initial.contains_key(*name)).unzip();
        Group::new(&slave, &map.initial, &names)?.write(&mut slave, &values)?;
        slave.begin()?;
        let mut vehicle = Self {
            name: options.file.display().to_string(),
            frame: map.frame,
            step: map.step_s,
            car: options.car,
            track: options.track,
            slave,
            input,
            measurement,
            truth,
            actuators,
            time: 0.0,
            measured: options.start,
            true_state: options.start,
            applied: Input::default(),
            lap: 0,
        };
        vehicle.read(options.start.s)?;
        Ok(vehicle)
    }

    /// What is inside the FMU.
    #[must_use]
    pub fn inspection(&self) -> &fmu_core::Inspection {
        self.slave.inspection()
    }

    fn read(&mut self, hint: f64) -> Result<(), FmuError> {
        let (frame, track) = (self.frame, Arc::clone(&self.track));
        self.measurement.read(&mut self.slave)?;
        self.measured = from_frame(frame, &track, &self.measurement.values, hint);
        self.true_state = if self.truth.variables.is_empty() {
            self.measured
        } else {
            self.truth.read(&mut self.slave)?;
            from_frame(frame, &track, &self.truth.values, hint)
        };
        if let [_, _] = self.actuators.variables[..] {
            self.actuators.read(&mut self.slave)?;
            self.applied = Input { a: self.actuators.values[0], delta: self.actuators.values[1] };
        }
        Ok(())
    }

    fn advance(&mut self, u: Input, dt: f64) -> Result<(), FmuError> {
        let before = self.true_state.s;
        self.applied = u;
        self.input.write(&mut self.slave, &[u.a, u.delta])?;
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "above 0")]
        let steps = self.step.map_or(1, |h| (dt / h - STEP_SLACK).ceil().max(1.0) as u32);
        let size = dt / f64::from(steps);
        for i in 0..steps {
            self.slave.step(self.time + f64::from(i) * size, size)?;
        }
        self.time += dt;
        self.read(before)?;
        // No car drives half a lap in a period: a farther jump is the line.
        let (moved, half) = (self.true_state.s - before, 0.5 * self.track.length());
        self.lap += i64::from(moved < -half) - i64::from(moved > half);
        Ok(())
    }
}

impl trial::TrialCar for FmuVehicle {
    type Error = VehicleError;

    fn drive(&mut self, u: Input, dt: f64) -> Result<[f64; 6], VehicleError> {
        self.apply(u, dt)?;
        let g = match (self.frame, &self.measurement.values[..]) {
            // As it comes: a wrong pose may have no place on the track.
            (Frame::Global, &[v_x, v_y, omega_z, x, y, psi]) => {
                return Ok([v_x, v_y, omega_z, x, y, psi]);
            }
            _ => self.track.to_global(&self.measured),
        };
        Ok([g.v_x, g.v_y, g.omega_z, g.x, g.y, g.psi])
    }
}

impl Vehicle for FmuVehicle {
    fn measure(&mut self) -> State {
        self.measured
    }

    fn truth(&self) -> State {
        self.true_state
    }

    fn apply(&mut self, u: Input, dt: f64) -> Result<(), VehicleError> {
        if !(dt.is_finite() && dt > 0.0) {
            return Ok(());
        }
        let (name, time) = (self.name.clone(), self.time);
        self.advance(u, dt).map_err(|e| VehicleError::Step { name, time, reason: e.to_string() })
    }

    fn applied(&self) -> Input {
        self.applied
    }

    fn progress(&self) -> f64 {
        #[expect(clippy::cast_precision_loss, reason = "laps are few")]
        let laps = self.lap as f64;
        laps * self.track.length() + self.true_state.s
    }

    fn track(&self) -> &Arc<Track> {
        &self.track
    }

    fn car(&self) -> &CarParams {
        &self.car
    }
}

impl FmuOptions {
    /// A parameter's value with the command line's words in it.
    fn parameter(&self, name: &str, value: &toml::Value) -> Result<VariableValue, FmuError> {
        #[expect(clippy::cast_precision_loss, reason = "seeds and counts")]
        Ok(match value {
            toml::Value::Float(number) => VariableValue::Number(*number),
            toml::Value::Integer(number) => VariableValue::Number(*number as f64),
            toml::Value::Boolean(flag) => VariableValue::Boolean(*flag),
            toml::Value::String(text) if text == "{seed}" => {
                VariableValue::Number(self.seed as f64)
            }
            toml::Value::String(text) => VariableValue::Text(
                text.replace("{track}", &self.track_name).replace("{car}", &self.car_name),
            ),
            other => {
                return Err(FmuError::Map(format!(
                    "parameters.{name}: found {}, expected a number, truth value or text",
                    other.type_str()
                )));
            }
        })
    }
}

/// A state of ours as the six quantities of a frame.
fn in_frame(frame: Frame, track: &Track, x: &State) -> [f64; 6] {
    match frame {
        Frame::Track => x.to_vector().into(),
        Frame::Global => {
            let g = track.to_global(x);
            [g.v_x, g.v_y, g.omega_z, g.x, g.y, g.psi]
        }
    }
}

/// A state of ours from the six quantities of a frame; `hint` is where it was before.
fn from_frame(frame: Frame, track: &Track, values: &[f64], hint: f64) -> State {
    let value = |i: usize| values.get(i).copied().unwrap_or(f64::NAN);
    let [v_x, v_y, omega_z, d, e, f] = [0, 1, 2, 3, 4, 5].map(value);
    match frame {
        Frame::Track => {
            let (e_psi, s) = (wrap_angle(d), track.wrap(e));
            State { v_x, v_y, omega_z, e_psi, s, e_y: f }
        }
        Frame::Global => {
            let pose = GlobalState { x: d, y: e, psi: f, v_x, v_y, omega_z };
            track.to_frenet(&pose, Some(hint))
        }
    }
}

/// Every problem of a map with its FMU: unknown variables, wrong units, wrong causalities.
///
/// # Errors
/// [`FmuError`] if the FMU cannot be looked into.
pub fn misfits(map: &Map, file: &Path) -> Result<Vec<(String, String)>, FmuError> {
    let inspection = fmu_core::inspect(file)?;
    let mut found = Vec::new();
    for (key, entry, dimension) in map.entries() {
        let name = entry.variable();
        let row = match find(&inspection, name) {
            Ok((row, _)) => row,
            Err(what) => {
                found.push((key, format!("variable `{name}` of {}: {what}", file.display())));
                continue;
            }
        };
        let expected = match key.split('.').next() {
            Some("input") => "input",
            Some("initial") => "parameter",
            _ => "output",
        };
        if row.causality != expected && (expected != "output" || row.causality == "input") {
            found.push((
                key.clone(),
                format!("`{name}` is of causality {}, expected {expected}", row.causality),
            ));
        }
        if let Err(what) = entry.factor(&row.unit, dimension) {
            found.push((key, format!("`{name}`: {what}")));
        }
    }
    for name in map.parameters.keys() {
        if let Err(what) = find(&inspection, name) {
            let shown = file.display();
            found.push((
                format!("parameters.{name}"),
                format!("variable `{name}` of {shown}: {what}"),
            ));
        }
    }
    Ok(found)
}
