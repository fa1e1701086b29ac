//! Options of `lmpc race`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use controller::Config;
use controller::config::{NominalModel, RegressionMode};

use super::FmuVehicleArgs;
use hosting::rule::TrackLimit;

const EXAMPLES: &str = "\
Examples:
  lmpc race                                  the defaults: small car, L track, 20 laps
  lmpc race --laps 50 --seeds 10             ten seeds side by side, with a summary
  lmpc race --regression nominal             the same car without learning its model
  lmpc race --plant mu=0.7,delay=0.1         less grip and late actuators
  lmpc race --set horizon.steps=12           any key of the configuration
  lmpc race --laps 10 --save today.lmpc      keep what was learned ...
  lmpc race --laps 10 --load today.lmpc      ... and drive on from there
  lmpc race --vehicle fmu:out/fmu/fmi3/lmpc-vehicle.fmu
  lmpc race --vehicle fmu:their_car.fmu --map map.toml";

const PLANT_HELP: &str = "\
Change the simulated car that the controller does not see, as NAME=VALUE,..., each name once:
  mu=X        grip of both axles
  mu_f=X mu_r=X          grip of one axle
  mass=KG     mass
  iz=KGM2     yaw inertia
  b_f=X c_f=X b_r=X c_r=X   tyre stiffness and shape factors, front and rear
  delay=S     actuation delay
  lag=S       time constant of both actuators
  noise=SIGMA sensor noise of position [m], heading [rad] and, tenfold, velocities
  disturb=SIGMA  velocity disturbance in each period [m/s]
  mu_fall=X fall_time=S  grip falls to X in mid-race, by default after 60 s";

/// Options of `lmpc race`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct RaceArgs {
    /// Car, track and settings.
    #[command(flatten)]
    pub controller: ControllerArgs,
    /// Laps to drive after the warm-up laps
    #[arg(long, default_value_t = 20, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub laps: u32,
    /// Seed of the noise in the warm-up laps and of the simulated car
    #[arg(long, default_value_t = 0, value_name = "SEED")]
    pub seed: u64,
    /// Run this many seeds, from --seed on, in parallel
    #[arg(long, value_name = "N", conflicts_with_all = ["load", "save"], value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub seeds: Option<u32>,
    /// Seeds driven at the same time; by default one for each processor
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1024))]
    pub jobs: Option<u32>,
    /// Learned data to start from; refused if car, track or configuration differ
    #[arg(long, value_name = "FILE")]
    pub load: Option<PathBuf>,
    /// Where to keep the learned data; an earlier file stays as FILE.bak
    #[arg(long, value_name = "FILE")]
    pub save: Option<PathBuf>,
    /// What is driven: the simulated car, or a vehicle FMU of any vendor
    #[arg(long, default_value = "sim", value_name = "sim|fmu:FILE")]
    pub vehicle: String,
    /// The vehicle FMU's map.
    #[command(flatten)]
    pub fmu: FmuVehicleArgs,
    /// Folder for laps.csv, trajectory.csv, timings.csv, raceline.csv of the best lap and report.html
    #[arg(long, default_value = "out/race", value_name = "DIR")]
    pub out: PathBuf,
    /// Raceline to draw beside the laps: TUM's 7 columns, or x, y and perhaps a speed
    #[arg(long, value_name = "FILE")]
    pub raceline: Option<PathBuf>,
    /// Find the time-optimal lap if none is kept, to measure the race against
    #[arg(long)]
    pub optimum: bool,
    /// Folder of kept time-optimal laps; by default that of the track's file, or out/optimum
    #[arg(long, value_name = "DIR")]
    pub store: Option<PathBuf>,
    /// What is judged.
    #[command(flatten)]
    pub limit: LimitArgs,
    /// What a car that leaves the track, spins or stands does to the race
    #[arg(long, value_enum, default_value = "stop", value_name = "WHAT")]
    pub on_failure: OnFailure,
    /// Write the optimal control problems that the structured solver does not solve to tolerance to this
    /// folder, as `lmpc bench --read-qp` reads them
    #[arg(long, value_name = "DIR", conflicts_with = "seeds")]
    pub dump_qp: Option<PathBuf>,
    /// Print the result as JSON
    #[arg(long)]
    pub json: bool,
}

/// What has to stay inside the track.
#[derive(Debug, Args)]
pub struct LimitArgs {
    /// Judge only the centre of gravity, as the paper does; the default of the preset paper
    #[arg(long)]
    pub centre_of_gravity: bool,
    /// Judge the whole body of the car; the default of the preset race
    #[arg(long, conflicts_with = "centre_of_gravity")]
    pub body: bool,
}

impl LimitArgs {
    /// The limit for a controller with this configuration.
    #[must_use]
    pub fn limit(&self, config: &Config) -> TrackLimit {
        match (self.body, self.centre_of_gravity) {
            (true, _) => TrackLimit::Body,
            (false, true) => TrackLimit::CentreOfGravity,
            (false, false) => TrackLimit::of(config),
        }
    }
}

/// Car, track and settings of a controller.
#[derive(Debug, Args)]
pub struct ControllerArgs {
    /// Configuration file; its keys override the preset it names
    #[arg(long, value_name = "FILE")]
    pub config: Option<PathBuf>,
    /// Named set of settings
    #[arg(long, value_enum, value_name = "NAME")]
    pub preset: Option<PresetName>,
    /// Car: a name or a file
    #[arg(long, default_value = "barc", value_name = "NAME|FILE")]
    pub car: String,
    /// Track: a name or a file
    #[arg(long, default_value = "l", value_name = "NAME|FILE")]
    pub track: String,
    /// What is learned: the nominal model's error, the whole velocity rows, or nothing
    #[arg(long, value_enum, value_name = "MODE")]
    pub regression: Option<RegressionName>,
    /// Equations of the nominal model
    #[arg(long, value_enum, value_name = "MODEL")]
    pub nominal: Option<NominalName>,
    /// Kernel bandwidth h of the regression
    #[arg(long, value_name = "H", allow_negative_numbers = true)]
    pub bandwidth: Option<f64>,
    /// Cost of the control rate, c_du ("CRC" in the paper)
    #[arg(long, value_name = "C", allow_negative_numbers = true)]
    pub control_rate_cost: Option<f64>,
    /// Do not fit the nominal model's grip after each lap
    #[arg(long)]
    pub no_grip_adaptation: bool,
    /// Grip the controller believes in; by default 1.2 for the small car, whose true grip is
    /// 0.9, and the car's own for every other
    #[arg(long, value_name = "MU", allow_negative_numbers = true)]
    pub nominal_mu: Option<f64>,
    /// Changes of the simulated car.
    #[arg(long, value_name = "NAME=VALUE,..", value_delimiter = ',', long_help = PLANT_HELP,
          help = "Change the simulated car, e.g. mu=0.7,delay=0.1 (more with --help)")]
    pub plant: Vec<String>,
    /// Set any key of the configuration; may be repeated, each key once
    #[arg(long = "set", value_name = "SECTION.KEY=VALUE")]
    pub set: Vec<String>,
}

/// What a failure does to a race.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum OnFailure {
    /// It ends the race.
    Stop,
    /// The car drives back to the line and races on.
    Recover,
}

/// Names of the presets.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum PresetName {
    /// As close to the paper as is known.
    Paper,
    /// The fastest that is safe.
    Race,
}

/// Names of the regression modes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum RegressionName {
    /// Error of the nominal model.
    Error,
    /// Velocity rows without a nominal model.
    Full,
    /// Nothing.
    Nominal,
}

/// Names of the nominal models.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum NominalName {
    /// Dynamic bicycle.
    Dynamic,
    /// Kinematic bicycle.
    Kinematic,
}

impl From<RegressionName> for RegressionMode {
    fn from(name: RegressionName) -> Self {
        match name {
            RegressionName::Error => Self::Error,
            RegressionName::Full => Self::Full,
            RegressionName::Nominal => Self::Nominal,
        }
    }
}

impl From<NominalName> for NominalModel {
    fn from(name: NominalName) -> Self {
        match name {
            NominalName::Dynamic => Self::Dynamic,
            NominalName::Kinematic => Self::Kinematic,
        }
    }
}
