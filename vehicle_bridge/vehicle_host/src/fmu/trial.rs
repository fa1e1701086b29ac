//! Small steps of throttle and steering that show which senses and units a map got wrong, and how
//! the car's actuators answer. Pure: the car is whatever drives.
//!
//! The positions are the reference: x and y are taken for metres, x to y counter-clockwise. Their
//! course and speed are what velocity, yaw rate and heading are compared with.

use std::f64::consts::{PI, TAU};

pub use actuators::Response;

use vehicle_model::track::wrap_angle;
use vehicle_model::{CarParams, Input};

use super::signals::{
    Sample, course, derivative, median, period, response, speed_at_end, speed_read, speeds, stride,
    way,
};

/// A car to be tried.
pub trait TrialCar {
    /// Why it does not drive on.
    type Error;

    /// Drives for `dt` \[s\] and measures v_x, v_y, omega_z, x, y, psi, in our units by the map.
    ///
    /// # Errors
    /// Whatever ends the trial.
    fn drive(&mut self, u: Input, dt: f64) -> Result<[f64; 6], Self::Error>;
}

/// What is wrong with an entry of a map, or that nothing is.
#[derive(Debug, Clone, PartialEq)]
pub struct EntryFinding {
    /// `input` or `state`.
    pub section: &'static str,
    /// The quantity.
    pub quantity: &'static str,
    /// The mapped value times this is ours.
    pub factor: f64,
    /// And this is added. \[our unit\]
    pub offset: f64,
    /// What was measured, and what it means.
    pub note: String,
    /// Whether the trial can know it.
    pub sure: bool,
}

/// What a trial found.
#[derive(Debug, Clone, PartialEq)]
pub struct Trial {
    /// One for each quantity of the map.
    pub findings: Vec<EntryFinding>,
    /// Of the acceleration.
    pub throttle: Response,
    /// Of the yaw rate on a step of steering: the actuator's and the car's own.
    pub steering: Response,
    /// Time between two measurements that differ. \[s\]
    pub period: f64,
}

/// Why a trial found nothing.
#[derive(Debug, thiserror::Error)]
pub enum TrialError<E> {
    /// The car refused.
    #[error(transparent)]
    Car(E),
    /// It did not move, forwards or backwards.
    #[error(
        "the car moved {moved:.3} m in {seconds} s on a throttle of {asked:.2} m/s^2 and of its \
         opposite, expected at least {LEAST} m: is `a` the right variable, is a gear engaged?"
    )]
    Still {
        /// Way. \[m\]
        moved: f64,
        /// Time. \[s\]
        seconds: f64,
        /// Acceleration. \[m/s^2\]
        asked: f64,
    },
    /// It did not turn.
    #[error(
        "the course changed by {turned:.4} rad in {seconds} s on a steering angle of {asked:.3} rad, \
         expected at least {TURN} rad: is `delta` the right variable?"
    )]
    Straight {
        /// Change of course. \[rad\]
        turned: f64,
        /// Time. \[s\]
        seconds: f64,
        /// Steering angle. \[rad\]
        asked: f64,
    },
}

/// Least way that is a movement. \[m\]
const LEAST: f64 = 0.05;
/// Least change of course that is a turn. \[rad\]
const TURN: f64 = 0.01;
/// Durations of throttle, coasting and steering. \[s\]
const STAGES: [f64; 3] = [2.0, 0.5, 1.5];
/// Share of the greatest acceleration that is tried. \[-\]
const THROTTLE: f64 = 0.4;
/// Lateral acceleration of the turn, where tyres follow in proportion. \[m/s^2\]
const LATERAL: f64 = 1.5;
/// A ratio this near to that of a unit is taken for it; of an answer, which slip and drag change.
const NEAR: f64 = 0.04;
const NEAR_ANSWER: f64 = 0.35;
/// Ratios of units to ours.
const UNITS: [(f64, &str); 8] = [
    (1.0, ""),
    (1.0 / 3.6, "km/h"),
    (0.447_04, "mph"),
    (PI / 180.0, "degrees"),
    (9.806_65, "g"),
    (1e-3, "thousandths"),
    (1e-2, "hundredths"),
    (1e3, "thousands"),
];

/// Of units that a map names and the FMU does not have.
const WRONG_UNITS: [(f64, &str); 3] = [
    (3.6, "m/s, not km/h"),
    (1.0 / 0.447_04, "m/s, not mph"),
    (180.0 / PI, "radians, not degrees"),
];

/// Tries a car that `parameters` describe, with measurements every `dt` \[s\].
///
/// # Errors
/// If the car refuses, does not move or does not turn.
pub fn trial<C: TrialCar>(
    car: &mut C,
    parameters: &CarParams,
    dt: f64,
) -> Result<Trial, TrialError<C::Error>> {
    let mut driver = Driver { car, dt, time: 0.0 };
    let throttle = THROTTLE * parameters.a_max.min(-parameters.a_min);
    let rest = driver.run(Input::default(), STAGES[1])?;
    let mut sign = 1.0;
    let mut pushed = driver.run(Input { a: throttle, delta: 0.0 }, STAGES[0])?;
    let gained = |pushed: &[Sample]| speed_at_end(pushed) - speed_at_end(&rest);
    if gained(&pushed) <= 0.0 || way(&pushed) < LEAST {
        sign = -1.0;
        pushed = driver.run(Input { a: -throttle, delta: 0.0 }, STAGES[0])?;
        if way(&pushed) < LEAST {
            let (moved, seconds) = (way(&pushed), STAGES[0]);
            return Err(TrialError::Still { moved, seconds, asked: throttle });
        }
    }
    let before = if sign > 0.0 { speed_read(&rest) } else { f64::NAN };
    let coasting = driver.run(Input::default(), STAGES[1])?;
    let speed = speed_at_end(&coasting).max(0.1);
    let wheelbase = parameters.wheelbase();
    let delta = (LATERAL * wheelbase / (speed * speed)).atan().min(0.4 * parameters.delta_max);
    let turned = driver.run(Input { a: 0.0, delta }, STAGES[2])?;
    let turn =
        course(&turned).last().map_or(0.0, |c| c.1) - course(&coasting).last().map_or(0.0, |c| c.1);
    if wrap_angle(turn).abs() < TURN {
        let (turned, seconds) = (wrap_angle(turn), STAGES[2]);
        return Err(TrialError::Straight { turned, seconds, asked: delta });
    }
    let seen = Seen { before, pushed, coasting, turned, sign, throttle, delta, wheelbase };
    Ok(seen.conclude(dt))
}

struct Driver<'a, C> {
    car: &'a mut C,
    dt: f64,
    time: f64,
}

impl<C: TrialCar> Driver<'_, C> {
    fn run(&mut self, u: Input, seconds: f64) -> Result<Vec<Sample>, TrialError<C::Error>> {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "few steps")]
        let steps = (seconds / self.dt).round().max(4.0) as usize;
        let mut samples = Vec::with_capacity(steps);
        for _ in 0..steps {
            let q = self.car.drive(u, self.dt).map_err(TrialError::Car)?;
            self.time += self.dt;
            samples.push(Sample { time: self.time, q });
        }
        Ok(samples)
    }
}

/// Everything driven.
struct Seen {
    /// v_x as read before the throttle; not a number where it was another throttle.
    before: f64,
    pushed: Vec<Sample>,
    coasting: Vec<Sample>,
    turned: Vec<Sample>,
    sign: f64,
    throttle: f64,
    delta: f64,
    wheelbase: f64,
}

impl Seen {
    fn conclude(&self, dt: f64) -> Trial {
        let pace_over_time = speeds(&self.pushed);
        let half = |all: &[(f64, f64)]| all[all.len() / 2..].to_vec();
        let gains = derivative(&pace_over_time);
        let gain = self.sign * median(half(&gains).iter().map(|g| g.1)) / self.throttle;
        // By the positions, in the second half of the turn.
        let rates = derivative(&course(&self.turned));
        let rate = median(half(&rates).iter().map(|r| r.1));
        let late = &self.turned[self.turned.len() / 2..];
        let pace = median(speeds(&self.turned)[self.turned.len() / 4..].iter().map(|s| s.1));
        let answer = rate / (pace * self.delta.tan() / self.wheelbase);

        let v_x = median(self.coasting.iter().map(|s| s.q[0]));
        let true_v_x = median(speeds(&self.coasting).iter().map(|s| s.1));
        let omega = median(late.iter().map(|s| s.q[2]));
        let mut findings = vec![
            answered("input", "a", gain, "m/s^2 of the speed for each that was asked"),
            answered("input", "delta", answer, "of the bend that the wheelbase gives"),
            compared("v_x", true_v_x / v_x, "of the speed by x and y"),
            compared("omega_z", rate / omega, "of the turn by x and y"),
        ];
        let psi = self.heading();
        findings.extend([self.lateral(&psi, pace), psi]);
        let mirrored = |of: &str| findings.iter().any(|f| f.quantity == of && f.factor < 0.0);
        if ["delta", "omega_z", "psi"].into_iter().all(mirrored) {
            for finding in &mut findings {
                if ["delta", "omega_z", "psi"].contains(&finding.quantity) {
                    finding.note += "; or y is mirrored: x to y must turn to the left";
                    finding.sure = false;
                }
            }
        }
        let throttle = self.throttle_response(dt);
        let yaw: Vec<_> = self.turned.iter().map(|s| (s.time, s.q[2])).collect();
        Trial {
            findings,
            throttle,
            steering: response(&yaw, self.turned[0].time - dt),
            period: period(&self.turned, dt),
        }
    }

    /// Of a first-order lag T behind a delay d the speed gains A (t - d - T) in the end. That line
    /// meets the speed of before at d + T, where the speed has gained A T / e.
    fn throttle_response(&self, dt: f64) -> Response {
        let from = self.pushed[0].time - dt;
        let late = &self.pushed[self.pushed.len() / 2..];
        let (first, last) = (late[0], late[late.len() - 1]);
        let slope = (last.q[0] - first.q[0]) / (last.time - first.time);
        let both = last.time - from - (last.q[0] - self.before) / slope;
        let at = self.pushed.iter().find(|sample| sample.time - from >= both);
        let gained = at.map_or(0.0, |sample| sample.q[0] - self.before);
        // A measurement late by a part of a step is no lag.
        let lag = (std::f64::consts::E * gained / slope).clamp(0.0, both.max(0.0));
        let lag = if lag < 2.0 * dt { 0.0 } else { lag };
        Response { delay: (both - lag).max(0.0), lag }
    }

    /// Sense and zero of the heading: on the straight it is the course.
    fn heading(&self) -> EntryFinding {
        let straight = course(&self.coasting);
        let from = straight.last().map_or(0.0, |c| c.1);
        let to = course(&self.turned).last().map_or(0.0, |c| c.1);
        let psi = |samples: &[Sample]| samples.last().map_or(0.0, |s| s.q[5]);
        let (turned, read) = (wrap_angle(to - from), psi(&self.turned) - psi(&self.coasting));
        // A full turn in between is that of the wrapping.
        let read = if read.abs() > PI { read - TAU * read.signum() } else { read };
        let mut finding = compared("psi", turned / read, "of the change of course by x and y");
        let zero = wrap_angle(from - finding.factor * psi(&self.coasting));
        // Of a quarter turn, or nothing: a car on a straight points along its course.
        let quarters = (zero / (0.5 * PI)).round();
        finding.offset = if quarters == 0.0 { 0.0 } else { quarters * 0.5 * PI };
        if quarters != 0.0 {
            let degrees = 90.0 * quarters;
            finding.note = format!("{}; zero {degrees} degrees off", finding.note);
        }
        if (zero - finding.offset).abs() > 0.1 {
            finding.sure = false;
            finding.note =
                format!("{}; {:.2} rad from the course", finding.note, zero - finding.offset);
        }
        finding
    }

    /// Sense of the lateral velocity, from the angle between heading and course. Its size is small and
    /// is not judged.
    fn lateral(&self, psi: &EntryFinding, pace: f64) -> EntryFinding {
        let n = stride(&self.turned);
        let slips = course(&self.turned).into_iter().enumerate().filter_map(|(i, (_, towards))| {
            // Between the two positions whose course it is.
            let (a, b) = (self.turned.get(i + n / 2)?, self.turned.get(i + n.div_ceil(2))?);
            let heading = psi.factor * (a.q[5] + 0.5 * (b.q[5] - a.q[5])) + psi.offset;
            Some((pace * wrap_angle(towards - heading).sin(), 0.5 * (a.q[1] + b.q[1])))
        });
        let (mut together, mut drift, mut read, mut count) = (0.0, 0.0, 0.0, 0.0_f64);
        for (expected, found) in slips {
            together += expected * found;
            (drift, read, count) = (drift + expected * expected, read + found * found, count + 1.0);
        }
        let agreement = together / (drift * read).sqrt();
        if !(agreement.abs() > 0.8 && (drift / count).sqrt() > 2e-3 * pace) {
            return unknown("v_y");
        }
        let mut note = format!("agrees by {agreement:.2} with the drift by x, y and psi");
        if agreement < 0.0 {
            note += "; positive the other way";
        }
        let factor = agreement.signum();
        EntryFinding {
            section: "state",
            quantity: "v_y",
            factor,
            offset: 0.0,
            note,
            sure: psi.sure,
        }
    }
}

fn unknown(quantity: &'static str) -> EntryFinding {
    let note = "too small in this trial to tell its sense".to_owned();
    EntryFinding { section: "state", quantity, factor: 1.0, offset: 0.0, note, sure: false }
}

/// A measured quantity against the positions.
fn compared(quantity: &'static str, ratio: f64, of: &str) -> EntryFinding {
    snapped("state", quantity, ratio, NEAR, of, &[&UNITS[..], &WRONG_UNITS[..]].concat())
}

/// What an input does against what it should.
fn answered(section: &'static str, quantity: &'static str, ratio: f64, of: &str) -> EntryFinding {
    snapped(section, quantity, ratio, NEAR_ANSWER, of, &UNITS)
}

fn snapped(
    section: &'static str,
    quantity: &'static str,
    ratio: f64,
    near: f64,
    of: &str,
    units: &[(f64, &str)],
) -> EntryFinding {
    let distance = |unit: f64| (ratio.abs() / unit).ln().abs();
    let known = units.iter().min_by(|a, b| distance(a.0).total_cmp(&distance(b.0)));
    let found = known.filter(|(unit, _)| distance(*unit) < near && ratio.is_finite());
    let mut note = format!("{ratio:.3} {of}");
    if ratio < 0.0 {
        note += "; positive the other way";
    }
    let sense = if ratio < 0.0 { -1.0 } else { 1.0 };
    match found {
        Some((unit, name)) => {
            if !name.is_empty() {
                note = format!("{note}; in {name}");
            }
            EntryFinding { section, quantity, factor: sense * unit, offset: 0.0, note, sure: true }
        }
        None => {
            note += "; the ratio of no unit known here";
            EntryFinding { section, quantity, factor: sense, offset: 0.0, note, sure: false }
        }
    }
}

#[cfg(test)]
#[path = "trial_tests.rs"]
mod tests;
