//! `lmpc`: the racing LMPC from the command line.

use std::io::Write as _;

use clap::Parser;
use command_line::Cli;
use hosting::settings::Usage;
use vehicle_bridge::commands;

/// Exit code for everything that goes wrong but the command line.
const FAILURE: u8 = 1;
/// Exit code for a wrong command line, as clap's own.
const USAGE: u8 = 2;

fn main() -> ! {
    if std::env::args_os().len() == 1 {
        // A closed output: nobody reads it.
        let _ = commands::welcome();
        signal_hook::low_level::exit(0)
    }
    let args = Cli::parse();
    args.color.apply();
    let code = match commands::run(args) {
        Ok(outcome) => outcome.code(),
        // Whoever reads our results has read enough (`lmpc race | head`).
        Err(error) if is_broken_pipe(&error) => 0,
        Err(error) => {
            terminal::complain(&format!("{error:#}"));
            if error.is::<Usage>() { USAGE } else { FAILURE }
        }
    };
    // All is done, and nobody is left to tell if the rest cannot be written.
    let _ = std::io::stdout().flush();
    // At once: an FMU's library may have code that runs at a process's ordinary end, and PythonFMU's
    // reads freed memory there.
    signal_hook::low_level::exit(code.into())
}

fn is_broken_pipe(error: &anyhow::Error) -> bool {
    let io = error.downcast_ref::<std::io::Error>();
    io.is_some_and(|e| e.kind() == std::io::ErrorKind::BrokenPipe)
}
