//! What is known of a network at one time.

use serde::Serialize;

use super::Estimates;

/// Everything. Ages are from arrival to now, on this host's clock.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Snapshot {
    /// The track, as the controller says it.
    pub track: Option<TrackSeen>,
    /// The car.
    pub car: Option<CarSeen>,
    /// Programs by their heartbeats, in the order of their names.
    pub programs: Vec<ProgramSeen>,
    /// The last order of an operator.
    pub order: Option<OrderSeen>,
    /// The controller's last step.
    pub step: Option<StepSeen>,
    /// Why the bridge stopped the car last.
    pub last_stop: Option<String>,
    /// Channels in the order of their names.
    pub channels: Vec<ChannelSeen>,
}

/// The track.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct TrackSeen {
    /// Its name.
    pub name: String,
    /// Length of a lap. \[m\]
    pub length_m: f64,
    /// Curvature at equal steps along the lap, left positive. \[1/m\]
    #[serde(skip)]
    pub kappa: Vec<f32>,
}

/// The car.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct CarSeen {
    /// `program@host` that measures it.
    pub sender: String,
    /// Of its last state. \[s\]
    pub age_s: f64,
    /// 2 good, 1 degraded, 0 bad.
    pub quality: i8,
    /// Along the track, if it is known. \[m\]
    pub s_m: Option<f64>,
    /// From the centre line, left positive, if it is known. \[m\]
    pub e_y_m: Option<f64>,
    /// Free width to the left and right of the centre line there. \[m\]
    pub width_m: Option<(f64, f64)>,
    /// Lap. \[-\]
    pub lap: i32,
    /// Longitudinal velocity. \[m/s\]
    pub v_x_mps: f64,
    /// Acceleration applied. \[m/s^2\]
    pub accel_mps2: f64,
    /// Steering angle applied, left positive. \[rad\]
    pub steer_rad: f64,
    /// Who drives: `nobody`, `command`, `plan` or `stop`.
    pub driven_by: String,
    /// Limits that moved the input, as in `CAR/ACT`. \[bits\]
    pub limited: i32,
}

/// A program.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct ProgramSeen {
    /// As in `HB/<name>`.
    pub name: String,
    /// `program@host`.
    pub sender: String,
    /// State, as people read it.
    pub state: String,
    /// Of its last heartbeat. \[s\]
    pub age_s: f64,
    /// Whether that is recent.
    pub alive: bool,
    /// Since its start. \[s\]
    pub uptime_s: f64,
    /// Resident memory. \[MB\]
    pub rss_mb: f32,
    /// Whether a grant is in force.
    pub granted: bool,
    /// Messages it believed. \[-\]
    pub ok: i64,
    /// Messages it refused as damaged or impossible. \[-\]
    pub bad: i64,
    /// Messages it refused as repeated, out of order, or not granted. \[-\]
    pub old: i64,
    /// Messages it refused by age. \[-\]
    pub stale: i64,
    /// Messages it misses by their numbers. \[-\]
    pub lost: i64,
    /// Its version.
    pub version: String,
    /// What a person should know.
    pub detail: String,
}

/// An operator's order.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct OrderSeen {
    /// As `lmpc operator` has it.
    pub order: String,
    /// Who ordered.
    pub sender: String,
    /// \[s\]
    pub age_s: f64,
    /// The dead man's switch is held.
    pub deadman: bool,
    /// Who answered what.
    pub answers: Vec<OrderAnswer>,
    /// Not to be sent along: which order it is. \[-\]
    #[serde(skip)]
    pub request_id: i64,
}

/// An answer to an order.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct OrderAnswer {
    /// `bridge` or `lmpc`.
    pub who: String,
    /// Whether it obeys.
    pub accepted: bool,
    /// Why not.
    pub detail: String,
}

/// A step of the controller.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct StepSeen {
    /// How the solver ended.
    pub status: String,
    /// From the arrival of the state to the command. \[ms\]
    pub total_ms: f64,
    /// The longest seen. \[ms\]
    pub worst_ms: f64,
    /// Linearise, regress, fill. \[ms\]
    pub build_ms: f64,
    /// The solver. \[ms\]
    pub solve_ms: f64,
    /// What a step may take. \[ms\]
    pub deadline_ms: f64,
    /// Steps that took longer since the controller's start. \[-\]
    pub overruns: i32,
    /// Lap the controller is on. \[-\]
    pub lap: i32,
    /// What it does and what it has found out.
    pub estimates: Estimates,
}

/// A channel.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct ChannelSeen {
    /// Its name.
    pub name: String,
    /// In the last seconds. \[Hz\]
    pub rate_hz: f64,
    /// Of its last message. \[s\]
    pub age_s: f64,
    /// Size of its last message. \[B\]
    pub bytes: usize,
    /// Messages heard. \[-\]
    pub count: u64,
    /// Messages missing by their numbers; only of our types. \[-\]
    pub lost: u64,
    /// Starts of programs that sent on it; two at a time are one too many, but for operators. \[-\]
    pub senders: usize,
    /// Messages that are not of the channel's type. \[-\]
    pub unreadable: u64,
}
