//! Options of `lmpc doctor` and `lmpc hil`.

use std::path::PathBuf;

use clap::Args;

use super::NetworkArgs;

const DOCTOR_EXAMPLES: &str = "\
Examples:
  lmpc doctor
  lmpc doctor --url 'udpm://239.255.76.67:7667?ttl=1' --logs /data/logs
  lmpc doctor --file race.toml --file my_car.toml --fmu car.fmu --json

Each line is ok, warn (it runs, less well) or fail (it does not run), with its fix.
Exit code 1 if a line is fail, 0 else.";

/// Options of `lmpc doctor`.
#[derive(Debug, Args)]
#[command(after_help = DOCTOR_EXAMPLES)]
pub struct DoctorArgs {
    /// The network.
    #[command(flatten)]
    pub network: NetworkArgs,
    /// Folder that logs go to
    #[arg(long, default_value = ".", value_name = "DIR")]
    pub logs: PathBuf,
    /// Configuration, car, track or bench file to check; may be repeated
    #[arg(long = "file", value_name = "FILE")]
    pub files: Vec<PathBuf>,
    /// Vehicle FMU to look into; may be repeated
    #[arg(long = "fmu", value_name = "FILE")]
    pub fmus: Vec<PathBuf>,
    /// Print the findings as JSON
    #[arg(long)]
    pub json: bool,
}
