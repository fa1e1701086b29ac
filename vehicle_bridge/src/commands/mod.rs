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

use command_line::{Cli, Command, Vehicle, VehicleArgs};
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
        Command::Tour(args) => tour::run(&args, talk),
        Command::Race(args) => race::run(&args, talk),
        Command::Study(args) => study::run(&args, talk),
        Command::Optimum(args) => optimum::run(&args, talk),
        Command::Learn(args) => learn::run(&args, talk),
        Command::Serve(args) => network::serve(&args, talk),
        Command::Vehicle(VehicleArgs { vehicle }) => match vehicle {
            Vehicle::Sim(args) => network::sim(&args, None, talk),
            Vehicle::Fmu(args) => network::sim(&args.car, Some((&args.file, &args.fmu)), talk),
            Vehicle::Car(args) => network::car(&args, talk),
            Vehicle::Inspect(args) => vehicle::inspect(&args),
            Vehicle::Try(args) => vehicle::try_out(&args),
        },
        Command::Bridge(args) => operator::bridge(&args, talk),
        Command::Operator(args) => operator::operator(&args, talk),
        Command::Top(args) => top::run(&args, talk),
        Command::View(args) => view::run(&args, talk),
        Command::Record(args) => network::record(&args, talk),
        Command::Replay(args) => network::replay(&args),
        Command::Export(args) => export::run(&args, talk),
        Command::Bench(args) => bench::run(&args, talk),
        Command::Track(args) => track::run(&args),
        Command::Car(args) => car::run(&args),
        Command::Config(args) => config::run(&args),
        Command::Check(args) => check::run(&args),
        Command::Doctor(args) => doctor::run(&args),
        Command::Hil(args) => hil::run(&args, talk),
        Command::Key(args) => key::run(&args, talk),
        Command::Fmu(args) => fmu::run(&args, talk),
        Command::Completions(args) => shell::completions(&args),
        Command::Man(args) => shell::man(&args),
    }
}
