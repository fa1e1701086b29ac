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

Comments mark what is uncertain. A map names, for each of our quantities, the variable of
the FMU, its unit, and a scale (-1 where theirs is positive to the right) and an offset:
ours = scale * unit * theirs + offset.";

const TRY_EXAMPLES: &str = "\
Examples:
  lmpc vehicle inspect their_car.fmu > map.toml
  lmpc vehicle try their_car.fmu --map map.toml --car barc
  lmpc vehicle try their_car.fmu --map map.toml --car barc --out tried.toml

Gives throttle for 2 s, rolls for 0.5 s, and steers to the left for 1.5 s, gently. The positions x and
y are the reference: speed, yaw rate and heading must agree with them, and throttle and steering with
the car of --car. Prints for each quantity the ratio found, with delay and lag of both inputs and how
often the measurements change. Exit code 1 if the map has to change and --out was not given.";

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

/// Options of `lmpc vehicle try`.
#[derive(Debug, Args)]
#[command(after_help = TRY_EXAMPLES)]
pub struct TryVehicleArgs {
    /// The vehicle FMU
    #[arg(value_name = "FILE")]
    pub file: PathBuf,
    /// Its map, as `lmpc vehicle inspect` proposes it
    #[arg(long, value_name = "FILE")]
    pub map: PathBuf,
    /// Library to load before the vehicle FMU's own; libpython is found for a PythonFMU
    #[arg(long, value_name = "LIBRARY")]
    pub preload: Option<PathBuf>,
    /// Car it stands for: built-in name or TOML file; its wheelbase and limits count
    #[arg(long, default_value = "barc", value_name = "CAR")]
    pub car: String,
    /// Track, for FMUs that want one: built-in name or file
    #[arg(long, default_value = "l", value_name = "TRACK")]
    pub track: String,
    /// Time between two measurements
    #[arg(long, default_value_t = 10, value_name = "MS", value_parser = clap::value_parser!(u32).range(1..=100))]
    pub period_ms: u32,
    /// Where to write the corrected map
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
}
