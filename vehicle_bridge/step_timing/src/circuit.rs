//! A simulated car and its controller, driving.

use std::sync::Arc;

use controller::{Command, Controller, Measurement, Pose};
use vehicle_model::{CarParams, Discretized, Model, ModelKind, State, Track};

use super::{BenchError, TimingCase};

/// Sub-steps of the simulated car in one period.
const SUBSTEPS: usize = 10;

/// A car on a track with its controller. Model and car are the same, there is no noise: the
/// problems are those of a race that goes well.
pub struct Circuit {
    /// The controller.
    pub controller: Controller,
    car: Discretized,
    track: Arc<Track>,
    x: State,
    periods: u32,
}

impl Circuit {
    /// A car at the line, about to drive `laps` initial laps.
    ///
    /// # Errors
    /// If car or track do not ship, or do not fit the configuration.
    pub fn new(case: &TimingCase, laps: usize) -> Result<Self, BenchError> {
        let mut config = case.config.clone();
        config.warm_up.laps = laps;
        let missing = |what, name: &str| BenchError::Missing(what, name.to_owned());
        let car = CarParams::builtin(case.car).map_err(|_| missing("car", case.car))?;
        let track = Track::builtin(case.track).ok_or_else(|| missing("track", case.track))?;
        let (car, track) = (CarParams { actuator_lag: 0.0, ..car }, Arc::new(track));
        let dt = config.horizon.period;
        let model = Model::new(ModelKind::Dynamic, car.clone());
        Ok(Self {
            x: State { v_x: config.warm_up.speed, ..State::default() },
            controller: Controller::new(config, car, track.clone())?,
            car: Discretized { model, dt, substeps: SUBSTEPS },
            track,
            periods: 0,
        })
    }

    /// Drives until `laps` are stored.
    pub fn race(&mut self, laps: usize) {
        while self.controller.laps().len() < laps {
            let command = self.controller.step(&self.measurement());
            self.drive(&command);
        }
    }

    /// What the sensors say now.
    #[must_use]
    pub fn measurement(&self) -> Measurement {
        let pose = Pose::Frenet(State { s: self.track.wrap(self.x.s), ..self.x });
        Measurement { time: f64::from(self.periods) * self.car.dt, pose, applied: None }
    }

    /// Drives one period.
    pub fn drive(&mut self, command: &Command) {
        self.x = self.car.next(&self.x, &command.input, self.track.road());
        self.periods += 1;
    }
}
