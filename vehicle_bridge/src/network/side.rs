//! The car's side of the bridge: a simulated vehicle, or a real car by its map.

use std::sync::Arc;

use anyhow::Result;
use controller::Pose;
use lcm_types::{Header, VehicleState};
use vehicle_model::{Input, State, Track};

use super::convert;
use crate::mapping::{self, Drive, Mapping};
use crate::safety::{Output, Source};
use crate::transport::{self, Received, Transport};
use crate::vehicle::{Vehicle, VehicleError};

/// At the end the car is told to stop this often: one may be lost. \[-\]
const LAST_WORDS: u32 = 3;

/// What the bridge holds.
pub enum CarSide {
    /// Moves from tick to tick of the bridge.
    Simulated(Box<dyn Vehicle>),
    /// Moves by itself, and says where it is.
    Mapped(Box<MappedSide>),
}

/// A real car that speaks its own messages on the bridge's network.
pub struct MappedSide {
    mapping: Mapping,
    network: Arc<dyn Transport>,
    track: Arc<Track>,
    /// Where it was last: where to look for it next. \[m\]
    hint: Option<f64>,
    measured_ns: Option<i64>,
    bytes: Vec<u8>,
}

/// A state the car said.
pub struct Told {
    /// In the track's frame.
    pub x: State,
    /// Measured later than the one before: a sensor that froze says nothing new.
    pub is_new: bool,
    /// Its message, still without a header.
    pub message: VehicleState,
}

impl CarSide {
    /// A car by its map.
    #[must_use]
    pub fn mapped(mapping: Mapping, track: &Arc<Track>, network: &Arc<dyn Transport>) -> Self {
        let (network, track, bytes) = (Arc::clone(network), Arc::clone(track), Vec::new());
        let (hint, measured_ns) = (None, None);
        Self::Mapped(Box::new(MappedSide { mapping, network, track, hint, measured_ns, bytes }))
    }

    /// Channels the car's own messages come on.
    #[must_use]
    pub fn channels(&self) -> Vec<String> {
        match self {
            Self::Simulated(_) => Vec::new(),
            Self::Mapped(car) => car.mapping.state_channels(),
        }
    }

    /// Lets a simulated car drive with `held` for `dt` \[s\].
    ///
    /// # Errors
    /// [`VehicleError`] if what computes it fails.
    pub fn drive(&mut self, held: Input, dt: f64) -> Result<(), VehicleError> {
        match self {
            Self::Simulated(vehicle) => vehicle.apply(held, dt),
            Self::Mapped(_) => Ok(()),
        }
    }

    /// A simulated car's state now; a real one says it when it wants, see [`CarSide::hear`].
    pub fn measure(&mut self) -> Option<State> {
        match self {
            Self::Simulated(vehicle) => Some(vehicle.measure()),
            Self::Mapped(_) => None,
        }
    }

    /// The message of a simulated car's state, measured at `meas_ns` \[ns\].
    #[must_use]
    pub fn message(&self, h: Header, meas_ns: i64, x: &State, sent: Input) -> Option<VehicleState> {
        let Self::Simulated(vehicle) = self else { return None };
        let lap = i32::try_from(vehicle.lap()).unwrap_or(0);
        Some(convert::state_message(h, meas_ns, x, sent, vehicle.track(), lap))
    }

    /// A message of the car, on one of its channels; the state it completes.
    pub fn hear(&mut self, received: &Received) -> Option<Told> {
        let Self::Mapped(car) = self else { return None };
        let message = car.mapping.take(&received.channel, &received.payload, received.arrival)?;
        // A map knows the pose alone.
        let Pose::Global(pose) = convert::pose(&message, 0)? else { return None };
        if !convert::is_finite(&Pose::Global(pose)) {
            return None;
        }
        let x = car.track.to_frenet(&pose, car.hint);
        let is_new = car.measured_ns.is_none_or(|last| message.meas_mono_ns > last);
        (car.hint, car.measured_ns) = (Some(x.s), Some(message.meas_mono_ns));
        Some(Told { x, is_new, message })
    }

    /// Tells a real car what to do; a simulated one is told by [`CarSide::drive`].
    ///
    /// # Errors
    /// If the command cannot be encoded or sent.
    pub fn actuate(&mut self, output: &Output) -> Result<()> {
        match self {
            Self::Simulated(_) => Ok(()),
            // Held by the map's own `stop` values, braked along the track by ours.
            Self::Mapped(car) => {
                car.tell((output.source != Source::None).then_some(output.applied.sent))
            }
        }
    }

    /// The last words: a real car is told to stop.
    ///
    /// # Errors
    /// As [`CarSide::actuate`].
    pub fn finish(&mut self) -> Result<()> {
        let Self::Mapped(car) = self else { return Ok(()) };
        (0..LAST_WORDS).try_for_each(|_| car.tell(None))
    }

    /// What became of a real car's messages.
    #[must_use]
    pub fn counts(&self) -> Option<mapping::Counts> {
        let Self::Mapped(car) = self else { return None };
        Some(car.mapping.counts())
    }
}

impl MappedSide {
    fn tell(&mut self, input: Option<Input>) -> Result<()> {
        let drive = Drive { input, answers_ns: self.measured_ns, utime: transport::now().utime };
        self.mapping.command(&drive, &mut self.bytes)?;
        Ok(self.network.publish(self.mapping.command_channel(), &self.bytes)?)
    }
}
