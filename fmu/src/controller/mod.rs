//! The controller FMU: the same `Controller` as every other host runs.

mod outputs;
mod settings;
mod slots;
mod start;

use std::sync::OnceLock;
use std::time::Instant;

use controller::{Action, Command, Config, Controller, ControllerState, Measurement, Pose, Reason};
use serde::{Deserialize, Serialize};
use vehicle_model::{GlobalState, Input, State};

use crate::description::{Description, Terminal};
use crate::files::{self, CentreLine};
use crate::model::{CommunicationStep, FmuModel, Io};
use crate::schedule::TickSchedule;
use crate::status::CallError;
use crate::table::VariableTable;
use crate::values::VariableValues;
use settings::Tuned;
use slots::Slots;

/// The controller behind FMI: solves at every tick of its period, holds its command between.
pub struct ControllerFmu {
    /// On the heap: it is large, and a host's thread may have a small stack.
    controller: Box<Controller>,
    /// Configuration without the tunable numbers, and those as they act.
    base: Config,
    tuned: Tuned,
    /// Period as configured; ticks times this is the time of a measurement [s].
    period: f64,
    schedule: TickSchedule,
    /// Hash of the fixed configuration.
    identity: u64,
    laps: Laps,
    /// Whether the host knows that its step does not divide the period.
    warned: bool,
}

/// Lap times for the outputs.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
struct Laps {
    finished: u32,
    last_time: f64,
    best_time: f64,
    last_valid: bool,
}

/// What changes while a controller runs.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct ControllerFmuState {
    identity: u64,
    car: u64,
    centre_line: CentreLine,
    ticks: i64,
    laps: Laps,
    tuned: Tuned,
    controller: ControllerState,
}

fn description() -> &'static (Description, Slots) {
    static CELL: OnceLock<(Description, Slots)> = OnceLock::new();
    CELL.get_or_init(|| {
        let mut table = VariableTable::new();
        let slots = Slots::new(&mut table);
        let description = Description {
            model_name: "LMPC controller",
            model_identifier: "lmpc_controller",
            description: "Learning model predictive controller for racing, with error dynamics regression",
            terminals: Terminal::pair("To the car's actuators", "From the car's sensors"),
            documentation: include_str!("../../doc/controller.html"),
            icon: include_bytes!("../../doc/controller.png"),
            ..Description::shipped(table)
        };
        (description, slots)
    })
}

pub(super) fn slots() -> &'static Slots {
    &description().1
}

/// The measurement the inputs hold.
fn measurement(values: &VariableValues, time: f64) -> Measurement {
    let slots = slots();
    let [v_x, v_y, omega_z, e_psi, s, e_y, x, y, psi] = slots.vehicle.map(|r| values.real(r));
    let pose = if values.boolean(slots.global_pose) {
        Pose::Global(GlobalState { x, y, psi, v_x, v_y, omega_z })
    } else {
        Pose::Frenet(State { v_x, v_y, omega_z, e_psi, s, e_y })
    };
    let [a, delta] = slots.applied.map(|r| values.real(r));
    let applied = values.boolean(slots.use_applied).then_some(Input { a, delta });
    Measurement { time, pose, applied }
}

impl ControllerFmu {
    /// Another controller with these tunable numbers takes over all that this one knows.
    fn retune(&mut self, tuned: Tuned) -> Result<(), CallError> {
        if tuned == self.tuned {
            return Ok(());
        }
        let mut config = self.base.clone();
        slots().settings.tune(&tuned, &mut config);
        let (car, track) = (self.controller.car().clone(), self.controller.track().clone());
        let mut next = Controller::new(config, car, track).map_err(start::failed)?;
        next.resume(&self.controller.state());
        (self.controller, self.tuned) = (Box::new(next), tuned);
        Ok(())
    }

    /// Does ahead what the coming tick needs no inputs for, and keeps what was learned if that
    /// finishes the work of a lap's end.
    fn prepare(&mut self, io: &mut Io<'_>) {
        let pending = self.controller.learning_pending();
        self.controller.prepare();
        if pending && !self.controller.learning_pending() {
            self.keep(io);
        }
    }

    /// Counts the lap a step finished.
    fn close_lap(&mut self, io: &mut Io<'_>, command: &Command) {
        let Some(result) = command.status.finished else { return };
        let laps = &mut self.laps;
        laps.finished += 1;
        laps.last_time = result.lap_time;
        laps.last_valid = result.valid;
        if result.valid && (laps.best_time == 0.0 || result.lap_time < laps.best_time) {
            laps.best_time = result.lap_time;
        }
        let valid = if result.valid { "" } else { ", not valid" };
        io.log.event(format!("lap {}: {:.3} s{valid}", result.lap, result.lap_time));
    }

    /// Writes what was learned, if asked to.
    fn keep(&self, io: &mut Io<'_>) {
        let path = io.values.text(slots().save);
        if path.is_empty() {
            return;
        }
        match files::save(path, &self.controller.learned_data()) {
            Ok(()) => io.log.event(format!("learned data written to {path}")),
            // Driving matters more than the file.
            Err(e) => io.log.warn(format!("param.learned_save = '{path}': {e}")),
        }
    }
}

/// Why the host's user should know that a command is not the optimal one.
fn trouble(action: Action, reason: Reason) -> Option<&'static str> {
    let why = match reason {
        Reason::None | Reason::NoSafeSet | Reason::Standstill => return None,
        Reason::SolverFailed => "the optimal control problem was not solved",
        Reason::NonFinite => "an input is not finite",
        Reason::TimeNotAdvancing => "time did not advance",
        Reason::TimeGap => {
            "less than 0.5 or at least 1.5 periods passed since the last step, or time went back"
        }
        Reason::Jump => "the state jumped farther than the car can drive",
        Reason::OffTrack => "the car is beyond a track edge by more than a quarter of the width",
        Reason::WrongWay => "the car points the wrong way",
        Reason::Spin => "the car slides across its own heading",
        Reason::Askew => "the car points across the track",
    };
    // The initial laps need no optimum.
    (action != Action::WarmUp || reason == Reason::Jump).then_some(why)
}

impl FmuModel for ControllerFmu {
    type State = ControllerFmuState;

    fn description() -> &'static Description {
        &description().0
    }

    fn start(io: &mut Io<'_>) -> Result<Self, CallError> {
        let model = start::build(io)?;
        model.publish_start(io.values);
        Ok(model)
    }

    fn in_force(&mut self, values: &mut VariableValues) {
        start::read_back(&self.controller, values);
    }

    fn step(&mut self, io: &mut Io<'_>, step: &CommunicationStep) -> Result<(), CallError> {
        if self.schedule.too_long(step.size) {
            return Err(CallError::Discard(format!(
                "communication step of {} s; the controller's period is {} s and a step must not \
                 be longer (param.period changes it)",
                step.size, self.period
            )));
        }
        if !self.warned && !self.schedule.divides(step.size) {
            self.warned = true;
            io.log.warn(format!(
                "communication step of {} s does not divide the controller's period of {} s: a \
                 command comes up to one such step after its period begins (param.period changes it)",
                step.size, self.period
            ));
        }
        let tick = self.schedule.count();
        if !self.schedule.due_before(step.end() - step.origin, step.size) {
            self.prepare(io);
            return Ok(());
        }
        self.retune(slots().settings.tuned(io.values))?;
        let pending = self.controller.learning_pending();
        let begin = Instant::now();
        // Counted, not summed: equal to every other host's time, bit for bit.
        let command = self.controller.step(&measurement(io.values, tick as f64 * self.period));
        let duration = begin.elapsed().as_secs_f64();
        let status = &command.status;
        if let Some(why) = trouble(status.action, status.reason) {
            io.log.warn(format!("at {} s: {why}; action: {:?}", step.begin, status.action));
        }
        if pending && !self.controller.learning_pending() {
            self.keep(io);
        }
        self.close_lap(io, &command);
        self.publish(io.values, &command, duration);
        // Shorter steps leave one in which there is nothing else to do.
        if 2.0 * step.size > self.period {
            self.prepare(io);
        }
        Ok(())
    }

    fn end(&mut self, io: &mut Io<'_>) {
        if self.controller.learning_pending() {
            self.controller.finish_learning();
            self.keep(io);
        }
    }

    fn state(&self) -> ControllerFmuState {
        ControllerFmuState {
            identity: self.identity,
            car: self.controller.car().fingerprint(),
            centre_line: CentreLine::of(self.controller.track()),
            ticks: self.schedule.count(),
            laps: self.laps,
            tuned: self.tuned,
            controller: self.controller.state(),
        }
    }

    fn resume(&mut self, state: &ControllerFmuState) -> Result<(), CallError> {
        state.centre_line.require(self.controller.track())?;
        let other = if state.car != self.controller.car().fingerprint() {
            "car"
        } else if state.identity != self.identity {
            "configuration"
        } else {
            ""
        };
        if !other.is_empty() {
            return Err(CallError::Refused(format!(
                "the state is of another {other} than this instance's"
            )));
        }
        self.schedule = TickSchedule::resumed(self.period, state.ticks)
            .ok_or_else(|| CallError::Refused("the state counts too many periods".to_owned()))?;
        self.retune(state.tuned)?;
        self.laps = state.laps;
        self.controller.resume(&state.controller);
        Ok(())
    }

    fn save(state: &ControllerFmuState) -> Result<Vec<u8>, CallError> {
        postcard::to_allocvec(state)
            .map_err(|e| CallError::Refused(format!("saving the controller: {e}")))
    }

    fn load(bytes: &[u8]) -> Result<ControllerFmuState, CallError> {
        postcard::from_bytes(bytes)
            .map_err(|e| CallError::Refused(format!("saved controller: {e}")))
    }
}
