//! The vehicle FMU: the simulated car of `vehicle_model`.

mod car;
mod slots;

use std::sync::OnceLock;

use serde::{Deserialize, Serialize};
use vehicle_model::{GripChange, Input, Plant, PlantParams, PlantState, SensorNoise, State};

use crate::description::{Description, Terminal};
use crate::files::{self, CentreLine};
use crate::model::{CommunicationStep, FmuModel, Io};
use crate::status::CallError;
use crate::table::{Real, VariableTable};
use crate::values::VariableValues;
use slots::Slots;

/// The simulated car behind FMI. Any communication step is taken as it is: the plant cuts it
/// into integration steps itself.
#[derive(Debug)]
pub struct VehicleFmu {
    plant: Plant,
    /// Grip factors the plant was built with; they are tunable.
    grip: [f64; 2],
    /// Measurement at the end of the last step: noise is drawn once per step, not per read.
    measured: State,
    /// Whether the host knows that a command was beyond the car's limits.
    warned: bool,
}

/// What changes while a vehicle runs, and the fingerprints of what does not.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct VehicleState {
    car: u64,
    centre_line: CentreLine,
    plant: PlantState,
    grip: [f64; 2],
    measured: State,
}

fn description() -> &'static (Description, Slots) {
    static CELL: OnceLock<(Description, Slots)> = OnceLock::new();
    CELL.get_or_init(|| {
        let mut table = VariableTable::new();
        let slots = Slots::new(&mut table);
        let description = Description {
            model_name: "LMPC vehicle",
            model_identifier: "lmpc_vehicle",
            description: "Single-track race car with tyre model, actuators and noisy sensors",
            terminals: Terminal::pair("What the controller commands", "What the sensors measure"),
            documentation: include_str!("../../doc/vehicle.html"),
            icon: include_bytes!("../../doc/vehicle.png"),
            ..Description::shipped(table)
        };
        (description, slots)
    })
}

fn slots() -> &'static Slots {
    &description().1
}

fn array<const N: usize>(values: &VariableValues, slots: &[Real; N]) -> [f64; N] {
    slots.map(|slot| values.real(slot))
}

impl VehicleFmu {
    /// The plant the parameters describe, at its start.
    fn build(io: &Io<'_>) -> Result<Self, CallError> {
        let (slots, values) = (slots(), &*io.values);
        let name = match values.text(slots.car_name) {
            "" => files::CAR,
            name => name,
        };
        let car = slots.car.read(values, &files::car(io, name)?);
        let mut params = PlantParams::new(car);
        params.substep = values.real(slots.substep);
        let [v_x, v_y, omega_z, e_psi, s, e_y] = array(values, &slots.noise);
        params.noise = SensorNoise { v_x, v_y, omega_z, e_psi, s, e_y };
        params.disturbance.process_std = array(values, &slots.process);
        let [forward, left, x, y] = array(values, &slots.force);
        params.disturbance.force_body_n = [forward, left];
        params.disturbance.force_global_n = [x, y];
        params.seed = u64::from(values.integer(slots.seed).unsigned_abs());
        let grip = array(values, &slots.grip);
        params.disturbance.grip = grip_changes(grip);
        let [v_x, v_y, omega_z, e_psi, s, e_y] = array(values, &slots.initial);
        let initial = State { v_x, v_y, omega_z, e_psi, s, e_y };
        let track = files::track(io, values.text(slots.track))?;
        let plant =
            Plant::new(params, track, initial).map_err(|e| CallError::Failed(e.to_string()))?;
        Ok(Self { plant, grip, measured: initial, warned: false })
    }

    /// Grip may change while stepping; everything else of the plant stays.
    fn retune(&mut self, values: &VariableValues) -> Result<(), CallError> {
        let grip = array(values, &slots().grip);
        self.set_grip(grip)
    }

    fn set_grip(&mut self, grip: [f64; 2]) -> Result<(), CallError> {
        if grip == self.grip {
            return Ok(());
        }
        let mut params = self.plant.params().clone();
        params.disturbance.grip = grip_changes(grip);
        let (track, state) = (self.plant.track().clone(), self.plant.state().clone());
        let mut plant = Plant::new(params, track, self.plant.truth())
            .map_err(|e| CallError::Failed(e.to_string()))?;
        plant.restore(state);
        (self.plant, self.grip) = (plant, grip);
        Ok(())
    }

    /// Warns once of a command beyond the car's limits, which is cut; not of a rounding error.
    fn check_command(&mut self, io: &mut Io<'_>, [a, delta]: [f64; 2], step: &CommunicationStep) {
        let car = &self.plant.params().car;
        let ranges = [
            ("cmd.a", a, [car.a_min, car.a_max], "m/s2"),
            ("cmd.delta", delta, [-car.delta_max, car.delta_max], "rad"),
        ];
        for (name, value, [min, max], unit) in ranges {
            let slack = 1e-6 * (max - min);
            if !self.warned && !(min - slack..=max + slack).contains(&value) {
                self.warned = true;
                io.log.warn(format!(
                    "at {} s: {name} = {value} {unit} is outside the car's range of {min} to {max} \
                     {unit} and is cut to it; later ones are cut without a word",
                    step.begin
                ));
            }
        }
    }

    fn publish(&self, values: &mut VariableValues) {
        let slots = slots();
        let track = self.plant.track();
        let mut write = |slots: &[Real; 9], x: &State| {
            let pose = track.to_global(x);
            let all = [x.v_x, x.v_y, x.omega_z, x.e_psi, x.s, x.e_y, pose.x, pose.y, pose.psi];
            slots.iter().zip(all).for_each(|(slot, value)| values.set_real(*slot, value));
        };
        write(&slots.measured, &self.measured);
        write(&slots.truth, &self.plant.truth());
        let (applied, tyres) = (self.plant.applied(), self.plant.tyres());
        values.set_real(slots.applied[0], applied.a);
        values.set_real(slots.applied[1], applied.delta);
        let axles =
            [tyres.long, tyres.lateral, tyres.vertical, tyres.slip, self.plant.utilisation()];
        for (pair, numbers) in slots.tyres.iter().zip(axles) {
            pair.iter().zip(numbers).for_each(|(slot, number)| values.set_real(*slot, number));
        }
        values.set_real(slots.way[0], self.plant.lap() as f64);
        values.set_real(slots.way[1], self.plant.progress());
        values.set_real(slots.way[2], track.kappa(self.plant.truth().s));
    }
}

fn grip_changes(grip: [f64; 2]) -> Vec<GripChange> {
    if grip == [1.0; 2] {
        return Vec::new();
    }
    vec![GripChange { factor: grip, time_s: None, s_m: None }]
}

impl FmuModel for VehicleFmu {
    type State = VehicleState;

    fn description() -> &'static Description {
        &description().0
    }

    fn start(io: &mut Io<'_>) -> Result<Self, CallError> {
        let mut model = Self::build(io)?;
        model.measured = model.plant.measure();
        model.publish(io.values);
        let track = model.plant.track();
        io.log.event(format!("car on track '{}', {} m long", track.name(), track.length()));
        Ok(model)
    }

    fn in_force(&mut self, values: &mut VariableValues) {
        slots().car.write(&self.plant.params().car, values);
    }

    fn step(&mut self, io: &mut Io<'_>, step: &CommunicationStep) -> Result<(), CallError> {
        self.retune(io.values)?;
        let [a, delta] = array(io.values, &slots().command);
        self.check_command(io, [a, delta], step);
        self.plant.apply(Input { a, delta }, step.size);
        if !self.plant.truth().is_finite() {
            return Err(CallError::Failed(format!(
                "the car's state is no longer finite at {} s: an integration step of {} s is too \
                 long for it, or a parameter is extreme",
                step.end(),
                self.plant.params().substep
            )));
        }
        self.measured = self.plant.measure();
        self.publish(io.values);
        Ok(())
    }

    fn state(&self) -> VehicleState {
        VehicleState {
            car: self.plant.params().car.fingerprint(),
            centre_line: CentreLine::of(self.plant.track()),
            plant: self.plant.state().clone(),
            grip: self.grip,
            measured: self.measured,
        }
    }

    fn resume(&mut self, state: &VehicleState) -> Result<(), CallError> {
        state.centre_line.require(self.plant.track())?;
        if state.car != self.plant.params().car.fingerprint() {
            return Err(CallError::Refused(
                "the car file holds another car than when saved".to_owned(),
            ));
        }
        // The grip of the last step; a later change in the values acts in the next one.
        self.set_grip(state.grip)?;
        self.plant.restore(state.plant.clone());
        self.measured = state.measured;
        Ok(())
    }

    fn save(state: &VehicleState) -> Result<Vec<u8>, CallError> {
        postcard::to_allocvec(state).map_err(|e| CallError::Refused(format!("saving the car: {e}")))
    }

    fn load(bytes: &[u8]) -> Result<VehicleState, CallError> {
        postcard::from_bytes(bytes).map_err(|e| CallError::Refused(format!("saved car: {e}")))
    }
}
