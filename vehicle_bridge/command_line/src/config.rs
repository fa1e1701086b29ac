//! Options of `lmpc config`.

use clap::Args;

use super::ControllerArgs;

const EXAMPLES: &str = "\
Examples:
  lmpc config --car my_car.toml --track my_track.csv    every key, its value and where it comes from
  lmpc config --car kart limits warm_up                 two sections of it
  lmpc config --car kart cost.slip horizon --json       one key and a section, as JSON
  lmpc config --preset paper --toml > paper.toml        a configuration file with every key
  lmpc config --schema > lmpc.schema.json               for editors: names, ranges and meanings

It takes the options of `lmpc race` that belong to the controller and prints what a race with them
uses. A value comes from the preset, from the car, from car and track, from the file of --config, or
from the command line. A file of --toml fixes every value; a key that is removed from it follows from
the car again.

An editor with a language server for TOML checks and completes a file that begins with the line
#:schema ./lmpc.schema.json";

/// Options of `lmpc config`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct ConfigArgs {
    /// Sections or keys to print, as SECTION or SECTION.KEY; by default all
    #[arg(value_name = "KEY")]
    pub keys: Vec<String>,
    /// Car, track and settings.
    #[command(flatten)]
    pub controller: ControllerArgs,
    /// Print a configuration file with the meaning of each key as comments
    #[arg(long, conflicts_with = "json")]
    pub toml: bool,
    /// Print key, value, unit, origin, range and meaning as JSON
    #[arg(long)]
    pub json: bool,
    /// Print a JSON schema of configuration files for editors
    #[arg(long, conflicts_with_all = ["toml", "json", "keys"])]
    pub schema: bool,
}
