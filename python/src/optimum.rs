//! `optimum`: the time-optimal lap.

use std::sync::Arc;

use ::optimum::{Optimum as Inner, Options};
use numpy::{IntoPyArray, PyArray1, PyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use racing::nominal;

use crate::arrays::{rows, state_numbers};
use crate::car::Car;
use crate::config::Config;
use crate::errors::{ConfigError, OptimumError, raise};
use crate::track::Track;

/// A time-optimal lap: what no driver and no controller can beat.
#[pyclass(frozen, module = "racing_lmpc")]
pub(crate) struct Optimum {
    inner: Inner,
    /// Distance that the centre of gravity keeps from either edge [m].
    #[pyo3(get)]
    margin: f64,
}

/// Finds the time-optimal lap of a car on a track, confirmed by the simulated car.
///
/// Releases the interpreter's lock.
///
/// Args:
///     car: the car.
///     track: the track.
///     margin: distance from the edges [m]; by default that of a race.
///     starts: starts that are tried, 1 to 4.
///
/// Raises:
///     OptimumError: no lap was found.
#[pyfunction]
#[pyo3(signature = (car, track, margin = None, starts = 3))]
pub(crate) fn optimum(
    py: Python<'_>,
    car: &Bound<'_, PyAny>,
    track: &Bound<'_, PyAny>,
    margin: Option<f64>,
    starts: usize,
) -> PyResult<Optimum> {
    let (car, track) = (Car::of(car)?, Track::of(track)?);
    let shared = Arc::clone(&track.get().inner);
    let margin = match margin {
        Some(margin) => margin,
        // That of a race, which follows from the car that its controller believes in.
        None => {
            let believed = nominal(&car.given, car.inner.clone(), None);
            let believed = believed.map_err(raise::<OptimumError>)?;
            let config = Config::default().layers.build_for(&believed, &shared);
            config.map_err(raise::<ConfigError>)?.limits.lane_margin
        }
    };
    let options = Options { starts, ..Options::new(margin) };
    let found = py.detach(|| ::optimum::solve(&car.inner, &shared, &options));
    Ok(Optimum { inner: found.map_err(raise::<OptimumError>)?, margin })
}

#[pymethods]
impl Optimum {
    /// Lap time [s].
    #[getter]
    fn lap_time(&self) -> f64 {
        self.inner.lap_time
    }

    /// Time since the line at each point (n,) [s].
    #[getter]
    fn time<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        let times: Vec<f64> = self.inner.points.iter().map(|point| point.time).collect();
        times.into_pyarray(py)
    }

    /// States (n, 6); the first is repeated at the end, one lap later.
    #[getter]
    fn x<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        rows(py, self.inner.points.iter().map(|point| state_numbers(&point.x)))
    }

    /// Inputs that act (n, 2).
    #[getter]
    fn u<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        rows(py, self.inner.points.iter().map(|point| [point.u.a, point.u.delta]))
    }

    /// How good it is: deviation of the plant, optimality, mesh, starts.
    #[getter]
    fn quality<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let quality = &self.inner.quality;
        let all = PyDict::new(py);
        all.set_item("defect", PyArray1::from_slice(py, &quality.defect))?;
        all.set_item("scaled_defect", quality.scaled_defect)?;
        all.set_item("optimality", quality.optimality)?;
        all.set_item("intervals", quality.intervals)?;
        all.set_item("starts", quality.starts)?;
        all.set_item("converged", quality.converged)?;
        all.set_item("slowest_start", quality.slowest_start)?;
        Ok(all)
    }

    fn __repr__(&self) -> String {
        format!("Optimum({:.3} s)", self.inner.lap_time)
    }
}
