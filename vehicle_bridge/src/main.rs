//! `lmpc`: the racing LMPC from the command line.

use std::process::ExitCode;

use clap::Parser;
use vehicle_bridge::cli::Cli;
use vehicle_bridge::settings::Usage;
use vehicle_bridge::{commands, console};

/// Exit code for a wrong command line, as clap's own.
const USAGE: u8 = 2;

fn main() -> ExitCode {
    let args = Cli::parse();
    args.color.apply();
    match commands::run(args) {
        Ok(outcome) => ExitCode::from(outcome.code()),
        // Whoever reads our results has read enough (`lmpc race | head`).
        Err(error) if is_broken_pipe(&error) => ExitCode::SUCCESS,
        Err(error) => {
            console::complain(&format!("{error:#}"));
            if error.is::<Usage>() { ExitCode::from(USAGE) } else { ExitCode::FAILURE }
        }
    }
}

fn is_broken_pipe(error: &anyhow::Error) -> bool {
    let io = error.downcast_ref::<std::io::Error>();
    io.is_some_and(|e| e.kind() == std::io::ErrorKind::BrokenPipe)
}
