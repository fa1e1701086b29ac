//! What can go wrong with an FMU and its map.

use std::path::PathBuf;

/// Why an FMU cannot be the vehicle.
#[derive(Debug, thiserror::Error)]
pub enum FmuError {
    /// The file is no FMU.
    #[error(transparent)]
    Inspect(#[from] fmu_core::PackError),
    /// It cannot be loaded.
    #[error("{}: {reason}", path.display())]
    Load {
        /// The FMU.
        path: PathBuf,
        /// Why.
        reason: String,
    },
    /// It has no variable of this name.
    #[error("{}: variable `{name}`: {reason} (`lmpc fmu inspect` lists them)", path.display())]
    NoVariable {
        /// The FMU.
        path: PathBuf,
        /// What was asked for.
        name: String,
        /// What is wrong with it.
        reason: String,
    },
    /// A value does not fit its variable.
    #[error("{}: {name} is of type {kind}, found {found}", path.display())]
    Misfit {
        /// The FMU.
        path: PathBuf,
        /// The variable.
        name: String,
        /// Its type.
        kind: String,
        /// The value.
        found: String,
    },
    /// It answered a call with an error.
    #[error("{}: {call} was refused: {reason}", path.display())]
    Refused {
        /// The FMU.
        path: PathBuf,
        /// The call.
        call: String,
        /// Status and message.
        reason: String,
    },
    /// The map is wrong.
    #[error("map: {0}")]
    Map(String),
}
