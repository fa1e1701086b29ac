//! The library's errors as exceptions: each has the library's own message.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::{PyTypeInfo, create_exception};

create_exception!(
    racing_lmpc,
    Error,
    PyValueError,
    "Something was refused; the message names what was found and what was expected."
);
create_exception!(racing_lmpc, CampaignError, Error, "A campaign or its table that is wrong.");
create_exception!(racing_lmpc, CarError, Error, "A car that does not exist or is wrong.");
create_exception!(racing_lmpc, TrackError, Error, "A track that does not exist or is wrong.");
create_exception!(
    racing_lmpc,
    ConfigError,
    Error,
    "A key or value of a configuration that is not allowed, or one that does not fit the track."
);
create_exception!(
    racing_lmpc,
    DataError,
    Error,
    "Learned data that are damaged or of another car, track or configuration."
);
create_exception!(racing_lmpc, RaceError, Error, "A race that cannot begin or go on.");
create_exception!(racing_lmpc, OptimumError, Error, "No time-optimal lap was found.");

/// An exception of class `E` with the message of an error and of its causes.
pub(crate) fn raise<E: PyTypeInfo>(error: impl Into<anyhow::Error>) -> PyErr {
    let text = format!("{:#}", error.into());
    // Messages about options of the command line name a parameter here.
    let text = text.strip_prefix("--").unwrap_or(&text).to_owned();
    PyErr::new::<E, _>(text)
}
