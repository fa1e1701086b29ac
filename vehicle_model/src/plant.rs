//! The simulated car: the truth a controller does not see.
//!
//! It has its own parameters, its own integrator, slow and late actuators, noisy sensors and
//! disturbances. The state is integrated in the Frenet frame of the track with s growing over the
//! laps; it is wrapped where it is measured.

mod actuator;
mod disturbance;
mod noise;

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::discretized::{Bend, runge_kutta_4};
use crate::error::ModelError;
use crate::model::{AxleForces, Held, Model, ModelKind, state_array};
use crate::params::{CarParams, ParamProblem};
use crate::state::{GlobalState, Input, State};
use crate::track::Track;

use actuator::PlantActuators;
pub use disturbance::{Disturbance, GripChange};
use noise::NoiseStream;
pub use noise::SensorNoise;

/// What a simulated car is made of.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlantParams {
    /// The true car; its actuator lag, delay, limits and rate limits act here.
    pub car: CarParams,
    /// Longest Runge-Kutta step; 10 ms is that of the paper's study, 1 ms a fine truth \[s\].
    #[serde(rename = "substep_s")]
    pub substep: f64,
    /// Noise of what is measured.
    pub noise: SensorNoise,
    /// What acts on the car beside its inputs.
    pub disturbance: Disturbance,
    /// Seed of both kinds of noise.
    pub seed: u64,
}

impl PlantParams {
    /// A deterministic plant of this car with steps of 10 ms.
    #[must_use]
    pub fn new(car: CarParams) -> Self {
        Self {
            car,
            substep: 0.01,
            noise: SensorNoise::default(),
            disturbance: Disturbance::default(),
            seed: 0,
        }
    }

    /// Every value that is out of range.
    #[must_use]
    pub fn validate(&self) -> Vec<ParamProblem> {
        let mut problems = self.car.validate();
        if !(self.substep.is_finite() && self.substep > 0.0) {
            problems.push(ParamProblem {
                section: "plant",
                key: "substep_s",
                found: self.substep.to_string(),
                expected: "a number above 0",
                line: None,
            });
        }
        problems.extend(self.noise.validate());
        problems.extend(self.disturbance.validate());
        problems
    }
}

/// Everything that changes while a [`Plant`] runs; what saves and restores it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PlantState {
    /// Time since the start [s].
    time: f64,
    /// State with s growing over the laps.
    x: State,
    actuators: PlantActuators,
    sensors: NoiseStream,
    process: NoiseStream,
}

/// A simulated car on a track.
#[derive(Debug, Clone)]
pub struct Plant {
    params: PlantParams,
    model: Model,
    track: Arc<Track>,
    state: PlantState,
}

impl Plant {
    /// A car at rest inputs in the state `initial`, whose s may lie in any lap.
    ///
    /// # Errors
    /// [`ModelError::PlantInvalid`] if a parameter is out of range, [`ModelError::NotFinite`] if the
    /// initial state is not finite.
    pub fn new(params: PlantParams, track: Arc<Track>, initial: State) -> Result<Self, ModelError> {
        let problems = params.validate();
        if !problems.is_empty() {
            return Err(ModelError::PlantInvalid(problems));
        }
        if !initial.is_finite() {
            return Err(ModelError::NotFinite(initial));
        }
        let model = Model::new(ModelKind::Dynamic, params.car.clone());
        let state = PlantState::new(initial, params.seed);
        Ok(Self { params, model, track, state })
    }

    /// Back to time 0 in another state, with fresh actuators and the noise from its seed on.
    pub fn reset(&mut self, initial: State) {
        self.state = PlantState::new(initial, self.params.seed);
    }

    /// [`Plant::reset`] with the actuators already at `position`.
    pub fn reset_at(&mut self, initial: State, position: Input) {
        self.reset(initial);
        self.state.actuators = PlantActuators::at(position);
    }

    /// Changes what acts on the car beside its inputs, from now on: its state stays.
    ///
    /// # Errors
    /// [`ModelError::PlantInvalid`] if a value is out of range; nothing is changed then.
    pub fn set_disturbance(&mut self, disturbance: Disturbance) -> Result<(), ModelError> {
        let problems = disturbance.validate();
        if !problems.is_empty() {
            return Err(ModelError::PlantInvalid(problems));
        }
        self.params.disturbance = disturbance;
        Ok(())
    }

    /// Drives with a command for `dt` seconds; a `dt` that is not above 0 changes nothing.
    ///
    /// The command enters the actuators now and acts after their delay; what is not finite in it
    /// is replaced by the value commanded before.
    pub fn apply(&mut self, u: Input, dt: f64) {
        if !(dt.is_finite() && dt > 0.0) {
            return;
        }
        self.state.actuators.command(&self.params.car, self.state.time, u);
        let start = self.state.time;
        let end = start + dt;
        let mut time = start;
        // The step is cut where a delayed command takes over, so that any delay is exact.
        while let Some(switch) = self.state.actuators.next_switch(&self.params.car, time, end) {
            self.advance(time, switch - time);
            time = switch;
        }
        // Uncut, the length is `dt` itself: the same bits as the nominal model's step.
        let rest = if time > start { end - time } else { dt };
        self.advance(time, rest);
        self.state.time = end;
        self.params.disturbance.kick(&mut self.state.process, &mut self.state.x, dt);
    }

    /// Integrates over a stretch of time in which the same command acts.
    fn advance(&mut self, start: f64, length: f64) {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "above 0")]
        let substeps = (length / self.params.substep - 1e-6).ceil().max(1.0) as usize;
        #[expect(clippy::cast_precision_loss, reason = "a handful of sub-steps")]
        let h = length / substeps as f64;
        for i in 0..substeps {
            #[expect(clippy::cast_precision_loss, reason = "a handful of sub-steps")]
            let time = start + i as f64 * h;
            let u = self.state.actuators.advance(&self.params.car, time, h);
            self.substep(time, u, h);
        }
    }

    fn substep(&mut self, time: f64, mut u: Input, h: f64) {
        let before = self.state.x;
        let braking = u.a < 0.0;
        if before.v_x <= 0.0 {
            // Brakes hold a car that stands, they do not push it back.
            u.a = u.a.max(0.0);
        }
        let disturbance = &self.params.disturbance;
        self.model.grip = disturbance.grip(time, self.track.wrap(before.s));
        let (model, track) = (&self.model, &self.track);
        let input = Held::new(&[u.a, u.delta]);
        let (flat, road) = (track.is_flat(), track.road());
        let mut bend = Bend::new(&road);
        let State { v_x, v_y, omega_z, e_psi, s, e_y } = before;
        bend.begin(&[v_x, v_y, omega_z], &[e_psi, s, e_y], h);
        let next = runge_kutta_4(&state_array(&before), h, &|x: &[f64; crate::NX], _| {
            let mut rates = model.rates_along(x, &input, &road, bend.kappa(x[4]), &model.grip);
            if disturbance.pushes() {
                let heading = track.heading(x[4]) + x[3];
                let [a_x, a_y] = disturbance.acceleration(heading, model.params.mass);
                rates[0] += a_x;
                rates[1] += a_y;
            }
            rates
        });
        let mut x = State::from_vector(&next.into());
        if u.a < 0.0 && before.v_x >= 0.0 && x.v_x < 0.0 {
            x.v_x = 0.0;
        }
        if braking && !flat && x.v_x < 0.0 {
            // Nor do they let it roll back down a slope.
            x.v_x = 0.0;
        }
        self.state.x = x;
    }

    /// What the sensors say now: noisy, s wrapped into the lap, e_psi into (-pi, pi].
    pub fn measure(&mut self) -> State {
        let noisy = self.params.noise.measure(&mut self.state.sensors, &self.state.x);
        self.wrapped(noisy)
    }

    /// The true state, s wrapped into the lap, e_psi into (-pi, pi].
    #[must_use]
    pub fn truth(&self) -> State {
        self.wrapped(self.state.x)
    }

    fn wrapped(&self, x: State) -> State {
        State { s: self.track.wrap(x.s), e_psi: crate::track::wrap_angle(x.e_psi), ..x }
    }

    /// The true state with s growing over the laps and e_psi over the turns.
    #[must_use]
    pub fn unwrapped(&self) -> State {
        self.state.x
    }

    /// The true pose and velocities in the global frame.
    #[must_use]
    pub fn global(&self) -> GlobalState {
        self.track.to_global(&self.truth())
    }

    /// The input that really acted last, after delay, lag and limits.
    #[must_use]
    pub fn applied(&self) -> Input {
        self.state.actuators.applied()
    }

    /// Slip angles, forces and loads of the axles now.
    #[must_use]
    pub fn tyres(&self) -> AxleForces<f64> {
        self.model.forces_along(&self.state.x, &self.applied(), &self.track.road())
    }

    /// Share of each axle's peak force in use, front and rear [-].
    #[must_use]
    pub fn utilisation(&self) -> [f64; 2] {
        let friction = self.track.friction(self.state.x.s);
        self.model.utilisation(&self.tyres()).map(|used| used / friction)
    }

    /// Time since the start \[s\].
    #[must_use]
    pub fn time(&self) -> f64 {
        self.state.time
    }

    /// Way along the track since s = 0 of lap 0, growing over the laps \[m\].
    #[must_use]
    pub fn progress(&self) -> f64 {
        self.state.x.s
    }

    /// Number of times the line has been crossed; negative if it was crossed backwards.
    #[must_use]
    #[expect(clippy::cast_possible_truncation, reason = "laps are few")]
    pub fn lap(&self) -> i64 {
        (self.state.x.s / self.track.length()).floor() as i64
    }

    /// What it is made of.
    #[must_use]
    pub fn params(&self) -> &PlantParams {
        &self.params
    }

    /// The track it drives on.
    #[must_use]
    pub fn track(&self) -> &Arc<Track> {
        &self.track
    }

    /// Everything that changes while it runs, to save.
    #[must_use]
    pub fn state(&self) -> &PlantState {
        &self.state
    }

    /// Goes on from a saved state of a plant with the same parameters.
    pub fn restore(&mut self, state: PlantState) {
        self.state = state;
    }
}

impl PlantState {
    fn new(x: State, seed: u64) -> Self {
        Self {
            time: 0.0,
            x,
            actuators: PlantActuators::default(),
            sensors: NoiseStream::new(seed, 1),
            process: NoiseStream::new(seed, 2),
        }
    }
}
