//! Back to the line after a spin, an excursion, a standstill or a start askew.
//!
//! The car slides to rest behind wheels that roll along their own motion, turns round with full
//! steering if it points away from the track, drives slowly to a point of the centre line ahead
//! (pure pursuit) and follows the line until it is fit to race. It cannot reverse. The lap in
//! which this happens teaches nothing.

use std::f64::consts::FRAC_PI_2;

use serde::{Deserialize, Serialize};
use vehicle_model::track::wrap_angle;
use vehicle_model::{CarParams, Input, State, Track, Tracker};

use crate::controller::Controller;
use crate::status::{Action, Reason, Status};

/// Angle between motion and heading beyond which the car has spun \[rad\].
const SPUN: f64 = 1.0;
/// The same beyond which it is left to slide to rest \[rad\].
const SLIDING: f64 = 0.5;
/// Heading error with which driving does not begin \[rad\].
const ASKEW: f64 = 0.6;
/// Heading error of a car that is fit to race \[rad\].
const STRAIGHT: f64 = 0.3;
/// Share of the way to the edge inside which a car is fit to race.
const INSIDE: f64 = 0.6;
/// Time for which the car must have been fit \[s\].
const FIT_TIME: f64 = 0.5;
/// Bearing of the line beyond which the car turns round \[rad\].
const BEHIND: f64 = 2.0;
/// Bearing of the line at which a turn ends \[rad\].
const TURNED: f64 = 1.0;
/// Share of the speed of the initial laps with which the car drives back.
const SLOW: f64 = 0.5;
/// Share of the grip that steering may use.
const STEER_SHARE: f64 = 0.5;
/// Distance of the point aimed at, in wheelbases.
const REACH_WHEELBASES: f64 = 3.0;
/// The same in seconds of travel.
const REACH_TIME: f64 = 0.8;
/// The same as a share of the distance from the line.
const REACH_SHARE: f64 = 0.7;

/// A recovery in progress.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(crate) struct Recovery {
    /// What began it.
    reason: Reason,
    /// Steps in a row in which the car was fit.
    fit: u32,
    /// Direction of the turn in progress: 1 left, -1 right, 0 none.
    turn: f64,
}

impl Recovery {
    pub(crate) fn new(reason: Reason) -> Self {
        Self { reason, fit: 0, turn: 0.0 }
    }
}

impl Controller {
    /// The input of a recovery, begun if the state asks for one; none if the car can be driven as
    /// usual.
    pub(crate) fn recovered(&mut self, x: &State, status: &mut Status) -> Option<Input> {
        if self.memory.recovery.is_none() {
            let Some(reason) = self.incident(x) else {
                self.memory.underway |= x.v_x >= self.standing();
                return None;
            };
            self.begin_recovery(reason);
        }
        let (standing, speed) = (self.standing(), self.tracking_speed());
        let recovery = self.memory.recovery.as_mut()?;
        let guide = Guide {
            car: &self.setup.car,
            track: &self.setup.track,
            tracker: &self.setup.tracker,
            speed,
            standing,
        };
        recovery.fit = if guide.fit(x) { recovery.fit + 1 } else { 0 };
        if f64::from(recovery.fit) * self.setup.config.horizon.period > FIT_TIME {
            self.memory.recovery = None;
            return None;
        }
        status.action = Action::Recovering;
        status.reason = recovery.reason;
        let input = guide.drive(x, recovery);
        self.memory.dataset.spoil();
        Some(input)
    }

    /// A recovery begins: the plan and the lap in progress are worth nothing any more.
    pub(crate) fn begin_recovery(&mut self, reason: Reason) {
        self.memory.recovery = Some(Recovery::new(reason));
        self.memory.dataset.spoil();
        self.memory.drop_plan();
    }

    /// What happened to the car, if anything did.
    fn incident(&self, x: &State) -> Option<Reason> {
        let course = libm::atan2(x.v_y, x.v_x);
        let moving = libm::hypot(x.v_x, x.v_y) > self.standing();
        if moving && course.abs() > SPUN {
            return Some(Reason::Spin);
        }
        let reason = self.unfit(x);
        if reason == Some(Reason::Standstill) && !(self.memory.learning && self.memory.underway) {
            // A car that has not yet driven is no accident.
            let askew = x.e_psi.abs() > ASKEW;
            return askew.then_some(Reason::Askew);
        }
        // A plan knows what it turns for.
        let planned = self.memory.plan.x.first().map_or(0.0, |planned| planned.e_psi);
        let askew = x.e_psi.abs() > ASKEW && (x.e_psi - planned).abs() > ASKEW;
        reason.or(askew.then_some(Reason::Askew))
    }
}

/// The way back to the line.
struct Guide<'a> {
    car: &'a CarParams,
    track: &'a Track,
    tracker: &'a Tracker,
    /// Speed of the initial laps \[m/s\].
    speed: f64,
    /// Speed below which a car stands \[m/s\].
    standing: f64,
}

impl Guide<'_> {
    /// Whether the car may race on.
    fn fit(&self, x: &State) -> bool {
        let moving = x.v_x > self.standing;
        moving
            && x.e_psi.abs() < STRAIGHT
            && libm::atan2(x.v_y, x.v_x).abs() < STRAIGHT
            && self.inside(x, INSIDE)
    }

    /// Whether the car is within this share of the way to the edge.
    fn inside(&self, x: &State, share: f64) -> bool {
        x.e_y < share * self.track.width_left(x.s) && -x.e_y < share * self.track.width_right(x.s)
    }

    fn drive(&self, x: &State, recovery: &mut Recovery) -> Input {
        let stop = self.car.delta_max;
        let moving = libm::hypot(x.v_x, x.v_y) > self.standing;
        if moving && libm::atan2(x.v_y, x.v_x).abs() > SLIDING {
            let wheel = libm::atan2(x.v_y + self.car.l_f * x.omega_z, x.v_x.max(0.0));
            let a = self.tracker.speed_loop(x, 0.0).max(-self.tracker.brakes(x));
            return Input { a, delta: wheel.clamp(-stop, stop) };
        }
        let bearing = self.bearing(x);
        if bearing.abs() < TURNED {
            recovery.turn = 0.0;
        } else if recovery.turn == 0.0 && bearing.abs() > BEHIND {
            recovery.turn = self.turn(x, bearing);
        }
        if x.e_psi.abs() < ASKEW && bearing.abs() < TURNED && self.inside(x, INSIDE) {
            return self.tracker.track(x, self.track, self.speed);
        }
        let full = libm::tan(stop) / self.car.wheelbase();
        let wanted = if recovery.turn != 0.0 {
            recovery.turn * full
        } else {
            2.0 * libm::sin(bearing.clamp(-FRAC_PI_2, FRAC_PI_2)) / self.reach(x)
        };
        let most = self.tracker.bend_curvature(STEER_SHARE, x.v_x).min(full);
        let kappa = wanted.clamp(-most, most);
        let slow = (SLOW * self.speed).min(self.tracker.turning_speed(wanted.abs().min(full)));
        let a = self.tracker.speed_loop(x, slow).max(-self.tracker.brakes(x));
        Input { a, delta: libm::atan(self.car.wheelbase() * kappa) }
    }

    /// Distance of the point aimed at \[m\].
    fn reach(&self, x: &State) -> f64 {
        let near = REACH_WHEELBASES * self.car.wheelbase();
        near.max(REACH_TIME * x.v_x).max(REACH_SHARE * x.e_y.abs())
    }

    /// Direction of the point aimed at, from the car's heading \[rad\].
    fn bearing(&self, x: &State) -> f64 {
        let here = self.track.to_global(x);
        let (aim_x, aim_y) = self.track.position(self.track.wrap(x.s + self.reach(x)));
        wrap_angle(libm::atan2(aim_y - here.y, aim_x - here.x) - here.psi)
    }

    /// Direction of a full turn: the one that stays farther inside the track, about straight here.
    /// On a circle of radius R, `e_y(psi) = e_y + d R (cos e_psi - cos psi)`, d the direction.
    fn turn(&self, x: &State, bearing: f64) -> f64 {
        let radius = self.car.wheelbase() / libm::tan(self.car.delta_max);
        let (left, right) = (self.track.width_left(x.s), self.track.width_right(x.s));
        let beyond = |direction: f64| {
            // The extremes: where the car points straight back, if it passes that, and the end.
            let passes = direction * x.e_psi > 0.0;
            let back = if passes { -1.0 } else { libm::cos(x.e_psi) };
            let at = |cos: f64| x.e_y + direction * radius * (libm::cos(x.e_psi) - cos);
            [at(back), at(1.0)].iter().map(|e_y| (e_y - left).max(-right - e_y)).fold(0.0, f64::max)
        };
        let (left, right) = (beyond(1.0), beyond(-1.0));
        if left == right { 1.0_f64.copysign(bearing) } else { (right - left).signum() }
    }
}
