//! What the subcommands do. Each returns an outcome; only `main` turns it into an exit code.

mod bench;
mod campaign;
mod car;
mod check;
mod config;
mod config_schema;
mod doctor;
mod export;
mod fmu;
mod folders;
mod hil;
mod key;
mod learn;
mod network;
mod operator;
mod optimum;
mod race;
mod seeds;
mod setup;
mod shell;
mod study;
mod study_report;
mod study_tracks;
mod top;
mod tour;
mod track;
mod vehicle;
mod view;
#[cfg(feature = "foxglove")]
mod view_foxglove;
#[cfg(not(feature = "foxglove"))]
#[path = "view_without_foxglove.rs"]
mod view_foxglove;
mod view_orders;
mod view_source;
mod welcome;

use anyhow::Result;

pub use welcome::welcome;

use command_line::{Cli, CliCommand, VehicleArgs, VehicleCommand};
use terminal::Talk;

/// How a command ended that did not fail.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outcome {
    /// All well.
    Done,
    /// It did its work and found problems in what it was given.
    Problems,
    /// It ran, but the car failed, left the track, or fell back.
    Degraded,
}

impl Outcome {
    /// Exit code of the process.
    #[must_use]
    pub fn code(self) -> u8 {
        match self {
            Self::Done => 0,
            Self::Problems => 1,
            Self::Degraded => 3,
        }
    }
}

/// Runs a command line.
///
/// # Errors
/// What the user has to put right, in words.
pub fn run(cli: Cli) -> Result<Outcome> {
    // Before anything is printed and before any thread: the program may start again.
    #[cfg(feature = "liblcm")]
    if let Some(network) = cli.command.network() {
        transport::liblcm::enter_environment(&network.url())?;
    }
    let talk = Talk { quiet: cli.quiet };
    match cli.command {
        CliCommand::Tour(args) => tour::run(&args, talk),
        CliCommand::Race(args) => race::run(&args, talk),
        CliCommand::Study(args) => study::run(&args, talk),
        CliCommand::Optimum(args) => optimum::run(&args, talk),
        CliCommand::Learn(args) => learn::run(&args, talk),
        CliCommand::Serve(args) => network::serve(&args, talk),
        CliCommand::Vehicle(VehicleArgs { vehicle }) => match vehicle {
            VehicleCommand::Sim(args) => network::sim(&args, None, talk),
            VehicleCommand::Fmu(args) => {
                network::sim(&args.car, Some((&args.file, &args.fmu)), talk)
            }
            VehicleCommand::Car(args) => network::car(&args, talk),
            VehicleCommand::Inspect(args) => vehicle::inspect(&args),
            VehicleCommand::Try(args) => vehicle::try_out(&args),
        },
        CliCommand::Bridge(args) => operator::bridge(&args, talk),
        CliCommand::Operator(args) => operator::operator(&args, talk),
        CliCommand::Top(args) => top::run(&args, talk),
        CliCommand::View(args) => view::run(&args, talk),
        CliCommand::Record(args) => network::record(&args, talk),
        CliCommand::Replay(args) => network::replay(&args),
        CliCommand::Export(args) => export::run(&args, talk),
        CliCommand::Bench(args) => bench::run(&args, talk),
        CliCommand::Track(args) => track::run(&args),
        CliCommand::Car(args) => car::run(&args),
        CliCommand::Config(args) => config::run(&args),
        CliCommand::Check(args) => check::run(&args),
        CliCommand::Doctor(args) => doctor::run(&args),
        CliCommand::Hil(args) => hil::run(&args, talk),
        CliCommand::Key(args) => key::run(&args, talk),
        CliCommand::Fmu(args) => fmu::run(&args, talk),
        CliCommand::Completions(args) => shell::completions(&args),
        CliCommand::Man(args) => shell::man(&args),
    }
}
