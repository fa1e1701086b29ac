//! The controller: one call per period, the same in every host.

use std::sync::Arc;

use actuators::{Actuators, Response};
use nalgebra::Matrix6;
use vehicle_model::{CarParams, Discretized, Input, Model, ModelKind, State, Track, Tracker};

use crate::config::{Config, NominalModel, RegressionConfig};
use crate::error::ConfigError;
use crate::fhocp::Fhocp;
use crate::filter::{Filter, Prediction};
use crate::learned_model::{self, LearnedModel};
use crate::learning::bends::Bends;
use crate::learning::dataset::Lap;
use crate::learning::regression::Scratch;
use crate::learning::safe_set::SafeSet;
use crate::memory::Memory;
use crate::observe::Observer;
use crate::optimize::Workspace;
use crate::plan::Plan;
use crate::status::{Command, Measurement, Phase, Probe, Reason, Status};

/// Learning model predictive controller.
///
/// Errors belong to construction; [`Controller::step`] always returns an input inside the car's
/// limits.
pub struct Controller {
    pub(crate) setup: Setup,
    pub(crate) memory: Memory,
    pub(crate) work: Workspace,
    pub(crate) prepared: bool,
    /// Memory of a plan that is made anew.
    pub(crate) spare: Plan,
}

/// What the controller is given and, but for the fitted grip, keeps.
pub(crate) struct Setup {
    pub(crate) config: Config,
    pub(crate) car: CarParams,
    pub(crate) track: Arc<Track>,
    /// Curvature that the track asks for.
    pub(crate) bends: Bends,
    /// Discretised nominal model with the fitted grip.
    pub(crate) model: Discretized,
    pub(crate) tracker: Tracker,
    pub(crate) actuators: Actuators,
    pub(crate) filter: Option<Filter>,
    /// The regression's settings, its ridge as the noise asks for.
    pub(crate) regression: RegressionConfig,
}

impl Controller {
    /// A controller that knows nothing yet but its nominal car and its track.
    ///
    /// # Errors
    /// [`ConfigError`] if a value is out of range or configuration, car and track do not fit
    /// together.
    pub fn new(config: Config, car: CarParams, track: Arc<Track>) -> Result<Self, ConfigError> {
        let config = config.checked()?;
        fits(&config, &track)?;
        let kind = match config.nominal.model {
            NominalModel::Dynamic => ModelKind::Dynamic,
            NominalModel::Kinematic => ModelKind::Kinematic,
        };
        let (dt, substeps) = (config.horizon.period, config.horizon.substeps);
        let mut nominal = car.clone();
        nominal.tyre_front = nominal.tyre_front.with_secant(config.nominal.secant);
        nominal.tyre_rear = nominal.tyre_rear.with_secant(config.nominal.secant);
        let model = Discretized { model: Model::new(kind, nominal), dt, substeps };
        let delay = config.delay.steps as f64 * dt;
        let given = Response { delay, lag: car.actuator_lag };
        let mut controller = Self {
            memory: Memory::new(&config),
            work: Workspace::new(&config, &car, &track, &model),
            prepared: false,
            spare: Plan::with_capacity(config.horizon.steps),
            setup: Setup {
                bends: Bends::new(&car, &track),
                tracker: Tracker::new(&car),
                actuators: Actuators::new(&car, dt, given),
                regression: config.regression.clone(),
                filter: config.filter.active.then(|| Filter::new(&config.filter, &car, dt)),
                config,
                car,
                track,
                model,
            },
        };
        controller.apply_learned();
        Ok(controller)
    }

    /// Reads a measurement and returns the input for the coming period. Cannot fail.
    pub fn step(&mut self, measurement: &Measurement) -> Command {
        self.step_probed(measurement, &mut ())
    }

    /// [`Controller::step`] that tells `probe` about its phases.
    pub fn step_probed(&mut self, measurement: &Measurement, probe: &mut impl Probe) -> Command {
        self.prepare_probed(probe);
        probe.begin(Phase::Project);
        let prediction = self.prediction(measurement);
        let observer = Observer {
            config: &self.setup.config,
            track: &self.setup.track,
            jump_floor: self.setup.car.l_f + self.setup.car.l_r,
            filter: self.setup.filter.as_ref(),
            prediction: prediction.as_ref(),
        };
        if measurement.applied.is_some() {
            self.memory.actuation.reported();
        }
        let last = self.memory.last.filter(|_| !self.memory.learning);
        let raw = self.memory.estimate.raw;
        let driven = self.memory.last.filter(|_| self.fits_grip());
        let sample = self.memory.dataset.current.samples.last();
        let acted = measurement.applied.or(sample.map(|sample| sample.u));
        let observed = observer.observe(&mut self.memory, measurement);
        // What is learned from: the state that follows the last one, and no incident.
        let steady = self.memory.recovery.is_none();
        let follows = observed.as_ref().ok().filter(|now| steady && now.reason == Reason::None);
        let follows = follows.map(|now| now.state);
        self.memory.prediction_error.compare(follows.as_ref());
        if let (Some(last), Some(now)) = (last, follows)
            && self.setup.config.delay.estimates()
        {
            // A filter without delay draws its estimate to what happens without delay.
            let measured = self.setup.filter.as_ref().is_some_and(|filter| !filter.blind());
            let (from, to) =
                if measured { (raw, self.memory.estimate.raw) } else { (last.state, now) };
            self.observe_response(&from, &to);
        }
        if let (Some(last), Some(u), Some(now)) = (driven, acted, follows) {
            let to = if self.setup.filter.is_some() { self.memory.estimate.raw } else { now };
            self.observe_grip(&last.state, &to, &u);
            if self.memory.learned && measurement.applied.is_none() {
                self.observe_drift(&last.state, &to);
            }
            if self.memory.learned {
                self.observe_road(&last.state, &to, &u);
            }
            // What was prepared before the measurement holds no more after a change of the grip.
            self.prepare_probed(probe);
        }
        probe.end(Phase::Project);
        let road_grip = self.memory.road.share;
        let (lap, delay_change) = (self.memory.lap, self.delay_change());
        let mut status = Status { lap, road_grip, delay_change, ..Status::default() };
        let wanted = match observed {
            Ok(observation) => self.drive(&observation, &mut status, probe),
            Err(reason) => self.hold_on(reason, &mut status),
        };
        // A repeated measurement is answered with the same command; no period passes.
        if status.reason == Reason::TimeNotAdvancing {
            return Command { input: wanted, status };
        }
        let wanted = self.limited(wanted, &mut status);
        Command { input: self.commit(wanted), status }
    }

    /// The model from the last believed state to the next measurement, for the filter.
    fn prediction(&mut self, measurement: &Measurement) -> Option<Prediction> {
        self.setup.filter.as_ref()?;
        let last = self.memory.last?;
        let acting = self.memory.dataset.current.samples.last().map(|sample| sample.u);
        let u = measurement.applied.or(acting)?;
        let (setup, x) = (&self.setup, &last.state);
        let mode = setup.config.regression.mode;
        let prepared = self.work.prepared_model(x, &u);
        let nominal = prepared
            .unwrap_or_else(|| learned_model::nominal(&setup.model, mode, &setup.track, x, &u));
        let mut model = nominal;
        if self.memory.estimate.filters() {
            let data = &self.memory.derived.regression;
            let scratch = &mut self.work.scratch;
            model = model + learned_model::error(data, &setup.regression, 0, (x, &u), scratch).0;
        }
        let next = model.apply(&x.to_vector(), &u.to_vector());
        // Slopes learned from noise are noise.
        Some(Prediction { a: nominal.a, next })
    }

    /// What can be done before the next measurement: a piece of the learning from closed laps, and
    /// the preparation of the next problem. Hosts with time between steps call it there; otherwise the next step
    /// begins with it, with the same result.
    pub fn prepare(&mut self) {
        self.prepare_probed(&mut ());
    }

    /// [`Controller::prepare`] that tells `probe` about its phases.
    pub fn prepare_probed(&mut self, probe: &mut impl Probe) {
        if self.prepared {
            return;
        }
        self.prepared = true;
        if !self.memory.learned_piece {
            self.memory.learned_piece = true;
            self.learn_piece();
        }
        if self.memory.plan.is_empty() {
            return;
        }
        if !self.memory.shifted {
            let (model, track) = (&self.setup.model, &self.setup.track);
            let tail = self.memory.plan_tail;
            self.memory.plan.shift(tail, |x, u| model.next(x, u, track.road()));
            self.memory.shifted = true;
        }
        self.work.prepare(&self.setup, &self.memory, probe);
    }

    /// Changes the speed that plans keep to from the next step on; 0 takes the cap away \[m/s\].
    ///
    /// The configuration, and with it what learned data belong to, stays as it is. Warm-up laps
    /// have a speed of their own.
    ///
    /// # Errors
    /// [`ConfigError::Values`] outside the range of `limits.speed_cap`; nothing is changed then.
    pub fn set_speed_cap(&mut self, cap: f64) -> Result<(), ConfigError> {
        let mut config = self.setup.config.clone();
        config.limits.speed_cap = cap;
        self.work.set_speed_cap(&config.checked()?);
        self.prepared = false;
        Ok(())
    }

    /// The latest plan in the frame of the current lap; empty before learning begins.
    #[must_use]
    pub fn plan(&self) -> &Plan {
        &self.memory.plan
    }

    /// The latest problem given to a solver; s counts from where the plan expects
    /// the car. After [`Controller::prepare`]
    /// it is in part the next one.
    #[must_use]
    pub fn problem(&self) -> &Fhocp {
        self.work.problem()
    }

    /// Weights lambda of the points of [`Controller::safe_set`] in the last solution; of use after a
    /// step whose action is [`Action::Learned`](crate::Action::Learned), until
    /// [`Controller::prepare`] makes the next set.
    #[must_use]
    pub fn safe_set_weights(&self) -> &[f64] {
        self.work.weights()
    }

    /// The safe set of the latest problem.
    #[must_use]
    pub fn safe_set(&self) -> &SafeSet {
        &self.work.safe_set
    }

    /// All closed laps, oldest first.
    #[must_use]
    pub fn laps(&self) -> &[Arc<Lap>] {
        &self.memory.dataset.laps
    }

    /// Factors on front and rear grip in force: those fitted, times [`Controller::road_grip`].
    #[must_use]
    pub fn grip(&self) -> [f64; 2] {
        self.setup.model.model.grip
    }

    /// Share of the fitted grip that the road has now, 1 for all of it.
    #[must_use]
    pub fn road_grip(&self) -> f64 {
        self.memory.road.share
    }

    /// Covariance of the state that the last step used, as the filter predicts it; none where the
    /// measurement passed as it was.
    #[must_use]
    pub fn covariance(&self) -> Option<Matrix6<f64>> {
        self.memory.estimate.covariance()
    }

    /// Standard deviations of the state that the last step used, in state order \[m/s, m/s, rad/s, rad, m,
    /// m\]: the roots of the diagonal of [`Controller::covariance`].
    #[must_use]
    pub fn state_sigma(&self) -> Option<[f64; 6]> {
        self.covariance().map(|p| std::array::from_fn(|i| p[(i, i)].max(0.0).sqrt()))
    }

    /// Standard deviations of the measurement's noise, as configured or estimated while driving, in state
    /// order \[m/s, m/s, rad/s, rad, m, m\]; 0 for velocities that are not measured, none where the
    /// measurement passed as it was.
    #[must_use]
    pub fn noise_sigma(&self) -> Option<[f64; 6]> {
        self.setup.filter.as_ref()?.noise_sigma(&self.memory.estimate)
    }

    /// The learned model around a point, in its parts.
    #[must_use]
    pub fn learned_model(&self, x: &State, u: &Input) -> LearnedModel {
        let data = &self.memory.derived.regression;
        let mut scratch = Scratch::new(&self.setup.config.regression, 0);
        LearnedModel::at(&self.setup, data, x, u, &mut scratch)
    }

    /// The configuration.
    #[must_use]
    pub fn config(&self) -> &Config {
        &self.setup.config
    }

    /// The nominal car.
    #[must_use]
    pub fn car(&self) -> &CarParams {
        &self.setup.car
    }

    /// The track.
    #[must_use]
    pub fn track(&self) -> &Arc<Track> {
        &self.setup.track
    }
}

/// Whether the lane has room on this track.
fn fits(config: &Config, track: &Track) -> Result<(), ConfigError> {
    let margin = config.limits.lane_margin;
    let narrow = track.narrowest();
    if 2.0 * margin >= narrow {
        return Err(ConfigError::Mismatch(format!(
            "limits.lane_margin_m = {margin} leaves no lane on track \"{}\", which is {narrow} m \
             wide at its narrowest; allowed is less than {}",
            track.name(),
            0.5 * narrow
        )));
    }
    Ok(())
}
