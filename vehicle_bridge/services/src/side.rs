//! The car's side of the bridge: a simulated vehicle, or a real car by its map.

use std::sync::Arc;
use std::time::Duration;

use anyhow::Result;
use controller::Pose;
use lcm_types::{Header, LapIndex, MonoTime, VehicleState};
use vehicle_model::{Input, State, Track};

use super::car_clock::{CarClock, ClockFinding};
use mapping::{CarRequest, Mapping};
use protocol::convert;
use safety::{InputSource, Output};
use transport::{Received, Transport};
use vehicle_host::{Vehicle, VehicleError};

/// At the end the stop is sent this often: one may be lost. \[-\]
const LAST_WORDS: u32 = 3;
/// More ticks than these are not made up for: each step takes time itself. \[-\]
const MOST_STEPS: u32 = 10;

/// What the bridge holds.
pub enum CarSide {
    /// Moves by whatever time has passed.
    Simulated(Box<dyn Vehicle>),
    /// Moves by whole ticks alone.
    Stepped(SteppedSide),
    /// Moves by itself and reports its state.
    Mapped(Box<MappedSide>),
}

/// A simulated vehicle that may refuse a part of a step, as a fixed-step FMU does.
pub struct SteppedSide {
    vehicle: Box<dyn Vehicle>,
    tick: Duration,
    /// Time that has passed and is not driven yet.
    owed: Duration,
    /// Whether it moved in the last drive: only then is there something new to measure.
    moved: bool,
}

/// A real car that speaks its own messages on the bridge's network.
pub struct MappedSide {
    mapping: Mapping,
    network: Arc<dyn Transport>,
    track: Arc<Track>,
    /// Where it was last: where to look for it next. \[m\]
    hint: Option<f64>,
    measured_ns: Option<i64>,
    clock: CarClock,
    bytes: Vec<u8>,
}

/// A state reported by the car.
pub struct Told {
    /// In the track's frame.
    pub x: State,
    /// Measured later than the one before: a frozen sensor repeats its measurement.
    pub is_new: bool,
    /// Its message, still without a header.
    pub message: VehicleState,
}

impl CarSide {
    /// A vehicle that is stepped by whole ticks.
    #[must_use]
    pub fn stepped(vehicle: Box<dyn Vehicle>, tick: Duration) -> Self {
        Self::Stepped(SteppedSide { vehicle, tick, owed: Duration::ZERO, moved: false })
    }

    /// A car by its map.
    #[must_use]
    pub fn mapped(mapping: Mapping, track: &Arc<Track>, network: &Arc<dyn Transport>) -> Self {
        let (network, track, bytes) = (Arc::clone(network), Arc::clone(track), Vec::new());
        let (hint, measured_ns, clock) = (None, None, CarClock::default());
        let car = MappedSide { mapping, network, track, hint, measured_ns, clock, bytes };
        Self::Mapped(Box::new(car))
    }

    /// Channels the car's own messages come on.
    #[must_use]
    pub fn channels(&self) -> Vec<String> {
        match self {
            Self::Simulated(_) | Self::Stepped(_) => Vec::new(),
            Self::Mapped(car) => car.mapping.state_channels(),
        }
    }

    /// Lets a simulated car drive with `held` for `dt`. One that is stepped by whole ticks waits
    /// until a tick is full, and then takes all of it with this input.
    ///
    /// # Errors
    /// [`VehicleError`] if what computes it fails.
    pub fn drive(&mut self, held: Input, dt: Duration) -> Result<(), VehicleError> {
        match self {
            Self::Simulated(vehicle) => vehicle.apply(held, dt.as_secs_f64()),
            Self::Stepped(car) => car.drive(held, dt),
            Self::Mapped(_) => Ok(()),
        }
    }

    /// A simulated car's state now, if it is new; a real one says it when it wants, see [`CarSide::hear`].
    pub fn measure(&mut self) -> Option<State> {
        match self {
            Self::Simulated(vehicle) => Some(vehicle.measure()),
            Self::Stepped(car) => car.moved.then(|| car.vehicle.measure()),
            Self::Mapped(_) => None,
        }
    }

    /// The message of a simulated car's state, measured at `measured`.
    #[must_use]
    pub fn message(
        &self,
        h: Header,
        measured: MonoTime,
        x: &State,
        sent: Input,
    ) -> Option<VehicleState> {
        let vehicle = match self {
            Self::Simulated(vehicle) | Self::Stepped(SteppedSide { vehicle, .. }) => vehicle,
            Self::Mapped(_) => return None,
        };
        let lap = LapIndex::after(vehicle.lap());
        Some(convert::state_message(h, measured, x, sent, vehicle.track(), lap))
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
        let meas_mono_ns = car.clock.time(message.meas_mono_ns, received.arrival.mono.as_ns());
        Some(Told { x, is_new, message: VehicleState { meas_mono_ns, ..message } })
    }

    /// Sends the input to a real car; a simulated one gets it by [`CarSide::drive`].
    ///
    /// # Errors
    /// If the command cannot be encoded or sent.
    pub fn actuate(&mut self, output: &Output) -> Result<()> {
        match self {
            Self::Simulated(_) | Self::Stepped(_) => Ok(()),
            // Held by the map's own `stop` values, braked along the track by ours.
            Self::Mapped(car) => {
                car.tell((output.source != InputSource::None).then_some(output.applied.sent))
            }
        }
    }

    /// Ends: sends a real car the stop.
    ///
    /// # Errors
    /// As [`CarSide::actuate`].
    pub fn finish(&mut self) -> Result<()> {
        let Self::Mapped(car) = self else { return Ok(()) };
        (0..LAST_WORDS).try_for_each(|_| car.tell(None))
    }

    /// What became of a real car's messages.
    #[must_use]
    pub fn counts(&self) -> Option<mapping::CarMessageCounts> {
        let Self::Mapped(car) = self else { return None };
        Some(car.mapping.counts())
    }

    /// What is wrong with a real car's clock, if anything is.
    #[must_use]
    pub fn clock(&self) -> Option<ClockFinding> {
        let Self::Mapped(car) = self else { return None };
        car.clock.finding()
    }
}

impl SteppedSide {
    fn drive(&mut self, held: Input, dt: Duration) -> Result<(), VehicleError> {
        self.owed = (self.owed + dt).min(self.tick * MOST_STEPS);
        self.moved = self.owed >= self.tick;
        while self.owed >= self.tick {
            self.vehicle.apply(held, self.tick.as_secs_f64())?;
            self.owed -= self.tick;
        }
        Ok(())
    }
}

impl MappedSide {
    fn tell(&mut self, input: Option<Input>) -> Result<()> {
        let request =
            CarRequest { input, answers_ns: self.measured_ns, utime: transport::now().utime };
        self.mapping.command(&request, &mut self.bytes)?;
        Ok(self.network.publish(self.mapping.command_channel(), &self.bytes)?)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "code of tests")]
    use std::sync::Mutex;

    use vehicle_model::CarParams;

    use super::*;

    const TICK: Duration = Duration::from_millis(10);

    /// Keeps the steps it was asked for.
    struct Steps(Arc<Mutex<Vec<(f64, f64)>>>, CarParams, Arc<Track>);

    impl Vehicle for Steps {
        fn measure(&mut self) -> State {
            State { v_x: self.0.lock().unwrap().len() as f64, ..State::default() }
        }

        fn truth(&self) -> State {
            State::default()
        }

        fn apply(&mut self, u: Input, dt: f64) -> Result<(), VehicleError> {
            self.0.lock().unwrap().push((u.a, dt));
            Ok(())
        }

        fn applied(&self) -> Input {
            Input::default()
        }

        fn progress(&self) -> f64 {
            0.0
        }

        fn track(&self) -> &Arc<Track> {
            &self.2
        }

        fn car(&self) -> &CarParams {
            &self.1
        }
    }

    #[test]
    fn a_stepped_vehicle_takes_whole_ticks_with_the_newest_input() {
        let steps: Arc<Mutex<Vec<(f64, f64)>>> = Arc::default();
        let (car, track) = (CarParams::builtin("barc").unwrap(), Track::builtin("l").unwrap());
        let vehicle = Steps(Arc::clone(&steps), car, Arc::new(track));
        let mut side = CarSide::stepped(Box::new(vehicle), TICK);
        let mut drive = |a: f64, us: u64| {
            side.drive(Input { a, delta: 0.0 }, Duration::from_micros(us)).unwrap();
            let new = side.measure().map(|x| x.v_x);
            (new, std::mem::take(&mut *steps.lock().unwrap()))
        };
        assert_eq!(drive(1.0, 10_000), (Some(1.0), vec![(1.0, 0.01)]));
        // An order comes between two ticks; the rest of the tick is driven with what it changed.
        assert_eq!(drive(1.0, 3_700), (None, vec![]), "nothing new to measure");
        assert_eq!(drive(-2.0, 6_300), (Some(1.0), vec![(-2.0, 0.01)]));
        // Ticks that were missed are steps of their own.
        assert_eq!(drive(-2.0, 30_000), (Some(3.0), vec![(-2.0, 0.01); 3]));
        assert_eq!(drive(-2.0, 60_000_000).1.len(), 10, "a minute is not made up for");
        assert_eq!(drive(-2.0, 10_000), (Some(1.0), vec![(-2.0, 0.01)]));
    }
}
