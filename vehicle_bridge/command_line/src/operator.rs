//! Options of `lmpc bridge` and `lmpc operator`.

use std::path::PathBuf;

use clap::{Args, Subcommand};

use super::{ControllerArgs, FmuVehicleArgs, NetworkArgs};

const BRIDGE_EXAMPLES: &str = "\
Examples:
  lmpc bridge                                simulated small car on the L track
  lmpc bridge --timeout-ms 60 --realtime
  lmpc bridge --vehicle fmu:their_car.fmu --map map.toml
  lmpc bridge --vehicle car --map examples/lcm/car.toml
  lmpc operator arm && lmpc operator start   in another terminal, with `lmpc serve`

Stands between controller and car, at 100 Hz: publishes CAR/STATE, CAR/ACT and HB/bridge, obeys
LMPC/CMD of the controller that was armed, and OP/CMD. docs/safety.md has states and checks.";

/// Options of `lmpc bridge`.
#[derive(Debug, Args)]
#[command(after_help = BRIDGE_EXAMPLES)]
pub struct BridgeArgs {
    /// The car, the track, and the configuration whose period commands keep.
    #[command(flatten)]
    pub controller: ControllerArgs,
    /// The network.
    #[command(flatten)]
    pub network: NetworkArgs,
    /// The car's side: the simulated car, a vehicle FMU of any vendor, or a real car that speaks its
    /// own messages, which --map names
    #[arg(long, default_value = "sim", value_name = "sim|fmu:FILE|car")]
    pub vehicle: String,
    /// The map of the vehicle FMU or of the car's messages.
    #[command(flatten)]
    pub fmu: FmuVehicleArgs,
    /// Period of a real car's state messages; by default the controller's period
    #[arg(long, value_name = "MS", value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub state_period_ms: Option<u32>,
    /// Seed of the car's noise
    #[arg(long, default_value_t = 0, value_name = "SEED")]
    pub seed: u64,
    /// Event log of what it sends and receives, also while the network is down; appended if the file exists
    #[arg(long, value_name = "LOG")]
    pub log: Option<PathBuf>,
    /// Folder of the black box, a recording that is always on; by default
    /// $STATE_DIRECTORY/blackbox, else ~/.local/state/lmpc/blackbox; `off` for none
    #[arg(long, value_name = "FOLDER")]
    pub black_box: Option<PathBuf>,
    /// Size of all files of the black box together; the oldest go
    #[arg(long, default_value_t = 512, value_name = "MB",
          value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub black_box_mb: u32,
    /// Serial port or GPIO value file that gets 1 and 0 in turn at every tick, for a hardware relay
    #[arg(long, value_name = "FILE")]
    pub relay: Option<PathBuf>,
    /// How much later than due a command or state may come
    #[arg(long, default_value_t = 100, value_name = "MS",
          value_parser = clap::value_parser!(u32).range(20..=1000))]
    pub timeout_ms: u32,
    /// Limit of a rule of doubt, in place of the one from car and track (docs/safety.md); may be repeated
    #[arg(long, value_name = "NAME=VALUE")]
    pub doubt: Vec<String>,
    /// Panic after this long in RUNNING, for the bench
    #[arg(long, hide = true, value_name = "S")]
    pub bench_panic_s: Option<f64>,
    /// Faults of the simulated car are read from this file once it is there, for the bench; it tells
    /// its true state on BENCH/TRUTH
    #[arg(long, hide = true, value_name = "FILE")]
    pub bench_car: Option<PathBuf>,
    /// Where the simulated car stands at the start, for the bench
    #[arg(long, hide = true, value_name = "E_Y,E_PSI", allow_hyphen_values = true)]
    pub bench_start: Option<String>,
    /// FIFO priority and locked memory, where the system grants them
    #[arg(long)]
    pub realtime: bool,
}

const OPERATOR_EXAMPLES: &str = "\
Examples:
  lmpc operator arm
  lmpc operator start
  lmpc operator start --deadman              drives until Ctrl-C, Ctrl-D, or this program dies
  lmpc operator speed-cap 2.5
  lmpc operator estop

Each order is sent every 10 ms, an emergency stop three times, until it is answered. Exit code 1
if it is refused, with the reason, or if nobody answers within 3 s; 3 if the bridge ends a drive
with the dead man's switch held.";

/// Options of `lmpc operator`.
#[derive(Debug, Args)]
#[command(after_help = OPERATOR_EXAMPLES)]
pub struct OperatorArgs {
    /// The order.
    #[command(subcommand)]
    pub order: OperatorOrder,
    /// The network.
    #[command(flatten)]
    pub network: NetworkArgs,
}

/// Orders.
#[derive(Debug, Subcommand)]
pub enum OperatorOrder {
    /// Grant the controller a token; the car must stand
    Arm {
        /// Also arm a moving car
        #[arg(long)]
        moving: bool,
        /// Boot id of the controller to arm, where several are live
        #[arg(long, value_name = "ID")]
        controller: Option<i64>,
    },
    /// Take the grant away; a driving car stops safely
    Disarm,
    /// Let the armed controller drive
    Start {
        /// The arm token; by default the one the bridge reports
        #[arg(long, value_name = "TOKEN")]
        token: Option<i64>,
        /// Hold the dead man's switch until Ctrl-C or the end of standard input: the car drives as
        /// long as this program runs
        #[arg(long)]
        deadman: bool,
    },
    /// Stop safely; driving again needs a new `arm`
    Stop,
    /// Emergency stop; only `reset` at standstill ends it
    Estop,
    /// End an emergency stop or a fault at standstill
    Reset,
    /// Speed not to be passed
    SpeedCap {
        /// 0 takes it away, at most 1000
        #[arg(value_name = "MPS")]
        value: f64,
    },
}
