//! Between Python's arrays and the library's vectors.

use numpy::{
    AllowTypeChange, IntoPyArray, PyArray1, PyArray2, PyArrayDyn, PyArrayLikeDyn, PyArrayMethods,
};
use pyo3::prelude::*;
use vehicle_model::{GlobalState, Input, State};

use crate::errors::Error;

/// `N` numbers of an array or a sequence; an array of float64 is read where it lies.
pub(crate) fn numbers<const N: usize>(
    value: &Bound<'_, PyAny>,
    what: &str,
    order: &str,
) -> PyResult<[f64; N]> {
    let refuse = |found: String| {
        let text = format!("{what}: found {found}, expected {N} numbers {order}");
        PyErr::new::<Error, _>(text)
    };
    let mut out = [0.0; N];
    if let Ok(array) = value.cast::<PyArray1<f64>>() {
        let array = array.try_readonly()?;
        let view = array.as_array();
        if view.len() != N {
            return Err(refuse(format!("{} numbers", view.len())));
        }
        for (to, from) in out.iter_mut().zip(view) {
            *to = *from;
        }
        return Ok(out);
    }
    let list: Vec<f64> = value.extract().map_err(|_| refuse(shown(value)))?;
    if list.len() != N {
        return Err(refuse(format!("{} numbers", list.len())));
    }
    out.copy_from_slice(&list);
    Ok(out)
}

/// A value as in a message.
pub(crate) fn shown(value: &Bound<'_, PyAny>) -> String {
    let text = value.repr().map_or_else(|_| "something".to_owned(), |repr| repr.to_string());
    let short: String = text.chars().take(60).collect();
    if short.len() < text.len() { format!("{short}...") } else { short }
}

/// A state [v_x, v_y, omega_z, e_psi, s, e_y].
pub(crate) fn state(value: &Bound<'_, PyAny>) -> PyResult<State> {
    let [v_x, v_y, omega_z, e_psi, s, e_y] =
        numbers(value, "state", "[v_x, v_y, omega_z, e_psi, s, e_y]")?;
    Ok(State { v_x, v_y, omega_z, e_psi, s, e_y })
}

/// A global state [x, y, psi, v_x, v_y, omega_z].
pub(crate) fn global(value: &Bound<'_, PyAny>) -> PyResult<GlobalState> {
    let [x, y, psi, v_x, v_y, omega_z] =
        numbers(value, "global state", "[x, y, psi, v_x, v_y, omega_z]")?;
    Ok(GlobalState { x, y, psi, v_x, v_y, omega_z })
}

/// An input [a, delta].
pub(crate) fn input(value: &Bound<'_, PyAny>) -> PyResult<Input> {
    let [a, delta] = numbers(value, "input", "[a, delta]")?;
    Ok(Input { a, delta })
}

/// A state as an array (6,).
pub(crate) fn from_state<'py>(py: Python<'py>, x: &State) -> Bound<'py, PyArray1<f64>> {
    PyArray1::from_slice(py, &state_numbers(x))
}

/// The numbers of a state in their order.
pub(crate) fn state_numbers(x: &State) -> [f64; 6] {
    [x.v_x, x.v_y, x.omega_z, x.e_psi, x.s, x.e_y]
}

/// A global state as an array (6,).
pub(crate) fn from_global<'py>(py: Python<'py>, g: &GlobalState) -> Bound<'py, PyArray1<f64>> {
    PyArray1::from_slice(py, &[g.x, g.y, g.psi, g.v_x, g.v_y, g.omega_z])
}

/// An input as an array (2,).
pub(crate) fn from_input<'py>(py: Python<'py>, u: &Input) -> Bound<'py, PyArray1<f64>> {
    PyArray1::from_slice(py, &[u.a, u.delta])
}

/// Rows of `N` numbers as an array (n, N).
pub(crate) fn rows<'py, const N: usize>(
    py: Python<'py>,
    rows: impl IntoIterator<Item = [f64; N]>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let flat: Vec<f64> = rows.into_iter().flatten().collect();
    let count = flat.len() / N;
    flat.into_pyarray(py).reshape([count, N])
}

/// A number or an array of any shape, as a function's argument.
pub(crate) type Places<'py> = PyArrayLikeDyn<'py, f64, AllowTypeChange>;

/// A function at every place of an array; the result has its shape.
pub(crate) fn map<'py>(
    py: Python<'py>,
    places: &Places<'py>,
    of: impl Fn(f64) -> f64,
) -> Bound<'py, PyArrayDyn<f64>> {
    places.as_array().mapv(of).into_pyarray(py)
}

/// Points (x, y) at every place of an array: its shape with 2 behind it.
pub(crate) fn points<'py>(
    py: Python<'py>,
    places: &Places<'py>,
    of: impl Fn(f64) -> (f64, f64),
) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
    let view = places.as_array();
    let mut shape = view.shape().to_vec();
    shape.push(2);
    let flat: Vec<f64> = view.iter().map(|s| of(*s)).flat_map(|(x, y)| [x, y]).collect();
    flat.into_pyarray(py).reshape(shape)
}

/// A list of numbers, or one number for each of `count` rows.
pub(crate) fn column(
    value: &Bound<'_, PyAny>,
    what: &str,
    count: Option<usize>,
) -> PyResult<Vec<f64>> {
    let refuse = |found: String, expected: String| {
        PyErr::new::<Error, _>(format!("{what}: found {found}, expected {expected}"))
    };
    if let (Some(count), Ok(one)) = (count, value.extract::<f64>()) {
        return Ok(vec![one; count]);
    }
    let list: Vec<f64> = match value.extract::<Places<'_>>() {
        Ok(array) if array.as_array().ndim() == 1 => array.as_array().iter().copied().collect(),
        Ok(array) => {
            let dimensions = array.as_array().ndim();
            return Err(refuse(format!("{dimensions} dimensions"), "one".to_owned()));
        }
        Err(_) => {
            let expected = "a one-dimensional array of numbers".to_owned();
            return Err(refuse(shown(value), expected));
        }
    };
    match count {
        Some(count) if list.len() != count => {
            Err(refuse(format!("{} numbers", list.len()), format!("{count}, as many as x has")))
        }
        _ => Ok(list),
    }
}
