//! Options of `lmpc serve` and `lmpc vehicle`.

use std::path::PathBuf;

use clap::{Args, Subcommand};

use super::{ControllerArgs, FmuCarArgs, InspectVehicleArgs, LimitArgs, TryVehicleArgs};
use services::deadline_monitor::Overrun;
use transport::DEFAULT_URL;

const SERVE_EXAMPLES: &str = "\
Examples:
  lmpc serve                                 small car, L track, this host's network
  lmpc serve --learned l.lmpc                keep what is learned, and find it again
  lmpc serve --log drive.log                 and a log of what it sends and receives
  lmpc serve --dry-run                       compute, but never command the car
  lmpc serve --url 'udpm://239.255.76.67:7667?ttl=1' --realtime

Answers each CAR/STATE with one LMPC/CMD and reports on LMPC/TELEM, LMPC/LAP and HB/lmpc.
Obeys START, STOP, ESTOP, ESTOP_RESET and SET_SPEED_CAP on OP/CMD. Ctrl-C commands the car to
stop, then ends. LCM has no authentication: give a real car a network of its own.";

const SIM_EXAMPLES: &str = "\
Examples:
  lmpc vehicle sim                           in real time, until Ctrl-C
  lmpc vehicle sim --laps 8 --plant mu=0.8
  lmpc vehicle sim --lock-step --steps 500   time waits for each command

Publishes CAR/STATE and CAR/ACT, obeys LMPC/CMD. Without a valid command it brakes. Both
programs must be given the same car, track and configuration.";

/// Options of every program on the network.
#[derive(Debug, Args)]
pub struct NetworkArgs {
    /// LCM network; by default that of LCM_DEFAULT_URL, else LCM's usual group on this host
    #[arg(long, value_name = "URL", global = true)]
    pub url: Option<String>,
    /// Sign what is sent with the key in this file, and obey only what is signed with it; by default
    /// that of LMPC_KEY, else none. `lmpc key new FILE` makes one
    #[arg(long, value_name = "FILE", global = true)]
    pub key: Option<PathBuf>,
}

impl NetworkArgs {
    /// The network chosen here, by the environment, or by default.
    #[must_use]
    pub fn url(&self) -> String {
        let environment = || std::env::var("LCM_DEFAULT_URL").ok();
        let chosen = self.url.clone().or_else(environment);
        chosen.filter(|url| !url.is_empty()).unwrap_or_else(|| DEFAULT_URL.to_owned())
    }

    /// The file of the key chosen here or by the environment.
    #[must_use]
    pub fn key(&self) -> Option<PathBuf> {
        let environment = || std::env::var_os("LMPC_KEY").map(PathBuf::from);
        self.key.clone().or_else(environment).filter(|path| !path.as_os_str().is_empty())
    }
}

/// Options of `lmpc serve`.
#[derive(Debug, Args)]
#[command(after_help = SERVE_EXAMPLES)]
pub struct ServeArgs {
    /// Car, track and settings.
    #[command(flatten)]
    pub controller: ControllerArgs,
    /// The network.
    #[command(flatten)]
    pub network: NetworkArgs,
    /// Seed of the noise in the warm-up laps
    #[arg(long, default_value_t = 0, value_name = "SEED")]
    pub seed: u64,
    /// Learned data: loaded if there, saved after every lap
    #[arg(long, value_name = "FILE")]
    pub learned: Option<PathBuf>,
    /// Event log of what it sends and receives, for `lmpc replay`; appended if the file exists
    #[arg(long, value_name = "LOG")]
    pub log: Option<PathBuf>,
    /// From step FIRST on, COUNT steps take MS longer: what a slow solver would do, for the bench
    #[arg(long, hide = true, value_name = "FIRST,COUNT,MS")]
    pub bench_overrun: Option<Overrun>,
    /// Publish what would be commanded on LMPC/CMD_DRY, and never a command
    #[arg(long)]
    pub dry_run: bool,
    /// Do not drive before the operator's START
    #[arg(long)]
    pub wait_for_start: bool,
    /// Drive back to the line after a spin, an excursion or a standstill
    #[arg(long)]
    pub recover: bool,
    /// FIFO priority and locked memory, where the system grants them
    #[arg(long)]
    pub realtime: bool,
    /// Time a command may be used; by default two and a half periods
    #[arg(long, value_name = "MS", value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub valid_for_ms: Option<u32>,
}

/// Options of `lmpc vehicle`.
#[derive(Debug, Args)]
pub struct VehicleArgs {
    /// Which vehicle.
    #[command(subcommand)]
    pub vehicle: VehicleCommand,
}

/// Vehicles.
#[derive(Debug, Subcommand)]
pub enum VehicleCommand {
    /// A simulated car
    Sim(Box<SimArgs>),
    /// A real car that speaks its own messages
    Car(CarArgs),
    /// A vehicle-model FMU of any vendor, FMI 2.0 or 3.0 co-simulation
    Fmu(Box<FmuCarArgs>),
    /// Propose a map for a vehicle FMU, as TOML
    Inspect(InspectVehicleArgs),
    /// Drive a vehicle FMU in small steps and correct the senses and units of its map
    Try(TryVehicleArgs),
}

/// Options of `lmpc vehicle sim`.
#[derive(Debug, Args)]
#[command(after_help = SIM_EXAMPLES)]
pub struct SimArgs {
    /// The car, the track, and the configuration whose period it keeps.
    #[command(flatten)]
    pub controller: ControllerArgs,
    /// The network.
    #[command(flatten)]
    pub network: NetworkArgs,
    /// Seed of the car's noise
    #[arg(long, default_value_t = 0, value_name = "SEED")]
    pub seed: u64,
    /// What is judged.
    #[command(flatten)]
    pub limit: LimitArgs,
    /// Time stands still until each state is answered
    #[arg(long)]
    pub lock_step: bool,
    /// End after this many periods
    #[arg(long, value_name = "N")]
    pub steps: Option<u64>,
    /// End after this many laps
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub laps: Option<u32>,
    /// Speed on the line at the start; by default 0, in lock-step that of the warm-up laps
    #[arg(long, value_name = "MPS")]
    pub start_speed: Option<f64>,
    /// FIFO priority and locked memory, where the system grants them
    #[arg(long)]
    pub realtime: bool,
}

const CAR_EXAMPLES: &str = "\
Examples:
  lmpc check examples/lcm/car.toml           is the map right?
  lmpc vehicle car --map examples/lcm/car.toml
  lmpc vehicle car --map car.toml --url 'udpm://239.255.76.67:7667?ttl=1' --realtime

The map names the car's channels, types (.lcm files) and fields, with scale, offset, frame and
time base. Publishes CAR/STATE (quality 1) and CAR/ACT, obeys LMPC/CMD. When the commands stop,
and at Ctrl-C, the car is sent the map's `stop` values.";

/// Options of `lmpc vehicle car`.
#[derive(Debug, Args)]
#[command(after_help = CAR_EXAMPLES)]
pub struct CarArgs {
    /// The map between the car's messages and ours
    #[arg(long, value_name = "FILE")]
    pub map: PathBuf,
    /// Car whose limits a command must keep: built-in name or TOML file
    #[arg(long, default_value = "barc", value_name = "CAR")]
    pub car: String,
    /// The network.
    #[command(flatten)]
    pub network: NetworkArgs,
    /// FIFO priority and locked memory, where the system grants them
    #[arg(long)]
    pub realtime: bool,
}

const REPLAY_EXAMPLES: &str = "\
Examples:
  lmpc replay drive.log
  lmpc replay drive.log --load l.lmpc        a drive that began with learned data

Car, track, configuration and seed must be those of the drive. The operator's orders are
read from the log (OP/CMD, OP/ACK). Exit code 1 if a command comes out otherwise.";

/// Options of `lmpc record`.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  lmpc record drive.log                      until Ctrl-C")]
pub struct RecordArgs {
    /// Log to write; it must not be there yet
    #[arg(value_name = "LOG")]
    pub log: PathBuf,
    /// The network.
    #[command(flatten)]
    pub network: NetworkArgs,
}

/// Options of `lmpc replay`.
#[derive(Debug, Args)]
#[command(after_help = REPLAY_EXAMPLES)]
pub struct ReplayArgs {
    /// Log of `lmpc record` or lcm-logger
    #[arg(value_name = "LOG")]
    pub log: PathBuf,
    /// Car, track and settings of the recorded drive.
    #[command(flatten)]
    pub controller: ControllerArgs,
    /// Seed of the noise in the warm-up laps
    #[arg(long, default_value_t = 0, value_name = "SEED")]
    pub seed: u64,
    /// The drive was one of `lmpc serve --recover`
    #[arg(long)]
    pub recover: bool,
    /// Learned data the drive began with
    #[arg(long, value_name = "FILE")]
    pub load: Option<PathBuf>,
}
