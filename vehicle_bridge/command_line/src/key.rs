//! Options of `lmpc key`.

use std::path::PathBuf;

use clap::{Args, Subcommand};

const EXAMPLES: &str = "\
Examples:
  lmpc key new ~/lmpc.key                    then copy it to each computer, by a way you trust
  lmpc key id ~/lmpc.key                     the same on each computer that has the same key
  lmpc bridge --key ~/lmpc.key               and so lmpc serve, operator, top, vehicle

docs/threats.md says who can do what with and without a key.";

/// Options of `lmpc key`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct KeyArgs {
    /// What to do.
    #[command(subcommand)]
    pub action: KeyAction,
}

/// What to do with a key.
#[derive(Debug, Subcommand)]
pub enum KeyAction {
    /// Make a key and its file, which only you can read
    New {
        /// The file; it must not be there yet
        #[arg(value_name = "FILE")]
        file: PathBuf,
    },
    /// Print eight digits that differ between keys and tell nothing of them
    Id {
        /// The key's file
        #[arg(value_name = "FILE")]
        file: PathBuf,
    },
}
