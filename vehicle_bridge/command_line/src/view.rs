//! Options of `lmpc view`.

use std::net::{IpAddr, Ipv4Addr};
use std::path::PathBuf;

use clap::Args;

use super::{ControllerArgs, NetworkArgs};

const EXAMPLES: &str = "\
Examples:
  lmpc view                                  what goes on in the network, at http://127.0.0.1:8711
  lmpc view --log drive.log --speed 2        a recorded drive, twice as fast
  lmpc view --race --track monza.csv --car my_car.toml    a race as it runs
  lmpc view --operator --key ~/lmpc.key      with buttons for the operator
  lmpc view --foxglove                       also to the Foxglove app, at ws://127.0.0.1:8765

Without --operator the page only shows. It is served on this computer alone unless --listen names
another address. --car and --track give the outline of a car with a file of its own, the use of its
tyres and its time-optimal lap; cars and tracks that ship with lmpc are found by themselves.";

/// Options of `lmpc view`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct ViewArgs {
    /// The car and track to look for on the network; with --race what is driven.
    #[command(flatten)]
    pub controller: ControllerArgs,
    /// The network.
    #[command(flatten)]
    pub network: NetworkArgs,
    /// Port of the page; 0 takes any that is free
    #[arg(long, default_value_t = 8711, value_name = "PORT")]
    pub port: u16,
    /// Address of the page; others than the loopback show the drive to whoever reaches it
    #[arg(long, default_value_t = IpAddr::V4(Ipv4Addr::LOCALHOST), value_name = "IP",
          conflicts_with = "operator")]
    pub listen: IpAddr,
    /// Serve the topics of `lmpc export --mcap` to the Foxglove app too, at this port of --listen [8765]; 0
    /// takes any that is free. Needs a program built with `--features foxglove`
    #[arg(long, num_args = 0..=1, default_missing_value = "8765", value_name = "PORT")]
    pub foxglove: Option<u16>,
    /// Show a log of `lmpc record` or lcm-logger instead of the network
    #[arg(long, value_name = "LOG", conflicts_with_all = ["race", "operator"])]
    pub log: Option<PathBuf>,
    /// Show a race of the simulated car, driven here
    #[arg(long, conflicts_with = "operator")]
    pub race: bool,
    /// How fast a log or a race runs; 1 is real time
    #[arg(long, default_value_t = 1.0, value_name = "X", value_parser = speed)]
    pub speed: f64,
    /// Begin a log there; what lies before is shown at once
    #[arg(long, default_value_t = 0.0, value_name = "S", requires = "log", value_parser = seconds)]
    pub at: f64,
    /// Learning laps of a race
    #[arg(long, default_value_t = 20, value_name = "N", requires = "race",
          value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub laps: u32,
    /// Seed of a race
    #[arg(long, default_value_t = 0, value_name = "SEED", requires = "race")]
    pub seed: u64,
    /// Folder of kept time-optimal laps; by default that of the track's file, or out/optimum
    #[arg(long, value_name = "DIR")]
    pub store: Option<PathBuf>,
    /// Buttons to arm, start, stop and limit the car; needs the network's key
    #[arg(long)]
    pub operator: bool,
}

impl ViewArgs {
    /// The network it joins, unless it shows a log or a race.
    #[must_use]
    pub fn joined(&self) -> Option<&NetworkArgs> {
        (self.log.is_none() && !self.race).then_some(&self.network)
    }
}

fn seconds(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(seconds) if (0.0..=1e7).contains(&seconds) => Ok(seconds),
        _ => Err("expected 0 or more seconds".to_owned()),
    }
}

fn speed(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(speed) if (0.01..=1000.0).contains(&speed) => Ok(speed),
        _ => Err("expected 0.01 to 1000".to_owned()),
    }
}
