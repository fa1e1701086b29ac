//! Options of `lmpc optimum`.

use std::path::PathBuf;

use clap::Args;

const EXAMPLES: &str = "\
Examples:
  lmpc optimum                               the small car on the L track
  lmpc optimum --car iac --track road_course
  lmpc optimum --car my_car.toml --track circuit.csv --margin 1.2
  lmpc race --optimum                        race, with every lap measured against it

The lap obeys the car's own equations and every limit of its file: input stops and rates, actuator
lag, engine and brakes. The centre of gravity keeps the margin from both edges. Inputs may change
at any time, while a controller holds them over its period. The result is a local optimum: several
starts are tried, and the best is kept.

Writes optimum.csv, raceline.csv (TUM format: s_m; x_m; y_m; psi_rad; kappa_radpm; vx_mps; ax_mps2;
psi_rad is the course of the line, 0 along +x) and optimum.html. The lap is also kept as
optimum-FINGERPRINT.toml beside the track's file, or in out/optimum for a track that ships with
lmpc; `lmpc race` and its report find it there.";

/// Options of `lmpc optimum`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct OptimumArgs {
    /// Car: a name or a file
    #[arg(long, default_value = "barc", value_name = "NAME|FILE")]
    pub car: String,
    /// Track: a name or a file
    #[arg(long, default_value = "l", value_name = "NAME|FILE")]
    pub track: String,
    /// Distance the centre of gravity keeps from both edges; by default the lane margin the
    /// controller keeps with this car
    #[arg(long, value_name = "METRES", allow_negative_numbers = true)]
    pub margin: Option<f64>,
    /// Configuration file whose lane margin is kept
    #[arg(long, value_name = "FILE", conflicts_with = "margin")]
    pub config: Option<PathBuf>,
    /// Different starts, 1 to 4
    #[arg(long, default_value_t = 3, value_name = "N", value_parser = clap::value_parser!(u8).range(1..=4))]
    pub starts: u8,
    /// Folder for optimum.csv, raceline.csv and optimum.html
    #[arg(long, default_value = "out/optimum", value_name = "DIR")]
    pub out: PathBuf,
    /// Folder in which the lap is kept for races and studies
    #[arg(long, value_name = "DIR")]
    pub store: Option<PathBuf>,
    /// Print the result as JSON
    #[arg(long)]
    pub json: bool,
}
