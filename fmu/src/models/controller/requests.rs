//! What the host asks of a controller that drives: to bring the car to a stand, and to recover.
//!
//! While the car is to stand the controller is not stepped, as in `lmpc serve`: what acts is not its
//! command, and standing teaches nothing. It goes on when the car has come to a stand and the request
//! is over: then its old plan is worth nothing, and it makes a new one. The lap in progress does not
//! count as valid.

use controller::{Action, Command, Controller, LapNumber, Measurement, Pose, Reason, Status};
use serde::{Deserialize, Serialize};
use vehicle_model::{Input, Limited, Limiter, State, Tracker};

use super::slots;
use crate::model::Io;
use crate::values::VariableValues;

/// Slower than this the brake stays pressed [m/s],
const HOLD_BELOW: f64 = 0.5;
/// so hard, as a share of full braking: as `lmpc bridge` holds a car.
const HOLD: f64 = 0.2;
/// Share of the speed of the initial laps, or of the speed cap, below which the car stands.
const STILL: f64 = 0.1;

/// How far a requested stop is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
enum Stop {
    /// None: the controller drives.
    #[default]
    None,
    /// The car brakes along the track.
    Braking,
    /// The car stands.
    Standing,
    /// The request is over, and the controller does not yet believe where the car is.
    Starting,
}

/// The requests as they act.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(super) struct Requests {
    stop: Stop,
    /// Whether the last step of the controller was one of a recovery.
    recovering: bool,
    /// Leave to recover.
    leave: bool,
    /// State at the last tick.
    seen: Option<State>,
}

impl Requests {
    /// Whether the controller may recover now though its configuration does not say so: while it is
    /// asked to, and until a recovery that began is over.
    pub(super) fn leave(&self, values: &VariableValues) -> bool {
        values.boolean(slots().recover) || (self.leave && self.recovering)
    }

    /// Takes in the leave in force.
    pub(super) fn allow(&mut self, leave: bool) {
        self.leave = leave;
    }

    /// Code of `status.request`.
    pub(super) fn code(&self) -> f64 {
        match self.stop {
            Stop::Braking => 1.0,
            Stop::Standing | Stop::Starting => 2.0,
            Stop::None if self.leave => 3.0,
            Stop::None => 0.0,
        }
    }

    /// The command at a tick, from the controller or, while the car is to stand, without it.
    pub(super) fn step(
        &mut self,
        controller: &mut Controller,
        io: &mut Io<'_>,
        measurement: &Measurement,
        speed_cap: f64,
    ) -> Command {
        let x = self.state(controller, measurement);
        self.seen = Some(x);
        let config = controller.config();
        let cap = if speed_cap > 0.0 { speed_cap } else { f64::INFINITY };
        let stands = x.v_x < STILL * config.warm_up.speed.min(cap);
        let asked = io.values.boolean(slots().stop);
        match self.stop {
            Stop::None if asked => {
                self.stop = Stop::Braking;
                io.log.event(format!("at {} s: the car stops, as requested", measurement.time));
            }
            Stop::Starting if asked => self.stop = Stop::Standing,
            _ => {}
        }
        if self.stop == Stop::Braking && stands {
            self.stop = Stop::Standing;
        }
        if self.stop == Stop::Standing && !asked {
            self.stop = Stop::Starting;
            io.log.event(format!("at {} s: the car may drive on", measurement.time));
        }
        if matches!(self.stop, Stop::Braking | Stop::Standing) {
            return braked(controller, io.values, &x);
        }
        let command = controller.step(measurement);
        self.recovering = command.status.action == Action::Recovering;
        self.leave &= self.recovering || io.values.boolean(slots().recover);
        if self.stop == Stop::Starting {
            if command.status.reason == Reason::Jump {
                // It takes the way of the stop for a jump, until it has seen the car there again.
                return braked(controller, io.values, &x);
            }
            self.stop = Stop::None;
        }
        command
    }

    /// Whether a gap in time and place is one that the host's request made.
    pub(super) fn explains(&self, before: &Self) -> bool {
        before.stop != Stop::None || self.stop != Stop::None
    }

    /// The state of a measurement in the track's frame. Where velocities are not measured, the speed is
    /// that of the way since the last tick.
    fn state(&self, controller: &Controller, measurement: &Measurement) -> State {
        let (track, config) = (controller.track(), controller.config());
        let x = match measurement.pose {
            Pose::Frenet(x) => State { s: track.wrap(x.s), ..x },
            Pose::Global(pose) => track.to_frenet(&pose, self.seen.map(|seen| seen.s)),
        };
        if !config.filter.active || config.filter.velocities {
            return x;
        }
        let here = track.to_global(&x);
        let from = self.seen.map_or(here, |seen| track.to_global(&seen));
        let (dx, dy) = (here.x - from.x, here.y - from.y);
        let way = (dx * dx + dy * dy).sqrt();
        State { v_x: way / config.horizon.period, v_y: 0.0, omega_z: 0.0, ..x }
    }
}

/// What brings the car to a stand along the track, and holds it there.
fn braked(controller: &Controller, values: &VariableValues, x: &State) -> Command {
    let (car, slots) = (controller.car(), slots());
    let asked = Tracker::new(car).brake(x, controller.track());
    let held = if x.v_x < HOLD_BELOW { HOLD * car.a_min } else { 0.0 };
    let asked = Input { a: asked.a.min(held), ..asked };
    let [a, delta] = slots.command.map(|slot| values.real(slot));
    let period = controller.config().horizon.period;
    let Limited { sent, bits, .. } =
        Limiter::new(car).limit(asked, Input { a, delta }, x.v_x, period);
    let status = Status {
        action: Action::Braking,
        clipped: bits != 0,
        state: *x,
        lap: LapNumber::new(values.real(slots.laps[0]) as u32),
        road_grip: controller.road_grip(),
        delay_change: values.real(slots.response[3]),
        ..Status::default()
    };
    Command { input: sent, status }
}
