//! `lmpc`: the racing LMPC from the command line.

use std::process::ExitCode;

use clap::Parser;
use vehicle_bridge::{cli, commands};

fn main() -> ExitCode {
    let args = cli::Cli::parse();
    args.color.apply();
    match commands::run(args) {
        Ok(outcome) => outcome.exit_code(),
        Err(error) => {
            commands::talk(&format!("{}: {error:#}", commands::paint_error("error")));
            ExitCode::FAILURE
        }
    }
}
