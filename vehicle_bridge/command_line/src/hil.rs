//! Options of `lmpc doctor` and `lmpc hil`.

use std::path::PathBuf;

use clap::{Args, Subcommand};

use super::NetworkArgs;
use hil_bench::fault::EndSignal;

const DOCTOR_EXAMPLES: &str = "\
Examples:
  lmpc doctor
  lmpc doctor --url 'udpm://239.255.76.67:7667?ttl=1' --logs /data/logs
  lmpc doctor --file race.toml --file my_car.toml --fmu car.fmu --json

Each line is ok, warn (it runs, less well) or fail (it does not run), with its fix.
Exit code 1 if a line is fail, 0 else.";

/// Options of `lmpc doctor`.
#[derive(Debug, Args)]
#[command(after_help = DOCTOR_EXAMPLES)]
pub struct DoctorArgs {
    /// The network.
    #[command(flatten)]
    pub network: NetworkArgs,
    /// Folder that logs go to
    #[arg(long, default_value = ".", value_name = "DIR")]
    pub logs: PathBuf,
    /// Configuration, car, track or bench file to check; may be repeated
    #[arg(long = "file", value_name = "FILE")]
    pub files: Vec<PathBuf>,
    /// Vehicle FMU to look into; may be repeated
    #[arg(long = "fmu", value_name = "FILE")]
    pub fmus: Vec<PathBuf>,
    /// Print the findings as JSON
    #[arg(long)]
    pub json: bool,
}

const HIL_EXAMPLES: &str = "\
Examples:
  lmpc hil run bench/quick.toml
  lmpc hil run bench/faults.toml --repeats 100 --jobs 16
  lmpc hil run bench/faults.toml --scenario 'command loss' --repeats 1000 --seed 7

Runs every scenario in real time in a network namespace of its own: nothing leaves this computer.
Writes verdict.html (prints on A4), verdict.json and junit.xml. Exit code 0 if every run of every scenario met its limits,
1 else; the last line names what failed. `lmpc check BENCH.toml` finds mistakes in a bench file.";

/// Options of `lmpc hil`.
#[derive(Debug, Args)]
pub struct HilArgs {
    /// What to do.
    #[command(subcommand)]
    pub action: HilAction,
}

/// What `lmpc hil` does.
#[derive(Debug, Subcommand)]
pub enum HilAction {
    /// Run a bench: drive, inject faults, judge
    Run(HilRunArgs),
    /// A program of the shipped benches: prints what it measures, `name value` line by line
    #[command(hide = true)]
    Probe(ProbeArgs),
    /// Command a car along the centre line, as the bench does, until Ctrl-C
    #[command(hide = true)]
    Drive(HilDriveArgs),
}

/// Options of `lmpc hil drive`: the bench's source of commands as a program that can be killed.
#[derive(Debug, Args)]
pub struct HilDriveArgs {
    /// The network.
    #[command(flatten)]
    pub network: NetworkArgs,
    /// Car: built-in name or TOML file
    #[arg(long, default_value = "barc", value_name = "CAR")]
    pub car: String,
    /// Track: built-in name or file
    #[arg(long, default_value = "l", value_name = "TRACK")]
    pub track: String,
    /// Speed
    #[arg(long, default_value_t = 2.0, value_name = "MPS")]
    pub speed: f64,
}

/// Options of `lmpc hil probe`.
#[derive(Debug, Args)]
pub struct ProbeArgs {
    /// Which.
    #[command(subcommand)]
    pub probe: ProbeProgram,
    /// Folder for its files
    #[arg(long, global = true, default_value = ".", value_name = "DIR")]
    pub dir: PathBuf,
    /// Seed of what is drawn
    #[arg(long, global = true, default_value_t = 0, value_name = "SEED")]
    pub seed: u64,
}

/// Programs of the shipped benches.
#[derive(Debug, Subcommand)]
pub enum ProbeProgram {
    /// Kill a program that saves learned data, again and again, and look at the files it leaves
    SaverKills {
        /// Kills
        #[arg(long, default_value_t = 10, value_name = "N")]
        kills: u32,
    },
    /// Save learned data until killed
    Saver,
    /// Record a drive, damage the log, replay it
    DamagedLog {
        /// The network to drive on
        #[command(flatten)]
        network: NetworkArgs,
    },
    /// Drive with `serve --log`, replay that log
    LoggedDrive {
        /// The network to drive on
        #[command(flatten)]
        network: NetworkArgs,
    },
    /// Send control sequences in every text, look at what `top` and `operator` write
    HostileText {
        /// The network to send on
        #[command(flatten)]
        network: NetworkArgs,
    },
    /// End `vehicle car` by a signal while a car with messages of its own drives
    SignalledCar {
        /// The network to drive on
        #[command(flatten)]
        network: NetworkArgs,
        /// The signal: int, term, hup or quit
        #[arg(long, value_name = "SIGNAL")]
        signal: EndSignal,
    },
}

/// Options of `lmpc hil run`.
#[derive(Debug, Args)]
#[command(after_help = HIL_EXAMPLES)]
pub struct HilRunArgs {
    /// Bench file
    #[arg(value_name = "BENCH.toml")]
    pub bench: PathBuf,
    /// Only scenarios whose name contains this; may be repeated
    #[arg(long = "scenario", value_name = "NAME")]
    pub scenarios: Vec<String>,
    /// Runs of each scenario, instead of the file's
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub repeats: Option<u32>,
    /// Seed of the first run, instead of the file's
    #[arg(long, value_name = "SEED")]
    pub seed: Option<u64>,
    /// Runs at the same time
    #[arg(long, default_value_t = 4, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=256))]
    pub jobs: u32,
    /// Folder for verdict.html, verdict.json and junit.xml
    #[arg(long, default_value = "out/hil", value_name = "DIR")]
    pub out: PathBuf,
    /// Who tests, for the verdict; else a line to fill in by hand
    #[arg(long, value_name = "NAME")]
    pub tester: Option<String>,
    /// The network is already one of its own
    #[arg(long, hide = true)]
    pub isolated: bool,
}
