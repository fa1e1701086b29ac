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

/// The learning controller.
#[pyclass(module = "racing_lmpc")]
pub(crate) struct Controller {
    inner: Inner,
    track: Py<Track>,
    /// Steps without a time of their own: theirs is this many periods.
    steps: u64,
}

/// All that changes while a controller runs.
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

    fn prepare(&mut self, py: Python<'_>) {
        let inner = &mut self.inner;
        py.detach(|| inner.prepare());
    }

    fn set_speed_cap(&mut self, cap: f64) -> PyResult<()> {
        self.inner.set_speed_cap(cap).map_err(raise::<ConfigError>)
    }

    fn finish_learning(&mut self, py: Python<'_>) {
        let inner = &mut self.inner;
        py.detach(|| inner.finish_learning());
    }

    #[getter]
    fn learning_pending(&self) -> bool {
        self.inner.learning_pending()
    }

    #[getter]
    fn period(&self) -> f64 {
        self.inner.config().horizon.period
    }

    #[getter]
    fn warm_up_speed(&self) -> f64 {
        self.inner.config().warm_up.speed
    }

    #[getter]
    fn track(&self, py: Python<'_>) -> Py<Track> {
        self.track.clone_ref(py)
    }

    #[getter]
    fn grip(&self) -> (f64, f64) {
        let [front, rear] = self.inner.grip();
        (front, rear)
    }

    #[getter]
    fn delay(&self) -> usize {
        self.inner.delay()
    }

    #[getter]
    fn laps<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyDict>>> {
        self.inner.laps().iter().map(|lap| table::recorded_lap(py, lap)).collect()
    }

    #[getter]
    fn plan(&self, py: Python<'_>) -> PyResult<Plan> {
        plan::plan(py, &self.inner)
    }

    #[getter]
    fn safe_set(&self, py: Python<'_>) -> PyResult<SafeSet> {
        plan::safe_set(py, &self.inner)
    }

    fn learned_model(&self, x: &Bound<'_, PyAny>, u: &Bound<'_, PyAny>) -> PyResult<LearnedModel> {
        Ok(plan::learned_model(&self.inner, &state(x)?, &input(u)?))
    }

    fn save<'py>(&self, py: Python<'py>) -> Bound<'py, PyBytes> {
        let inner = &self.inner;
        let bytes = py.detach(|| inner.save());
        PyBytes::new(py, &bytes)
    }

    fn load(&mut self, py: Python<'_>, data: &[u8]) -> PyResult<()> {
        let inner = &mut self.inner;
        py.detach(|| inner.load(data)).map_err(raise::<DataError>)
    }

    fn save_file(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        let inner = &self.inner;
        py.detach(|| learned::save(&path, inner)).map_err(raise::<DataError>)
    }

    fn load_file(&mut self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        let inner = &mut self.inner;
        py.detach(|| learned::load(&path, inner)).map_err(raise::<DataError>)
    }

    #[getter]
    fn state(&self) -> ControllerState {
        ControllerState { inner: self.inner.state(), steps: self.steps }
    }

    fn resume(&mut self, state: &ControllerState) {
        self.steps = state.steps;
        self.inner.resume(&state.inner);
    }

    fn __repr__(&self) -> String {
        let (car, track) = (&self.inner.car().name, self.inner.track().name());
        format!("Controller({car:?} on {track:?}, {} laps)", self.inner.laps().len())
    }
}
