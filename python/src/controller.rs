//! `Controller`.

use std::path::PathBuf;
use std::sync::Arc;

use controller::{Controller as Inner, ControllerState as InnerState, Measurement, Pose};
use hosting::learned;
use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};

use crate::arrays::{from_input, global, input, state};
use crate::car::Car;
use crate::config::Config;
use crate::errors::{ConfigError, DataError, raise};
use crate::plan::{self, LearnedModel, Plan, SafeSet};
use crate::status::Status;
use crate::table;
use crate::track::Track;

/// The learning controller: one step per period. It has no clock and no files of its own.
///
/// Steps release the interpreter's lock. A controller serves one thread at a time.
///
/// A controller that believes in this car (see `Car.nominal`) and knows nothing else.
///
/// Raises:
///     CarError, TrackError, ConfigError: the arguments are wrong or do not fit together.
#[pyclass(module = "racing_lmpc")]
pub(crate) struct Controller {
    inner: Inner,
    track: Py<Track>,
    /// Steps without a time of their own: theirs is this many periods.
    steps: u64,
}

/// All that changes while a controller runs; taking it is cheap whatever was learned.
#[pyclass(frozen, module = "racing_lmpc")]
pub(crate) struct ControllerState {
    inner: InnerState,
    steps: u64,
}

/// What a step returns.
type Answer<'py> = (Bound<'py, PyArray1<f64>>, Status);

impl Controller {
    fn answer<'py>(
        &mut self,
        py: Python<'py>,
        pose: Pose,
        time: Option<f64>,
        applied: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Answer<'py>> {
        let applied = applied.map(input).transpose()?;
        let time = time.unwrap_or_else(|| self.steps as f64 * self.inner.config().horizon.period);
        self.steps += 1;
        let measurement = Measurement { time, pose, applied };
        let inner = &mut self.inner;
        let command = py.detach(|| inner.step(&measurement));
        Ok((from_input(py, &command.input), Status(command.status)))
    }
}

#[pymethods]
impl Controller {
    #[new]
    #[pyo3(signature = (car, track, config = None))]
    fn new(
        car: &Bound<'_, PyAny>,
        track: &Bound<'_, PyAny>,
        config: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let (car, track) = (Car::of(car)?, Track::of(track)?);
        let shared = Arc::clone(&track.get().inner);
        let built = Config::of(config)?.layers.build_for(&car.inner, &shared);
        let config = built.map_err(raise::<ConfigError>)?;
        let inner = Inner::new(config, car.inner, shared).map_err(raise::<ConfigError>)?;
        Ok(Self { inner, track, steps: 0 })
    }

    /// Reads a measured state and returns the input for the coming period; never fails on
    /// what was measured.
    ///
    /// Args:
    ///     x: state (6,), s in [0, L). A float64 array is read where it lies.
    ///     time: time of the measurement; by default one period after the step before [s].
    ///     applied: input (2,) that really acted since then, where the car reports it.
    ///
    /// Returns:
    ///     Input (2,), finite and inside the car's limits, and what was done.
    #[pyo3(signature = (x, time = None, applied = None))]
    fn step<'py>(
        &mut self,
        py: Python<'py>,
        x: &Bound<'py, PyAny>,
        time: Option<f64>,
        applied: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Answer<'py>> {
        let pose = Pose::Frenet(state(x)?);
        self.answer(py, pose, time, applied)
    }

    /// `step` with a global state (6,), which is projected onto the track.
    #[pyo3(signature = (g, time = None, applied = None))]
    fn step_global<'py>(
        &mut self,
        py: Python<'py>,
        g: &Bound<'py, PyAny>,
        time: Option<f64>,
        applied: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Answer<'py>> {
        let pose = Pose::Global(global(g)?);
        self.answer(py, pose, time, applied)
    }

    /// Does the part of the next step that needs no measurement. Without it the next step does
    /// it, with the same result.
    fn prepare(&mut self, py: Python<'_>) {
        let inner = &mut self.inner;
        py.detach(|| inner.prepare());
    }

    /// Speed that plans keep to from the next step on; 0 takes it away [m/s].
    fn set_speed_cap(&mut self, cap: f64) -> PyResult<()> {
        self.inner.set_speed_cap(cap).map_err(raise::<ConfigError>)
    }

    /// Learns from all closed laps now; otherwise in pieces over the coming steps.
    fn finish_learning(&mut self, py: Python<'_>) {
        let inner = &mut self.inner;
        py.detach(|| inner.finish_learning());
    }

    /// Whether something of the closed laps is still to be learned.
    #[getter]
    fn learning_pending(&self) -> bool {
        self.inner.learning_pending()
    }

    /// Control period [s].
    #[getter]
    fn period(&self) -> f64 {
        self.inner.config().horizon.period
    }

    /// Speed of the initial laps; races begin with it [m/s].
    #[getter]
    fn warm_up_speed(&self) -> f64 {
        self.inner.config().warm_up.speed
    }

    /// The track.
    #[getter]
    fn track(&self, py: Python<'_>) -> Py<Track> {
        self.track.clone_ref(py)
    }

    /// Fitted factors on front and rear grip [-].
    #[getter]
    fn grip(&self) -> (f64, f64) {
        let [front, rear] = self.inner.grip();
        (front, rear)
    }

    /// Time from a command to the beginning of its effect, in force [s].
    #[getter]
    fn delay(&self) -> f64 {
        self.inner.response().delay
    }

    /// Time constant of the actuators in force [s].
    #[getter]
    fn lag(&self) -> f64 {
        self.inner.response().lag
    }

    /// Closed laps, oldest first: ``lap``, ``kind``, ``lap_time`` [s], ``valid``, and the
    /// samples ``time`` (n,) [s], ``x`` (n, 6), ``u`` (n, 2).
    #[getter]
    fn laps<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyDict>>> {
        self.inner.laps().iter().map(|lap| table::recorded_lap(py, lap)).collect()
    }

    /// The plan of the last step.
    #[getter]
    fn plan(&self, py: Python<'_>) -> PyResult<Plan> {
        plan::plan(py, &self.inner)
    }

    /// The safe set of the last step.
    #[getter]
    fn safe_set(&self, py: Python<'_>) -> PyResult<SafeSet> {
        plan::safe_set(py, &self.inner)
    }

    /// The learned model around a state (6,) and an input (2,).
    fn learned_model(&self, x: &Bound<'_, PyAny>, u: &Bound<'_, PyAny>) -> PyResult<LearnedModel> {
        Ok(plan::learned_model(&self.inner, &state(x)?, &input(u)?))
    }

    /// What was learned, with the fingerprints of car, track and configuration.
    fn save<'py>(&self, py: Python<'py>) -> Bound<'py, PyBytes> {
        let inner = &self.inner;
        let bytes = py.detach(|| inner.save());
        PyBytes::new(py, &bytes)
    }

    /// Starts from saved data.
    ///
    /// Raises:
    ///     DataError: damaged, or of another car, track or configuration; nothing is changed.
    fn load(&mut self, py: Python<'_>, data: &[u8]) -> PyResult<()> {
        let inner = &mut self.inner;
        py.detach(|| inner.load(data)).map_err(raise::<DataError>)
    }

    /// Writes what was learned; an earlier file stays as ``.bak``.
    fn save_file(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        let inner = &self.inner;
        py.detach(|| learned::save(&path, inner)).map_err(raise::<DataError>)
    }

    /// `load` from a file.
    fn load_file(&mut self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        let inner = &mut self.inner;
        py.detach(|| learned::load(&path, inner)).map_err(raise::<DataError>)
    }

    /// All that changes, to go back to with `resume`.
    #[getter]
    fn state(&self) -> ControllerState {
        ControllerState { inner: self.inner.state(), steps: self.steps }
    }

    /// Goes on from a state of a controller of the same car, track and configuration.
    fn resume(&mut self, state: &ControllerState) {
        self.steps = state.steps;
        self.inner.resume(&state.inner);
    }

    fn __repr__(&self) -> String {
        let (car, track) = (&self.inner.car().name, self.inner.track().name());
        format!("Controller({car:?} on {track:?}, {} laps)", self.inner.laps().len())
    }
}
