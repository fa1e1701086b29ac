//! Options of vehicle FMUs.

use std::path::PathBuf;

use clap::Args;

use super::SimArgs;

const CAR_EXAMPLES: &str = "\
Examples:
  lmpc vehicle fmu out/fmu/fmi2/lmpc-vehicle.fmu               our own needs no map
  lmpc vehicle inspect their_car.fmu > map.toml
  lmpc vehicle fmu their_car.fmu --map map.toml --laps 8       in real time
  lmpc vehicle fmu their_car.fmu --map map.toml --lock-step

Publishes CAR/STATE and CAR/ACT and obeys LMPC/CMD, as `lmpc vehicle sim` does. --car names the
car whose limits hold.";

const INSPECT_EXAMPLES: &str = "\
Example:
  lmpc vehicle inspect their_car.fmu > map.toml && lmpc check map.toml

What is uncertain is said in comments. A map names, for each of our quantities, the variable of
the FMU, its unit, and a scale (-1 where theirs is positive to the right) and an offset:
ours = scale * unit * theirs + offset.";

/// How a vehicle FMU is connected.
#[derive(Debug, Clone, Args)]
pub struct FmuVehicleArgs {
    /// Which variable of the vehicle FMU is which quantity; our own FMU needs none. With `car`: which
    /// field of its messages is which
    #[arg(long, value_name = "FILE")]
    pub map: Option<PathBuf>,
    /// Library to load before the vehicle FMU's own; libpython is found for a PythonFMU
    #[arg(long, value_name = "LIBRARY")]
    pub preload: Option<PathBuf>,
}

/// Options of `lmpc vehicle fmu`.
#[derive(Debug, Args)]
#[command(after_help = CAR_EXAMPLES)]
pub struct FmuCarArgs {
    /// The vehicle FMU
    #[arg(value_name = "FILE")]
    pub file: PathBuf,
    /// Its map.
    #[command(flatten)]
    pub fmu: FmuVehicleArgs,
    /// Options of a car on the network.
    #[command(flatten)]
    pub car: SimArgs,
}

/// Options of `lmpc vehicle inspect`.
#[derive(Debug, Args)]
#[command(after_help = INSPECT_EXAMPLES)]
pub struct InspectVehicleArgs {
    /// The vehicle FMU
    #[arg(value_name = "FILE")]
    pub file: PathBuf,
}
