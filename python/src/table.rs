//! Tables as dictionaries of arrays, one for each column.

use controller::learning::dataset::Lap;
use numpy::{IntoPyArray, PyFixedUnicode};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use racing::columns::{Column, ColumnValue};
use racing::words::kind_word;

use crate::arrays::{rows, state_numbers};

/// Longest word of a column.
const WORD: usize = 24;

/// The columns of a table, named as in its file.
pub(crate) fn columns<'py, T>(
    py: Python<'py>,
    columns: &[Column<T>],
    table: &[T],
) -> PyResult<Bound<'py, PyDict>> {
    let all = PyDict::new(py);
    for column in columns {
        let values: Vec<ColumnValue> = table.iter().map(column.of).collect();
        all.set_item(column.name, array(py, &values)?)?;
    }
    Ok(all)
}

/// One row of a table by the names of its columns; a value that is missing is `None`.
pub(crate) fn row<'py, T>(
    py: Python<'py>,
    columns: &[Column<T>],
    row: &T,
) -> PyResult<Bound<'py, PyDict>> {
    let all = PyDict::new(py);
    for column in columns {
        match (column.of)(row) {
            ColumnValue::Number(number) => all.set_item(column.name, number)?,
            ColumnValue::Maybe(number) => {
                all.set_item(column.name, (!number.is_nan()).then_some(number))?;
            }
            ColumnValue::Count(count) => all.set_item(column.name, count)?,
            ColumnValue::MaybeCount(count) => all.set_item(column.name, count)?,
            ColumnValue::Word(word) => all.set_item(column.name, word)?,
            ColumnValue::Switch(on) => all.set_item(column.name, on)?,
        }
    }
    Ok(all)
}

/// One column: numbers as float64, counts as int64, words as text, switches as bool. A count that there
/// may be none of is float64 with nan for none.
fn array<'py>(py: Python<'py>, values: &[ColumnValue]) -> PyResult<Bound<'py, PyAny>> {
    Ok(match values.first() {
        Some(ColumnValue::Count(_)) => {
            let counts: Vec<i64> = values.iter().map(|v| count(*v)).collect();
            counts.into_pyarray(py).into_any()
        }
        Some(ColumnValue::Word(_)) => {
            let words: Vec<PyFixedUnicode<WORD>> = values.iter().map(|v| word(*v)).collect();
            words.into_pyarray(py).into_any()
        }
        Some(ColumnValue::Switch(_)) => {
            let switches: Vec<bool> =
                values.iter().map(|v| *v == ColumnValue::Switch(true)).collect();
            switches.into_pyarray(py).into_any()
        }
        _ => {
            let numbers: Vec<f64> = values.iter().map(|v| number(*v)).collect();
            numbers.into_pyarray(py).into_any()
        }
    })
}

fn count(value: ColumnValue) -> i64 {
    match value {
        ColumnValue::Count(count) => i64::try_from(count).unwrap_or(i64::MAX),
        _ => 0,
    }
}

/// The number as it is, also if it is not finite.
fn number(value: ColumnValue) -> f64 {
    match value {
        ColumnValue::Number(number) | ColumnValue::Maybe(number) => number,
        other => other.number().unwrap_or(f64::NAN),
    }
}

fn word(value: ColumnValue) -> PyFixedUnicode<WORD> {
    let mut letters = [0_u32; WORD];
    if let ColumnValue::Word(word) = value {
        for (to, from) in letters.iter_mut().zip(word.chars()) {
            *to = u32::from(from);
        }
    }
    PyFixedUnicode(letters)
}

/// A lap that a controller has recorded.
pub(crate) fn recorded_lap<'py>(py: Python<'py>, lap: &Lap) -> PyResult<Bound<'py, PyDict>> {
    let all = PyDict::new(py);
    all.set_item("lap", lap.result.lap.get())?;
    all.set_item("kind", kind_word(lap.result.kind))?;
    all.set_item("lap_time", lap.result.lap_time)?;
    all.set_item("valid", lap.result.valid)?;
    let times: Vec<f64> = lap.samples.iter().map(|sample| sample.time).collect();
    all.set_item("time", times.into_pyarray(py))?;
    all.set_item("x", rows(py, lap.samples.iter().map(|sample| state_numbers(&sample.x)))?)?;
    all.set_item("u", rows(py, lap.samples.iter().map(|s| [s.u.a, s.u.delta]))?)?;
    Ok(all)
}
