//! Faults of the simulated car itself: its sensors before the bridge sees them, and its actuators
//! behind the bridge's limiter.
//!
//! The bench writes the faults of a run into a file when they begin; the car, inside `lmpc bridge
//! --bench-car FILE`, reads them at its next tick. It publishes its true state as well, by which the
//! run is judged.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::{Context as _, Result};
use lcm_types::VehicleState;
use serde::{Deserialize, Serialize};
use vehicle_model::{CarParams, Input, State, Track};

use super::fault::{Action, Fault, Field};
use super::field::FieldMemory;
use super::random::{self, Random};
use protocol::convert;
use protocol::publisher::{Identity, Publisher};
use transport::{Transport, now};
use vehicle_host::{Vehicle, VehicleError};

/// Channel of the true state, as a [`VehicleState`].
pub(super) const TRUTH: &str = "BENCH/TRUTH";

/// What the bench says when the faults begin.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct Order {
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
    let text = serde_json::to_string(&Order { start_ns, seed, faults })?;
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
}

/// A simulated car whose sensors and actuators can fail.
pub struct FaultyCar {
    vehicle: Box<dyn Vehicle>,
    file: PathBuf,
    start_ns: i64,
    active: Vec<Active>,
    truth: Publisher,
}

impl FaultyCar {
    /// Of a car, with the faults that will be in `file`; its truth goes to `network`.
    #[must_use]
    pub fn new(vehicle: Box<dyn Vehicle>, file: &Path, network: &Arc<dyn Transport>) -> Self {
        let truth = Publisher::new(network, &Identity::new("car"), TRUTH);
        Self { vehicle, file: file.to_owned(), start_ns: i64::MAX, active: Vec::new(), truth }
    }

    /// Reads the faults once they are there.
    fn look(&mut self) {
        let read = fs::read_to_string(&self.file).and_then(|text| {
            fs::remove_file(&self.file)?;
            serde_json::from_str::<Order>(&text).map_err(io::Error::other)
        });
        let Ok(Order { start_ns, seed, faults }) = read else { return };
        self.start_ns = start_ns;
        let active = |(i, fault): (u64, Fault)| Active {
            fault,
            memory: FieldMemory::default(),
            random: random::of(seed ^ (i << 32)),
            frozen: None,
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

    fn tell_truth(&mut self) {
        let (x, applied) = (self.vehicle.truth(), self.vehicle.applied());
        let h = self.truth.header();
        let (at, lap) = (h.sent(), i32::try_from(self.vehicle.lap()).unwrap_or(0));
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
            let Active { fault, memory, random, frozen } = active;
            if fault.action == (Action::Freeze {}) {
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
        for active in Self::acting(&mut self.active, self.start_ns, now_ns) {
            let Active { fault, memory, random, .. } = active;
            let place = match fault.action.field() {
                Some(Field::Accel) => &mut u.a,
                Some(Field::Steer) => &mut u.delta,
                _ => continue,
            };
            *place = fault.action.change(*place, now_ns, memory, random).unwrap_or(*place);
        }
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
