//! Options of `lmpc tour`.

use std::path::PathBuf;

use clap::Args;

const EXAMPLES: &str = "\
Examples:
  lmpc tour
  lmpc tour --fmus out/fmu --python venv/bin/python     with the FMUs in FMPy

Each command is printed before it runs, to be repeated and changed. The controller and the car meet
on a network of their own: in a network namespace where the system allows one, otherwise in a
multicast group that stays on this computer. A part whose tools are missing is passed over, and
what it needs is printed. Exit code 1 if a command failed.";

/// Options of `lmpc tour`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct TourArgs {
    /// Folder for everything the tour writes
    #[arg(long, default_value = "out/tour", value_name = "DIR")]
    pub out: PathBuf,
    /// Folder of the FMUs, as `make fmu` writes it; by default out/fmu
    #[arg(long, value_name = "DIR")]
    pub fmus: Option<PathBuf>,
    /// Interpreter that is asked for FMPy
    #[arg(long, default_value = "python3", value_name = "PROGRAM")]
    pub python: PathBuf,
    /// Only the part on the network, on the network of LCM_DEFAULT_URL
    #[arg(long, hide = true)]
    pub network_part: bool,
}
