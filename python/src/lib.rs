//! The extension module of the Python package `racing_lmpc`: controller, simulated car, race and
//! time-optimal lap behind Python classes. What a user reads stands in `racing_lmpc/_native.pyi`.

mod arrays;
mod campaign;
mod car;
mod config;
mod controller;
mod errors;
mod optimum;
mod plan;
mod plant;
mod race;
mod rule;
mod status;
mod table;
mod track;

use pyo3::prelude::*;

/// The module as Python imports it.
#[pymodule]
mod _native {
    #[pymodule_export]
    use super::campaign::{Campaign, CampaignTable};
    #[pymodule_export]
    use super::car::Car;
    #[pymodule_export]
    use super::config::Config;
    #[pymodule_export]
    use super::controller::{Controller, ControllerState};
    #[pymodule_export]
    use super::errors::{
        CampaignError, CarError, ConfigError, DataError, Error, OptimumError, RaceError, TrackError,
    };
    #[pymodule_export]
    use super::optimum::{Optimum, optimum};
    #[pymodule_export]
    use super::plan::{LearnedModel, Plan, SafeSet};
    #[pymodule_export]
    use super::plant::{Plant, PlantState};
    #[pymodule_export]
    use super::race::{Race, race};
    #[pymodule_export]
    use super::rule::FailureRule;
    #[pymodule_export]
    use super::status::{LapResult, Status};
    #[pymodule_export]
    use super::track::Track;

    use pyo3::prelude::*;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
