//! Faults of the simulated car itself: its sensors before the bridge sees them, and its actuators
//! behind the bridge's limiter.
//!
//! The bench writes the faults of a run into a file when they begin; the car, inside `lmpc bridge
//! --bench-car FILE`, reads them at its next tick. It publishes its true state as well, by which the
//! run is judged.

use std::collections::VecDeque;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::{Context as _, Result};
use lcm_types::{LapIndex, VehicleState};
use serde::{Deserialize, Serialize};
use vehicle_model::{CarParams, Disturbance, GripChange, Input, State, Track};

use super::fault::{Fault, FaultKind, Field};
use super::field::FieldMemory;
use super::random::{self, Random};
use protocol::convert::{self, nanoseconds};
use protocol::publisher::{Identity, Publisher};
use transport::{Transport, now};
use vehicle_host::{Vehicle, VehicleError};

/// Channel of the true state, as a [`VehicleState`].
pub(super) const TRUTH: &str = "BENCH/TRUTH";

/// What the bench says when the faults begin.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct FaultSchedule {
    /// On this host's monotonic clock. \[ns\]
    start_ns: i64,
    seed: u64,
    faults: Vec<Fault>,
}

/// Writes the faults on the car, which begin at `start_ns`, where the car reads them.
///
/// # Errors
/// If the file cannot be written.
pub(super) fn begin(path: &Path, faults: &[Fault], start_ns: i64, seed: u64) -> Result<()> {
    let faults: Vec<Fault> = faults.iter().filter(|fault| fault.car).cloned().collect();
    if faults.is_empty() {
        return Ok(());
    }
    let text = serde_json::to_string(&FaultSchedule { start_ns, seed, faults })?;
    // In one piece: the car may look at any time.
    let part = path.with_extension("part");
    let written = fs::write(&part, text).and_then(|()| fs::rename(&part, path));
    written.with_context(|| format!("cannot write {}", path.display()))
}

/// Whether the car has seen its faults: it removes the file.
pub(super) fn acted(path: &Path) -> bool {
    !path.exists()
}

struct Active {
    fault: Fault,
    memory: FieldMemory,
    random: Random,
    frozen: Option<State>,
    late: Late,
}

/// Inputs on their way to late actuators.
#[derive(Default)]
struct Late {
    /// When each was commanded, oldest first. \[ns\]
    waiting: VecDeque<(i64, Input)>,
    acting: Option<Input>,
}

impl Late {
    /// The input that acts at `now_ns`, where `u` is commanded now and acts after `delay_ns`.
    fn input(&mut self, now_ns: i64, u: Input, delay_ns: i64) -> Input {
        let mut acting = self.acting.unwrap_or(u);
        self.waiting.push_back((now_ns, u));
        while let Some((_, u)) = self.waiting.front().filter(|w| w.0 + delay_ns <= now_ns) {
            acting = *u;
            self.waiting.pop_front();
        }
        *self.acting.insert(acting)
    }
}

/// A simulated car whose sensors and actuators can fail.
pub struct FaultyCar {
    vehicle: Box<dyn Vehicle>,
    file: PathBuf,
    start_ns: i64,
    active: Vec<Active>,
    /// What acts on the car without faults, and factors on its grip by faults.
    calm: Option<Disturbance>,
    grip: [f64; 2],
    truth: Publisher,
}

impl FaultyCar {
    /// Of a car, with the faults that will be in `file`; its truth goes to `network`.
    #[must_use]
    pub fn new(vehicle: Box<dyn Vehicle>, file: &Path, network: &Arc<dyn Transport>) -> Self {
        let truth = Publisher::new(network, &Identity::new("car"), TRUTH);
        let calm = vehicle.disturbance().cloned();
        let (file, start_ns, active, grip) = (file.to_owned(), i64::MAX, Vec::new(), [1.0; 2]);
        Self { vehicle, file, start_ns, active, calm, grip, truth }
    }

    /// Reads the faults once they are there.
    fn look(&mut self) {
        let read = fs::read_to_string(&self.file).and_then(|text| {
            fs::remove_file(&self.file)?;
            serde_json::from_str::<FaultSchedule>(&text).map_err(io::Error::other)
        });
        let Ok(FaultSchedule { start_ns, seed, faults }) = read else { return };
        self.start_ns = start_ns;
        let active = |(i, fault): (u64, Fault)| Active {
            fault,
            memory: FieldMemory::default(),
            random: random::of(seed ^ (i << 32)),
            frozen: None,
            late: Late::default(),
        };
        self.active = (0..).zip(faults).map(active).collect();
    }

    /// The faults that act now.
    fn acting(
        active: &mut [Active],
        start_ns: i64,
        now_ns: i64,
    ) -> impl Iterator<Item = &mut Active> {
        active.iter_mut().filter(move |active| {
            let (from, until) = active.fault.window_ns();
            (from..until).contains(&now_ns.saturating_sub(start_ns))
        })
    }

    /// Gives the road this grip, if it has another one.
    fn hold(&mut self, factor: [f64; 2]) -> Result<(), VehicleError> {
        if factor == self.grip {
            return Ok(());
        }
        self.grip = factor;
        let mut disturbance = self.calm.clone().unwrap_or_default();
        disturbance.grip.push(GripChange { factor, time_s: None, s_m: None });
        self.vehicle.disturb(disturbance)
    }

    fn tell_truth(&mut self) {
        let (x, applied) = (self.vehicle.truth(), self.vehicle.applied());
        let h = self.truth.header();
        let (at, lap) = (h.sent(), LapIndex::after(self.vehicle.lap()));
        let message: VehicleState =
            convert::state_message(h, at, &x, applied, self.vehicle.track(), lap);
        // For the verdict alone.
        let _ = self.truth.send_sealed(&message);
    }
}

/// Changes a field of a state, by its pose in the world where the field is one of that.
fn of_state(x: &mut State, track: &Track, field: Field, change: impl FnOnce(f64) -> f64) {
    let place = match field {
        Field::Vx => &mut x.v_x,
        Field::Vy => &mut x.v_y,
        Field::YawRate => &mut x.omega_z,
        Field::EY => &mut x.e_y,
        Field::EPsi => &mut x.e_psi,
        Field::S => {
            x.s = track.wrap(change(x.s));
            return;
        }
        Field::X | Field::Y | Field::Yaw => {
            let mut pose = track.to_global(x);
            let place = match field {
                Field::X => &mut pose.x,
                Field::Y => &mut pose.y,
                _ => &mut pose.psi,
            };
            *place = change(*place);
            *x = track.to_frenet(&pose, Some(x.s));
            return;
        }
        Field::Accel | Field::Steer => return,
    };
    *place = change(*place);
}

impl Vehicle for FaultyCar {
    fn measure(&mut self) -> State {
        if self.active.is_empty() {
            self.look();
        }
        self.tell_truth();
        let mut x = self.vehicle.measure();
        let (now_ns, track) = (now().mono.as_ns(), Arc::clone(self.vehicle.track()));
        for active in Self::acting(&mut self.active, self.start_ns, now_ns) {
            let Active { fault, memory, random, frozen, .. } = active;
            if fault.action == (FaultKind::Freeze {}) {
                x = *frozen.get_or_insert(x);
            }
            if let Some(field) = fault.action.field() {
                of_state(&mut x, &track, field, |old| {
                    fault.action.change(old, now_ns, memory, random).unwrap_or(old)
                });
            }
        }
        x
    }

    fn truth(&self) -> State {
        self.vehicle.truth()
    }

    fn apply(&mut self, mut u: Input, dt: f64) -> Result<(), VehicleError> {
        let now_ns = now().mono.as_ns();
        let mut grip = [1.0; 2];
        for active in Self::acting(&mut self.active, self.start_ns, now_ns) {
            let Active { fault, memory, random, late, .. } = active;
            match fault.action {
                FaultKind::Delay { ms, .. } => u = late.input(now_ns, u, nanoseconds(1e-3 * ms)),
                FaultKind::Grip { front, rear } => grip = [grip[0] * front, grip[1] * rear],
                _ => {}
            }
            let place = match fault.action.field() {
                Some(Field::Accel) => &mut u.a,
                Some(Field::Steer) => &mut u.delta,
                _ => continue,
            };
            *place = fault.action.change(*place, now_ns, memory, random).unwrap_or(*place);
        }
        self.hold(grip)?;
        self.vehicle.apply(u, dt)
    }

    fn applied(&self) -> Input {
        self.vehicle.applied()
    }

    fn progress(&self) -> f64 {
        self.vehicle.progress()
    }

    fn lap(&self) -> i64 {
        self.vehicle.lap()
    }

    fn track(&self) -> &Arc<Track> {
        self.vehicle.track()
    }

    fn car(&self) -> &CarParams {
        self.vehicle.car()
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "code of tests")]
    use super::*;

    #[test]
    fn late_actuators_do_what_was_commanded_before() {
        let mut late = Late::default();
        let mut at = |tick: i64| late.input(tick * 10, Input { a: tick as f64, delta: 0.0 }, 30).a;
        let acting: Vec<f64> = (0..8).map(&mut at).collect();
        assert_eq!(acting, [0.0, 0.0, 0.0, 0.0, 1.0, 2.0, 3.0, 4.0]);
        // After a pause all that is due is passed over but the newest.
        assert_eq!(at(100), 7.0);
    }
}
