//! `Plant`.

use std::sync::Arc;

use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString};
use racing::change_plant;
use vehicle_model::{Outline, Plant as Inner, PlantParams, PlantState as InnerState, State};

use crate::arrays::{from_global, from_input, from_state, input, shown, state};
use crate::car::Car;
use crate::errors::{CarError, Error, raise};
use crate::track::Track;

/// The simulated car: own integrator, slow and late actuators, noisy sensors.
///
/// A car on a track.
///
/// Args:
///     car: the true car.
///     track: the track.
///     x: state (6,) at the start; by default at rest on the line.
///     changes: as in ``lmpc race --plant``, e.g. ``{"mu": 0.7, "delay": 0.1}``.
///     seed: of sensor noise and disturbances.
///     substep: longest step of the integration [s]; 0.01 by default.
#[pyclass(module = "racing_lmpc")]
pub(crate) struct Plant {
    inner: Inner,
    outline: Outline,
    track: Py<Track>,
    car: Py<Car>,
}

/// All that changes while a plant runs.
#[pyclass(frozen, module = "racing_lmpc")]
pub(crate) struct PlantState(InnerState);

/// What a simulated car is made of: a car, and changes of it as in `lmpc race --plant`.
fn params(car: &Car, changes: Option<&Bound<'_, PyAny>>) -> PyResult<PlantParams> {
    let mut plant = PlantParams::new(car.inner.clone());
    change_plant(&mut plant, &texts(changes)?).map_err(raise::<CarError>)?;
    Ok(plant)
}

/// Changes as `NAME=VALUE`, from a dictionary or a text.
pub(crate) fn texts(changes: Option<&Bound<'_, PyAny>>) -> PyResult<Vec<String>> {
    let Some(changes) = changes else { return Ok(Vec::new()) };
    if let Ok(text) = changes.cast::<PyString>() {
        let text = text.to_string();
        return Ok(text
            .split(',')
            .filter(|part| !part.trim().is_empty())
            .map(str::to_owned)
            .collect());
    }
    let Ok(table) = changes.cast::<PyDict>() else {
        let text = format!("plant: found {}, expected a dict or NAME=VALUE,...", shown(changes));
        return Err(PyErr::new::<Error, _>(text));
    };
    table
        .iter()
        .map(|(name, value)| {
            let number: f64 = value.extract().map_err(|_| {
                let text = format!("plant {name}: found {}, expected a number", shown(&value));
                PyErr::new::<Error, _>(text)
            })?;
            Ok(format!("{name}={number:?}"))
        })
        .collect()
}

#[pymethods]
impl Plant {
    #[new]
    #[pyo3(signature = (car, track, x = None, changes = None, seed = 0, substep = None))]
    fn new(
        car: &Bound<'_, PyAny>,
        track: &Bound<'_, PyAny>,
        x: Option<&Bound<'_, PyAny>>,
        changes: Option<&Bound<'_, PyAny>>,
        seed: u64,
        substep: Option<f64>,
    ) -> PyResult<Self> {
        let py = car.py();
        let (car, track) = (Car::of(car)?, Track::of(track)?);
        let start = x.map(state).transpose()?.unwrap_or_default();
        let changed = params(&car, changes)?;
        let params = PlantParams { seed, substep: substep.unwrap_or(changed.substep), ..changed };
        let outline = Outline::new(&params.car);
        let inner = Inner::new(params, Arc::clone(&track.get().inner), start);
        let inner = inner.map_err(raise::<CarError>)?;
        let given = car.given.clone();
        let car = Py::new(py, Car { inner: inner.params().car.clone(), given })?;
        Ok(Self { inner, outline, track, car })
    }

    /// Drives with an input (2,) for `dt` [s].
    fn apply(&mut self, py: Python<'_>, u: &Bound<'_, PyAny>, dt: f64) -> PyResult<()> {
        let u = input(u)?;
        let inner = &mut self.inner;
        py.detach(|| inner.apply(u, dt));
        Ok(())
    }

    /// What the sensors say now: a state (6,), s in [0, L). Noise is drawn with each call.
    fn measure<'py>(&mut self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        from_state(py, &self.inner.measure())
    }

    /// The true state (6,), s in [0, L).
    #[getter]
    fn truth<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        from_state(py, &self.inner.truth())
    }

    /// The true global state (6,).
    #[getter]
    fn pose<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        from_global(py, &self.inner.global())
    }

    /// The input (2,) that acted last, after delay, lag and limits.
    #[getter]
    fn applied<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        from_input(py, &self.inner.applied())
    }

    /// Share of each axle's peak force in use, front and rear [-].
    #[getter]
    fn utilisation(&self) -> (f64, f64) {
        let [front, rear] = self.inner.utilisation();
        (front, rear)
    }

    /// How far the body is beyond an edge; negative inside [m].
    #[getter]
    fn overhang(&self) -> f64 {
        self.outline.overhang(self.inner.track(), &self.inner.truth())
    }

    /// Time since the start [s].
    #[getter]
    fn time(&self) -> f64 {
        self.inner.time()
    }

    /// Way along the track, growing over the laps [m].
    #[getter]
    fn progress(&self) -> f64 {
        self.inner.progress()
    }

    /// Times that the line was crossed.
    #[getter]
    fn lap(&self) -> i64 {
        self.inner.lap()
    }

    /// The true car, with the changes.
    #[getter]
    fn car(&self, py: Python<'_>) -> Py<Car> {
        self.car.clone_ref(py)
    }

    /// The track.
    #[getter]
    fn track(&self, py: Python<'_>) -> Py<Track> {
        self.track.clone_ref(py)
    }

    /// Back to time 0 in a state (6,), with fresh actuators and the noise of `seed` or of the
    /// seed before.
    #[pyo3(signature = (x = None, seed = None))]
    fn reset(&mut self, x: Option<&Bound<'_, PyAny>>, seed: Option<u64>) -> PyResult<()> {
        let start = x.map(state).transpose()?.unwrap_or_else(State::default);
        let seed = seed.unwrap_or(self.inner.params().seed);
        let params = PlantParams { seed, ..self.inner.params().clone() };
        let inner = Inner::new(params, Arc::clone(self.inner.track()), start);
        self.inner = inner.map_err(raise::<CarError>)?;
        Ok(())
    }

    /// All that changes, to go back to with `restore`.
    #[getter]
    fn state(&self) -> PlantState {
        PlantState(self.inner.state().clone())
    }

    /// Goes on from a state of a plant with the same parameters.
    fn restore(&mut self, state: &PlantState) {
        self.inner.restore(state.0.clone());
    }

    fn __repr__(&self) -> String {
        let (car, track) = (&self.inner.params().car.name, self.inner.track().name());
        format!("Plant({car:?} on {track:?}, {:.3} s)", self.inner.time())
    }
}
