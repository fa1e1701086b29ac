//! What can go wrong while a car is built.

use crate::params::ParamProblem;
use crate::state::State;
use crate::unknown_key::explain_unknown_key;

/// Why a car or plant could not be built.
#[derive(Debug, thiserror::Error)]
pub enum ModelError {
    /// No car of this name ships with the product.
    #[error("unknown car '{found}', expected one of {known}")]
    UnknownCar {
        /// Name asked for.
        found: String,
        /// Names that exist.
        known: String,
    },
    /// The text is no car file.
    #[error("car file: {}", explain_unknown_key(&.0.to_string()))]
    CarSyntax(toml::de::Error),
    /// Values out of range, all of them.
    #[error("car file: {}", join(.0))]
    CarInvalid(Vec<ParamProblem>),
    /// Values of a simulated car out of range, all of them.
    #[error("simulated car: {}", join(.0))]
    PlantInvalid(Vec<ParamProblem>),
    /// A state that should start a simulation holds NaN or infinity.
    #[error("initial state: found {0:?}, expected finite numbers")]
    NotFinite(State),
}

fn join(problems: &[ParamProblem]) -> String {
    problems.iter().map(ToString::to_string).collect::<Vec<_>>().join("; ")
}
