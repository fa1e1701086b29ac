//! What is inside a controller, as arrays: `Plan`, `LearnedModel`, `SafeSet`.

use controller::{Affine, Controller, LearnedModel as InnerModel};
use numpy::{IntoPyArray, PyArray1, PyArray2, PyArrayMethods};
use pyo3::prelude::*;
use vehicle_model::{Input, State};

use crate::arrays::{rows, state_numbers};

/// The plan of a step.
#[pyclass(frozen, module = "racing_lmpc")]
pub(crate) struct Plan {
    /// States (N + 1, 6); (0, 6) before learning begins.
    #[pyo3(get)]
    x: Py<PyArray2<f64>>,
    /// Inputs (N, 2).
    #[pyo3(get)]
    u: Py<PyArray2<f64>>,
}

/// The latest plan of a controller.
pub(crate) fn plan(py: Python<'_>, controller: &Controller) -> PyResult<Plan> {
    let plan = controller.plan();
    Ok(Plan {
        x: rows(py, plan.x.iter().map(state_numbers))?.unbind(),
        u: rows(py, plan.u.iter().map(|u| [u.a, u.delta]))?.unbind(),
    })
}

/// The safe set of a step's problem: recorded states near the end of the horizon.
#[pyclass(frozen, module = "racing_lmpc")]
pub(crate) struct SafeSet {
    /// States (n, 6).
    #[pyo3(get)]
    points: Py<PyArray2<f64>>,
    /// Periods each of them took to the line, least first subtracted (n,) [steps].
    #[pyo3(get)]
    cost_to_go: Py<PyArray1<f64>>,
    /// Weights lambda in the solution (n,).
    #[pyo3(get)]
    weights: Py<PyArray1<f64>>,
}

/// The safe set of a controller's latest problem.
pub(crate) fn safe_set(py: Python<'_>, controller: &Controller) -> PyResult<SafeSet> {
    let set = controller.safe_set();
    let points = set.points.iter().map(|p| [p[0], p[1], p[2], p[3], p[4], p[5]]);
    Ok(SafeSet {
        points: rows(py, points)?.unbind(),
        cost_to_go: PyArray1::from_slice(py, &set.cost_to_go).unbind(),
        weights: PyArray1::from_slice(py, controller.safe_set_weights()).unbind(),
    })
}

/// The model around a point, x_plus = A x + B u + C, in its parts: each A (6, 6), B (6, 2),
/// C (6,).
#[pyclass(frozen, module = "racing_lmpc")]
pub(crate) struct LearnedModel(InnerModel);

/// The learned model of a controller around a point.
pub(crate) fn learned_model(controller: &Controller, x: &State, u: &Input) -> LearnedModel {
    LearnedModel(controller.learned_model(x, u))
}

type Matrices<'py> =
    (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<f64>>, Bound<'py, PyArray1<f64>>);

/// A (6, 6), B (6, 2), C (6,).
fn matrices<'py>(py: Python<'py>, model: &Affine) -> PyResult<Matrices<'py>> {
    // nalgebra stores columns, numpy rows.
    let a: Vec<f64> = model.a.transpose().iter().copied().collect();
    let b: Vec<f64> = model.b.transpose().iter().copied().collect();
    let c = PyArray1::from_slice(py, model.c.as_slice());
    Ok((a.into_pyarray(py).reshape([6, 6])?, b.into_pyarray(py).reshape([6, 2])?, c))
}

#[pymethods]
impl LearnedModel {
    /// Linearised nominal model A^f, B^f, C^f.
    #[getter]
    fn nominal<'py>(&self, py: Python<'py>) -> PyResult<Matrices<'py>> {
        matrices(py, &self.0.nominal)
    }

    /// Regressed error A^e, B^e, C^e.
    #[getter]
    fn error<'py>(&self, py: Python<'py>) -> PyResult<Matrices<'py>> {
        matrices(py, &self.0.error)
    }

    /// Their sum.
    #[getter]
    fn sum<'py>(&self, py: Python<'py>) -> PyResult<Matrices<'py>> {
        matrices(py, &self.0.sum())
    }

    /// Sum of the kernel weights behind the error.
    #[getter]
    fn support(&self) -> f64 {
        self.0.support
    }
}
