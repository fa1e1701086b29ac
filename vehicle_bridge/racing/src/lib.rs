//! The offline host: a simulated car and its controller in one process, faster than real time.
//!
//! Vehicle -> Measurement -> Controller::step -> Vehicle, once each period.

pub mod columns;
pub mod files;
mod parts;
mod plant;
pub mod raceline;
pub mod record;
pub mod words;

use std::sync::Arc;

use controller::fhocp::{Backend, Fhocp};
use controller::{
    Action, Config, ConfigError, Controller, LapKind, LapResult, Measurement, Pose, SolveStatus,
    Status,
};
use vehicle_model::{
    CarParams, Discretized, Input, Model, ModelError as PlantError, ModelKind, Outline, Plant,
    PlantParams, SlipAngles, State, Track,
};

pub use hosting::rule::{Edges, FailureRule, TrackLimit};
pub use parts::{Parts, SMALL_CAR, nominal};
pub use plant::{change_plant, overlay_changes};

use hosting::rule::FailureReason;
use hosting::timing::{StepTime, Stopwatch};
use record::{Failure, LapRow, ModelErrorNorms, StepRow, tyre_use};
use vehicle_host::{Vehicle, VehicleError};

/// Where the learned model is compared with the plant's own linearisation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ModelErrorAt {
    /// At the current state and input.
    Now,
    /// At every point of the plan.
    Plan,
    /// Nowhere: it takes a regression of its own in each step.
    Never,
}

/// Why a race cannot begin, or go on.
#[derive(Debug, thiserror::Error)]
pub enum RaceError {
    /// The controller refuses its configuration.
    #[error(transparent)]
    Controller(#[from] ConfigError),
    /// The simulated car cannot be built.
    #[error("the simulated car: {0}")]
    Plant(#[from] PlantError),
    /// What computes the vehicle fails under way.
    #[error(transparent)]
    Vehicle(#[from] VehicleError),
}

/// Everything a race is made of.
#[derive(Debug, Clone)]
pub struct RaceOptions {
    /// Configuration of the controller.
    pub config: Config,
    /// The car the controller believes in.
    pub nominal: CarParams,
    /// The simulated car.
    pub plant: PlantParams,
    /// The track.
    pub track: Arc<Track>,
    /// Learning laps to drive.
    pub laps: u32,
    /// Seed of the plant's noise; that of the warm-up laps stands in the configuration.
    pub seed: u64,
    /// Where the model's error is taken.
    pub model_error: ModelErrorAt,
    /// What has to stay inside the track.
    pub limit: TrackLimit,
    /// Whether the race goes on after a failure from which the car can drive back.
    pub recover: bool,
    /// Keep the problems that the structured solver does not solve to tolerance.
    pub keep_unsolved: bool,
}

impl RaceOptions {
    /// A race of a car against itself: the controller knows the plant, nothing disturbs.
    #[must_use]
    pub fn new(config: Config, car: CarParams, track: Arc<Track>) -> Self {
        Self {
            limit: TrackLimit::of(&config),
            config,
            nominal: car.clone(),
            plant: PlantParams::new(car),
            track,
            laps: 20,
            seed: 0,
            model_error: ModelErrorAt::Now,
            recover: false,
            keep_unsolved: false,
        }
    }
}

/// A race in progress.
pub struct Race {
    options: RaceOptions,
    rule: FailureRule,
    /// The body of the vehicle that drives.
    outline: Outline,
    controller: Controller,
    vehicle: Box<dyn Vehicle>,
    /// What the learned model is compared with; none where the vehicle's inside is unknown.
    exact: Option<Discretized>,
    time: f64,
    lap_start: f64,
    learning: bool,
    learned_laps: u32,
    /// First step of the lap in progress.
    lap_begin: usize,
    /// Finished laps.
    pub laps: Vec<LapRow>,
    /// Control steps.
    pub steps: Vec<StepRow>,
    /// Times of the control steps.
    pub times: Vec<StepTime>,
    /// Failures from which the car drove back, or is driving back.
    pub incidents: Vec<Failure>,
    /// Problems that the structured solver did not solve to tolerance, with the number of their step, if
    /// they are kept.
    pub unsolved: Vec<(usize, Fhocp)>,
    /// The last of them is not over.
    broken: bool,
    /// Why the race ended early, if it did.
    pub failure: Option<Failure>,
}

impl Race {
    /// The simulated car of the options on the line, centred, at warm-up speed.
    ///
    /// # Errors
    /// If configuration, car and track do not fit together.
    pub fn new(options: RaceOptions) -> Result<Self, RaceError> {
        let plant = PlantParams { seed: options.seed, ..options.plant.clone() };
        let start = State { v_x: options.config.warm_up.speed, ..State::default() };
        let model = Model::new(ModelKind::Dynamic, plant.car.clone());
        let horizon = &options.config.horizon;
        let exact = Discretized { model, dt: horizon.period, substeps: horizon.substeps };
        let plant = Plant::new(plant, Arc::clone(&options.track), start)?;
        Ok(Self { exact: Some(exact), ..Self::with_vehicle(options, Box::new(plant))? })
    }

    /// Any vehicle, as it stands; the simulated car of the options is not used.
    ///
    /// # Errors
    /// If configuration, car and track do not fit together.
    pub fn with_vehicle(
        options: RaceOptions,
        vehicle: Box<dyn Vehicle>,
    ) -> Result<Self, RaceError> {
        let RaceOptions { config, nominal, track, .. } = &options;
        let controller = Controller::new(config.clone(), nominal.clone(), Arc::clone(track))?;
        Ok(Self {
            rule: FailureRule::new(config, track, vehicle.car(), options.limit),
            outline: Outline::new(vehicle.car()),
            exact: None,
            vehicle,
            controller,
            time: 0.0,
            lap_start: 0.0,
            learning: false,
            learned_laps: 0,
            lap_begin: 0,
            laps: Vec::new(),
            steps: Vec::new(),
            times: Vec::new(),
            incidents: Vec::new(),
            unsolved: Vec::new(),
            broken: false,
            failure: None,
            options,
        })
    }

    /// The controller.
    #[must_use]
    pub fn controller(&self) -> &Controller {
        &self.controller
    }

    /// The controller, to load learned data before the first step.
    pub fn controller_mut(&mut self) -> &mut Controller {
        &mut self.controller
    }

    /// Drives until the laps are done or the car fails; `on_lap` sees each lap as it ends.
    ///
    /// # Errors
    /// If what computes the vehicle fails.
    pub fn run(&mut self, mut on_lap: impl FnMut(&LapRow)) -> Result<(), VehicleError> {
        self.run_while(|lap| {
            on_lap(lap);
            true
        })
    }

    /// [`Race::run`] that ends as well when `on_lap` returns `false`.
    ///
    /// # Errors
    /// If what computes the vehicle fails.
    pub fn run_while(
        &mut self,
        mut on_lap: impl FnMut(&LapRow) -> bool,
    ) -> Result<(), VehicleError> {
        while self.failure.is_none() && self.learned_laps < self.options.laps {
            let before = self.laps.len();
            self.step()?;
            if self.laps.get(before).is_some_and(|lap| !on_lap(lap)) {
                break;
            }
        }
        Ok(())
    }

    /// One period: measure, step, apply.
    ///
    /// # Errors
    /// If what computes the vehicle fails.
    pub fn step(&mut self) -> Result<(), VehicleError> {
        let measurement = Measurement {
            time: self.time,
            pose: Pose::Frenet(self.vehicle.measure()),
            applied: None,
        };
        let mut stopwatch = Stopwatch::start();
        let command = self.controller.step_probed(&measurement, &mut stopwatch);
        self.times.push(stopwatch.stop());
        if self.options.keep_unsolved && unsolved(&command.status) {
            self.unsolved.push((self.steps.len(), self.controller.problem().clone()));
        }
        self.close_lap(&command.status);
        self.learning |= command.status.action == Action::Learned;
        let row = self.row(command.input, command.status);
        self.steps.push(row);

        let period = self.options.config.horizon.period;
        self.vehicle.apply(command.input, period)?;
        // Counted, not summed: a thousand additions of 0.1 miss.
        self.time = self.steps.len() as f64 * period;
        self.judge();
        Ok(())
    }

    /// The lap in which the car failed, summed up as far as it went; its lap time is no number.
    #[must_use]
    pub fn failed_lap(&self) -> Option<LapRow> {
        let failure = self.failure.as_ref()?;
        let steps = &self.steps[self.lap_begin..];
        let learning = failure.iteration > 0;
        let result = LapResult {
            lap: steps.last()?.status.lap,
            kind: if learning { LapKind::Learning } else { LapKind::Warmup },
            lap_time: f64::NAN,
            valid: false,
        };
        let iteration = learning.then_some(failure.iteration);
        Some(LapRow::new(result, iteration, self.controller.grip(), steps))
    }

    fn close_lap(&mut self, status: &Status) {
        let Some(result) = status.finished else { return };
        self.lap_start = self.time;
        let learning = result.kind == LapKind::Learning;
        self.learned_laps += u32::from(learning);
        let iteration = learning.then_some(self.learned_laps);
        let steps = &self.steps[self.lap_begin..];
        let lap = LapRow::new(result, iteration, self.controller.grip(), steps);
        self.laps.push(lap);
        self.lap_begin = self.steps.len();
    }

    fn row(&self, u: Input, status: Status) -> StepRow {
        let x = self.vehicle.truth();
        let car = self.vehicle.car();
        let slip = SlipAngles::new(&x, &self.vehicle.applied(), car);
        StepRow {
            time: self.time,
            x,
            pose: self.options.track.to_global(&x),
            u,
            status,
            alpha_f: slip.front,
            alpha_r: slip.rear,
            use_f: tyre_use(&car.tyre_front, slip.front),
            use_r: tyre_use(&car.tyre_rear, slip.rear),
            overhang: self.outline.overhang(&self.options.track, &x),
            model_error: self.model_error(&x, &u, &status),
        }
    }

    /// |A_learned - A_plant| with the same discretisation, at the same points.
    fn model_error(&self, x: &State, u: &Input, status: &Status) -> ModelErrorNorms {
        let Some(plant) = self.exact.as_ref().filter(|_| status.action == Action::Learned) else {
            return ModelErrorNorms::NONE;
        };
        let at = |x: &State, u: &Input| {
            let learned = self.controller.learned_model(x, u).sum().a;
            let road = self.options.track.road();
            let mut exact = plant.linearize(x, u, self.options.track.road());
            plant.follow_bend(x, &road, 0.0, &mut exact);
            (learned - exact.a).norm()
        };
        match self.options.model_error {
            ModelErrorAt::Never => ModelErrorNorms::NONE,
            ModelErrorAt::Now => ModelErrorNorms::of(vec![at(x, u)]),
            ModelErrorAt::Plan => {
                let plan = self.controller.plan();
                ModelErrorNorms::of(plan.x.iter().zip(&plan.u).map(|(x, u)| at(x, u)).collect())
            }
        }
    }

    fn judge(&mut self) {
        let x = self.vehicle.truth();
        let broken = self.rule.broken(&self.options.track, &x, self.time - self.lap_start);
        let failure = broken.map(|reason| Failure {
            reason,
            iteration: if self.learning { self.learned_laps + 1 } else { 0 },
            time: self.time,
            x,
            beyond: self.rule.edges.beyond(&self.options.track, &x),
        });
        let recoverable = |failure: &Failure| {
            !matches!(failure.reason, FailureReason::NoLap | FailureReason::NotFinite)
        };
        let Some(failure) = failure.filter(|f| !self.options.recover || !recoverable(f)) else {
            let recovering =
                self.steps.last().is_some_and(|row| row.status.action == Action::Recovering);
            // One incident lasts until the car drives again.
            if let Some(failure) = failure.filter(|_| !self.broken) {
                self.incidents.push(failure);
            }
            self.broken = failure.is_some() || (self.broken && recovering);
            return;
        };
        self.failure = Some(failure);
    }
}

/// Whether the structured solver was given a problem that it did not solve to tolerance.
fn unsolved(status: &Status) -> bool {
    match status.solve {
        SolveStatus::NotRun => false,
        SolveStatus::Solved => status.solver == Some(Backend::Clarabel),
        _ => true,
    }
}
