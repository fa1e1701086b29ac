//! Options of `lmpc fmu`.

use std::path::PathBuf;

use clap::{Args, Subcommand};

/// Options of `lmpc fmu`.
#[derive(Debug, Args)]
pub struct FmuArgs {
    /// What to do.
    #[command(subcommand)]
    pub action: FmuAction,
}

/// Subcommands of `lmpc fmu`.
#[derive(Debug, Subcommand)]
pub enum FmuAction {
    /// Pack built libraries into FMUs, wired systems and the OSP structure
    Pack(PackArgs),
    /// List what is inside an FMU of either version, ours or anyone's
    Inspect(InspectArgs),
}

const PACK_EXAMPLES: &str = "\
Example:
  tools/fmu.sh && lmpc fmu pack target/fmu/lib

LIBRARIES has one folder for each platform, named by the compiler's target:
x86_64-unknown-linux-gnu, x86_64-pc-windows-gnu, aarch64-unknown-linux-gnu.";

/// Options of `lmpc fmu pack`.
#[derive(Debug, Args)]
#[command(after_help = PACK_EXAMPLES)]
pub struct PackArgs {
    /// Folder with the platforms' folders of libraries
    #[arg(value_name = "LIBRARIES")]
    pub libraries: PathBuf,
    /// Folder for the FMUs
    #[arg(long, default_value = "out/fmu", value_name = "DIR")]
    pub out: PathBuf,
}

const INSPECT_EXAMPLES: &str = "\
Examples:
  lmpc fmu inspect out/fmu/fmi3/lmpc-vehicle.fmu
  lmpc fmu inspect their_car.fmu --json | jq '.variables[] | select(.causality == \"input\").name'";

/// Options of `lmpc fmu inspect`.
#[derive(Debug, Args)]
#[command(after_help = INSPECT_EXAMPLES)]
pub struct InspectArgs {
    /// The FMU
    #[arg(value_name = "FILE")]
    pub file: PathBuf,
    /// Print everything as JSON
    #[arg(long)]
    pub json: bool,
}
