//! Command line of `lmpc`: the definitions that parsing, help and completions share.

mod bench;
mod car;
mod config;
mod export;
mod fmu;
mod hil;
mod key;
mod learn;
mod network;
mod operator;
mod optimum;
mod race;
mod shell;
mod study;
mod top;
mod tour;
mod track;
mod vehicle;
mod view;

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueEnum};

pub use bench::BenchArgs;
pub use car::{CarAction, CarFileArgs, NewCarArgs, RandomCarArgs, ShowCarArgs};
pub use config::ConfigArgs;
pub use export::ExportArgs;
pub use fmu::{FmuAction, FmuArgs, InspectArgs, PackArgs};
pub use hil::{DoctorArgs, HilAction, HilArgs, HilDriveArgs, HilRunArgs, ProbeArgs, ProbeProgram};
pub use key::{KeyAction, KeyArgs};
pub use learn::LearnArgs;
pub use network::{
    CarArgs, NetworkArgs, RecordArgs, ReplayArgs, ServeArgs, SimArgs, VehicleArgs, VehicleCommand,
};
pub use operator::{BridgeArgs, OperatorArgs, OperatorOrder};
pub use optimum::OptimumArgs;
pub use race::{ControllerArgs, LimitArgs, OnFailure, RaceArgs};
pub use shell::{CompletionsArgs, ManArgs};
pub use study::{
    CampaignArgs, MergeArgs, PaperStudyArgs, ReportArgs, Study, StudyArgs, TemplateName,
    TracksStudyArgs,
};
pub use top::TopArgs;
pub use tour::TourArgs;
pub use track::{ConvertArgs, ImportArgs, RandomArgs, ShowArgs, TrackAction, TrackArgs};
pub use vehicle::{FmuCarArgs, FmuVehicleArgs, InspectVehicleArgs, TryVehicleArgs};
pub use view::ViewArgs;

/// First line of the help and of the manual page.
const ABOUT: &str = "`lmpc`, the command line of the racing LMPC";

const EXIT_CODES: &str = "\
Exit codes:
  0  done
  1  failed: a file is missing or wrong, an output could not be written
  2  the command line is wrong
  3  ran, but degraded: the car failed, left the track, or fell back; a log was damaged

Results go to standard output, everything else to standard error.";

/// Racing LMPC: a controller that learns its car and drives faster lap after lap.
#[derive(Debug, Parser)]
#[command(name = "lmpc", version, about = ABOUT, after_help = EXIT_CODES, arg_required_else_help = true)]
pub struct Cli {
    /// When to use colour; NO_COLOR is respected
    #[arg(long, global = true, value_enum, default_value_t = Color::Auto, value_name = "WHEN")]
    pub color: Color,
    /// Say nothing on standard error but errors
    #[arg(long, short, global = true)]
    pub quiet: bool,
    /// What to do.
    #[command(subcommand)]
    pub command: CliCommand,
}

/// Subcommands.
#[derive(Debug, Subcommand)]
pub enum CliCommand {
    /// Run the first things one does, in a minute, and show the command of each
    Tour(TourArgs),
    /// Race a simulated car faster than real time: it learns lap after lap
    Race(Box<RaceArgs>),
    /// Race many cars, tracks and seeds, or repeat a study of the paper
    Study(Box<StudyArgs>),
    /// Find the time-optimal lap of a car on a track
    Optimum(OptimumArgs),
    /// Learn from laps that a person or another program drove
    Learn(Box<LearnArgs>),
    /// Serve the controller on an LCM network
    Serve(Box<ServeArgs>),
    /// Put a vehicle on an LCM network
    Vehicle(VehicleArgs),
    /// Check and limit the commands between controller and car
    Bridge(Box<BridgeArgs>),
    /// Send an operator command to bridge and controller
    Operator(OperatorArgs),
    /// See the whole network at a terminal: car, states, rates, ages, step times
    Top(TopArgs),
    /// Show a drive on a page in the browser: map, speed, inputs, tyres, laps, states
    View(Box<ViewArgs>),
    /// Record every message on an LCM network in a log
    Record(RecordArgs),
    /// Drive a log's states again and compare the commands
    Replay(Box<ReplayArgs>),
    /// Write a log as CSV tables or as MCAP for Foxglove
    Export(ExportArgs),
    /// Measure how long a control step takes on this computer
    Bench(BenchArgs),
    /// Show, convert or make tracks: what an import changes, before and after
    Track(TrackArgs),
    /// Begin a car file, or show what a car is read as
    Car(CarFileArgs),
    /// Print every setting of the controller: value, unit and where it comes from
    Config(Box<ConfigArgs>),
    /// Find every problem of configuration, track, car and map files at once
    Check(CheckArgs),
    /// Find what this computer lacks to drive a car, each with its fix
    Doctor(DoctorArgs),
    /// Run a bench with injected faults and write its verdict
    Hil(HilArgs),
    /// Make the key by which programs on a network know each other
    Key(KeyArgs),
    /// Pack FMUs, or look into one
    Fmu(FmuArgs),
    /// Print a completion script for a shell
    Completions(CompletionsArgs),
    /// Write the manual pages
    Man(ManArgs),
}

impl CliCommand {
    /// The network the command joins, if it joins one.
    #[must_use]
    pub fn network(&self) -> Option<&NetworkArgs> {
        match self {
            Self::Serve(args) => Some(&args.network),
            Self::Bridge(args) => Some(&args.network),
            Self::Operator(args) => Some(&args.network),
            Self::Top(args) => Some(&args.network),
            Self::View(args) => args.joined(),
            Self::Record(args) => Some(&args.network),
            Self::Vehicle(args) => match &args.vehicle {
                VehicleCommand::Sim(args) => Some(&args.network),
                VehicleCommand::Fmu(args) => Some(&args.car.network),
                VehicleCommand::Car(args) => Some(&args.network),
                VehicleCommand::Inspect(_) | VehicleCommand::Try(_) => None,
            },
            Self::Hil(args) => match &args.action {
                HilAction::Drive(args) => Some(&args.network),
                HilAction::Probe(args) => match &args.probe {
                    ProbeProgram::DamagedLog { network }
                    | ProbeProgram::LoggedDrive { network }
                    | ProbeProgram::HostileText { network }
                    | ProbeProgram::SignalledCar { network, .. } => Some(network),
                    ProbeProgram::SaverKills { .. } | ProbeProgram::Saver => None,
                },
                HilAction::Run(_) => None,
            },
            _ => None,
        }
    }
}

const CHECK_EXAMPLES: &str = "\
Examples:
  lmpc check race.toml
  lmpc check race.toml my_car.toml oval.csv --json

The kind of a file is recognised from its content: configuration, car, track, map of a car's
messages or of a vehicle FMU in TOML, track in CSV or TTL. A map is checked with the FMU or `.lcm`
files it names. A car or configuration without problems is followed by the settings that the
controller derives from it; `lmpc config` prints all. Exit code 1 if any file has a problem.";

/// Options of `lmpc check`.
#[derive(Debug, Args)]
#[command(after_help = CHECK_EXAMPLES)]
pub struct CheckArgs {
    /// Files to check
    #[arg(required = true, value_name = "FILE")]
    pub files: Vec<PathBuf>,
    /// Car that settings are derived for; by default barc, and for a car file the car in it
    #[arg(long, value_name = "NAME|FILE")]
    pub car: Option<String>,
    /// Track that settings are derived for; by default the first that ships with lmpc and fits the
    /// car
    #[arg(long, value_name = "NAME|FILE")]
    pub track: Option<String>,
    /// Print problems and settings as JSON
    #[arg(long)]
    pub json: bool,
}

/// When to use colour.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Color {
    /// On a terminal, unless NO_COLOR is set.
    Auto,
    /// Always.
    Always,
    /// Never.
    Never,
}

impl Color {
    /// Makes this the choice of both standard streams.
    pub fn apply(self) {
        let choice = match self {
            Self::Auto => anstream::ColorChoice::Auto,
            Self::Always => anstream::ColorChoice::Always,
            Self::Never => anstream::ColorChoice::Never,
        };
        choice.write_global();
    }
}
