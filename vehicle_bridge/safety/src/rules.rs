//! What a bridge is set up with; does not change while it runs.

use std::sync::Arc;

use super::doubt::DoubtLimits;
use super::doubt::response::GRIPS;
use lcm_types::{BootId, VehicleState, crc};
use vehicle_model::{CarParams, Limiter, Model, ModelKind, Track, Tracker};

/// What a controller, or a bridge, was set up with. A value of 0 is not compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Setup {
    /// CRC-32 of the track. \[-\]
    pub track_id: i64,
    /// CRC-32 of the car's parameters. \[-\]
    pub car_id: i64,
    /// CRC-32 of the controller's configuration. \[-\]
    pub config_id: i64,
    /// Control period. \[ns\]
    pub period_ns: i64,
}

/// Limits and times of a bridge.
#[derive(Debug, Clone)]
pub struct Rules {
    /// The controller's period: the next command is due this long after the last. \[ns\]
    pub period_ns: i64,
    /// Time between two ticks. \[ns\]
    pub tick_ns: i64,
    /// Time between two states. \[ns\]
    pub state_ns: i64,
    /// Least quality of the states that the car may be armed by.
    pub quality: i8,
    /// How much later than due a command or a state may come. \[ns\]
    pub timeout_ns: i64,
    /// Oldest command believed on arrival. \[ns\]
    pub max_age_ns: i64,
    /// How long states must have been good before arming. \[ns\]
    pub ready_ns: i64,
    /// Oldest heartbeat of the controller that counts for arming. \[ns\]
    pub pulse_ns: i64,
    /// After START the car stands this long at most without a first command. \[ns\]
    pub start_ns: i64,
    /// Below this speed the car stands. \[m/s\]
    pub still: f64,
    /// This start of the bridge, as in its states' headers.
    pub boot_id: BootId,
    /// What the controller must be set up with to be armed.
    pub setup: Setup,
    /// Box, rates and speed cap of what is sent.
    pub limiter: Limiter,
    pub(super) track: Arc<Track>,
    pub(super) tracker: Tracker,
    /// When states and actuators are doubted; `None`: never.
    pub doubt: Option<DoubtLimits>,
    /// The car where it is slow, and with each share of its grip.
    pub(super) rolling: Model,
    pub(super) sliding: [Model; GRIPS.len()],
}

impl Rules {
    /// Shortest timeout that one late tick does not trip. \[ms\]
    pub const LEAST_TIMEOUT_MS: u32 = 20;

    /// How long what comes every `every_ns` may be silent: one timeout beyond the time when it is due.
    /// A timeout as long as that time bridges one message that is lost, with half of it left for the
    /// next one to be late. \[ns\]
    pub(super) fn patience_ns(&self, every_ns: i64) -> i64 {
        let one_lost = if self.timeout_ns >= every_ns { every_ns } else { 0 };
        (every_ns + self.timeout_ns).max(every_ns + one_lost + self.timeout_ns / 2)
    }

    /// For a car on a track, with the usual times: 100 Hz, 100 ms timeout.
    #[must_use]
    pub fn new(car: &CarParams, track: &Arc<Track>, period_ns: i64) -> Self {
        const MS: i64 = 1_000_000;
        Self {
            period_ns,
            tick_ns: 10 * MS,
            state_ns: 10 * MS,
            quality: VehicleState::GOOD,
            timeout_ns: 100 * MS,
            max_age_ns: 100 * MS,
            ready_ns: 1000 * MS,
            pulse_ns: 500 * MS,
            start_ns: 1000 * MS,
            still: 0.1,
            boot_id: BootId::NONE,
            setup: Setup {
                track_id: crc::id(track.fingerprint()),
                car_id: crc::id(car.fingerprint()),
                config_id: 0,
                period_ns,
            },
            limiter: Limiter::new(car),
            track: Arc::clone(track),
            tracker: Tracker::new(car),
            doubt: Some(DoubtLimits::new(car, track)),
            rolling: Model::new(ModelKind::Kinematic, car.clone()),
            sliding: GRIPS.map(|grip| Model {
                grip: [grip; 2],
                ..Model::new(ModelKind::Dynamic, car.clone())
            }),
        }
    }
}
