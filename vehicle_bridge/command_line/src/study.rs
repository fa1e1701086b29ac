//! Options of `lmpc study`.

use std::path::PathBuf;

use clap::{Args, Subcommand, ValueEnum};
use studies::campaign::Shard;
use vehicle_model::Track;

use super::race::{LimitArgs, PresetName};

const EXAMPLES: &str = "\
Examples:
  lmpc study crc --seeds 10          Table I: error and full regression over five rate costs
  lmpc study bandwidth --seeds 10    the figure over the bandwidth h, kinematic nominal model
  lmpc study hardware                Table II, with a plant that differs from the model
  lmpc study tracks --car iac --track circuits/ --seeds 5    which tracks a car stays on
  lmpc study grip.toml                                       a campaign from a file
  lmpc study grip.toml --shard 2/10                          a tenth of it
  lmpc study grip.toml --slurm > job.sh                      all of it on a Slurm cluster
  lmpc study merge out/study-grip/shard-* --out out/study-grip
  lmpc study report out/study-grip                           figures of it

A campaign writes one line a run into runs.csv and goes on where it stopped when it is started again.
Exit code 3 if more runs failed than its file allows, or one is beyond a limit.";

const PAPER: &str = "\
A study that is interrupted goes on where it stopped when it is started again with the same
options. It writes runs.csv, laps.csv and report.html.";

const TRACKS: &str = "\
Examples:
  lmpc study tracks --car barc kart --track l road_course --seeds 5
  lmpc study tracks --car iac my_car.toml --track circuits/ --plant none --plant noise=0.001
  lmpc study tracks --car iac --track circuits/ --optimum optima.csv --out out/iac
  lmpc study tracks --car iac --track circuits/ --out out/iac --resume
  lmpc study tracks --car barc iac kart --random 200 --seeds 1

Drives every car on every track with every plant and every seed. A run fails when any part of the
car's body leaves the track, when the car spins, turns round or stands still, or when a lap takes
too long. Each finished run is one line of runs.csv at once; --resume runs what is missing there.
Without it an earlier runs.csv becomes runs.before.csv.
Failed runs leave their last steps in failures/. matrix.html shows all cells, failed ones first.
Exit code 3 if any run failed.";

/// Options of `lmpc study`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES, args_conflicts_with_subcommands = true, arg_required_else_help = true)]
pub struct StudyArgs {
    /// A study that ships with lmpc.
    #[command(subcommand)]
    pub study: Option<Study>,
    /// A campaign from a file.
    #[command(flatten)]
    pub campaign: CampaignArgs,
}

/// Options of a campaign from a file.
#[derive(Debug, Args)]
pub struct CampaignArgs {
    /// File of the campaign (docs/howto/campaign.md)
    #[arg(value_name = "FILE", required = true)]
    pub file: Option<PathBuf>,
    /// Run a part only: the I-th of N
    #[arg(long, value_name = "I/N", value_parser = shard)]
    pub shard: Option<Shard>,
    /// Print the script of a Slurm array that runs all shards
    #[arg(long, conflicts_with_all = ["shard", "fresh", "list", "json"])]
    pub slurm: bool,
    /// Jobs of the array; by default one for each 50 runs, at most 1000
    #[arg(long, value_name = "N", requires = "slurm", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub shards: Option<u32>,
    /// Runs at the same time; by default one for each processor
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1024))]
    pub jobs: Option<u32>,
    /// Run everything again; the earlier table stays as runs.before.csv
    #[arg(long)]
    pub fresh: bool,
    /// List the runs without running them
    #[arg(long)]
    pub list: bool,
    /// Folder for the results; by default out/study-NAME. A shard has a folder of its own in it
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Print the result as JSON
    #[arg(long)]
    pub json: bool,
}

/// Options of `lmpc study merge`.
#[derive(Debug, Args)]
pub struct MergeArgs {
    /// Folders of shards
    #[arg(required = true, value_name = "DIR")]
    pub folders: Vec<PathBuf>,
    /// Folder for the merged table
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// Print the result as JSON
    #[arg(long)]
    pub json: bool,
}

const REPORT: &str = "\
Examples:
  lmpc study report out/study-grip                        best laps and failures along every axis
  lmpc study report out/study-grip --x plant.mu --y best_lap_s overhang_m_max
  lmpc study report out/study-grip --x plant.mu --y best_lap_s --by seed --across car
  lmpc study report out/study-crc --template crc          the paper's figures
  lmpc study report out/iac/runs.csv --x track --y ratio --by plant

Reads the runs.csv of any study. Shows the median and the range of the runs that did not fail, and
above them a cross with the number of those that did. Words stand side by side, numbers at their
place; an axis of many numbers shows every run and medians of ranges. Beside the columns there are
--y failed, the share of the runs that failed, and over --x lap --y lap_time_s and driving, the share
of the runs that finished the lap.";

/// Options of `lmpc study report`.
#[derive(Debug, Args)]
pub struct ReportArgs {
    /// Folder of a study, or its table
    #[arg(value_name = "DIR|FILE")]
    pub runs: PathBuf,
    /// Axis to the right: a column, or lap
    #[arg(long, value_name = "COLUMN", requires = "y")]
    pub x: Option<String>,
    /// What is measured, a figure for each: columns, failed, or over lap lap_time_s and driving
    #[arg(long, num_args = 1.., value_name = "COLUMN", requires = "x")]
    pub y: Vec<String>,
    /// Column whose values are lines, at most 6 of them
    #[arg(long, value_name = "COLUMN", requires = "x")]
    pub by: Option<String>,
    /// Column whose values are panels side by side
    #[arg(long, value_name = "COLUMN", requires = "x")]
    pub across: Option<String>,
    /// Column whose values are panels below one another
    #[arg(long, value_name = "COLUMN", requires = "across")]
    pub down: Option<String>,
    /// The paper's figures
    #[arg(long, value_enum, value_name = "NAME", conflicts_with = "x")]
    pub template: Option<TemplateName>,
    /// Page to write; by default report.html beside the table
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
}

/// Names of the paper's figures.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum TemplateName {
    /// Over the cost of the control rate.
    Crc,
    /// Over the bandwidth.
    Bandwidth,
}

/// A shard as on the command line, `2/10`.
fn shard(text: &str) -> Result<Shard, String> {
    let numbers = text.split_once('/').map(|(part, of)| (part.parse(), of.parse()));
    match numbers {
        Some((Ok(part), Ok(of))) if (1..=of).contains(&part) => Ok(Shard { part, of }),
        _ => Err("expected I/N, a whole number from 1 to N and N".to_owned()),
    }
}

/// The studies.
#[derive(Debug, Subcommand)]
pub enum Study {
    /// Table I of the paper: cost of the control rate
    #[command(after_help = PAPER)]
    Crc(PaperStudyArgs),
    /// Bandwidth of the regression's kernel
    #[command(after_help = PAPER)]
    Bandwidth(PaperStudyArgs),
    /// Table II of the paper: the tenth-scale car, emulated
    #[command(after_help = PAPER)]
    Hardware(PaperStudyArgs),
    /// Which cars stay on which tracks
    #[command(after_help = TRACKS)]
    Tracks(Box<TracksStudyArgs>),
    /// Merge the shards of a campaign into one table
    Merge(MergeArgs),
    /// Draw any axis of a table of runs against any measure
    #[command(after_help = REPORT)]
    Report(ReportArgs),
}

/// Options of `lmpc study tracks`.
#[derive(Debug, Args)]
pub struct TracksStudyArgs {
    /// Cars: names or files
    #[arg(long, num_args = 1.., default_value = "barc", value_name = "NAME|FILE")]
    pub car: Vec<String>,
    /// Tracks: names, files, or folders of track files; by default those that ship with lmpc,
    /// unless there are generated ones
    #[arg(long, num_args = 1.., value_name = "NAME|FILE|FOLDER")]
    pub track: Vec<String>,
    /// Generated tracks for each car, at its scale
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub random: Option<u32>,
    /// Seed of the first generated track; the others follow
    #[arg(long, default_value_t = 0, value_name = "SEED", requires = "random")]
    pub random_seed: u64,
    /// Changes of the simulated car as in `lmpc race`, one plant for each time the option is
    /// given; `none` is the car as it is
    #[arg(long, value_name = "NAME=VALUE,..")]
    pub plant: Vec<String>,
    /// Seeds of each cell
    #[arg(long, default_value_t = 3, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub seeds: u32,
    /// Laps to drive after the warm-up laps
    #[arg(long, default_value_t = 20, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub laps: u32,
    /// Configuration file; its keys override the preset it names
    #[arg(long, value_name = "FILE")]
    pub config: Option<PathBuf>,
    /// Named set of settings
    #[arg(long, value_enum, value_name = "NAME")]
    pub preset: Option<PresetName>,
    /// Set any key of the configuration in every run; may be repeated, each key once
    #[arg(long = "set", value_name = "SECTION.KEY=VALUE")]
    pub set: Vec<String>,
    /// Grip the controllers believe in; by default as in `lmpc race`
    #[arg(long, value_name = "MU")]
    pub nominal_mu: Option<f64>,
    /// Known time-optimal laps: a table car,track,seconds (CSV), laps kept by `lmpc optimum`, or
    /// a folder of such files
    #[arg(long, value_name = "FILE|FOLDER")]
    pub optimum: Option<PathBuf>,
    /// What is judged.
    #[command(flatten)]
    pub limit: LimitArgs,
    /// Runs at the same time; by default one for each processor
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1024))]
    pub jobs: Option<u32>,
    /// Keep the runs of an earlier start with the same settings, and run the others
    #[arg(long)]
    pub resume: bool,
    /// Folder for the results
    #[arg(long, default_value = "out/study-tracks", value_name = "DIR")]
    pub out: PathBuf,
    /// Print the table as JSON
    #[arg(long)]
    pub json: bool,
}

impl TracksStudyArgs {
    /// The tracks asked for; without any and without generated ones, those that ship with the
    /// product.
    #[must_use]
    pub fn track_names(&self) -> Vec<String> {
        if self.track.is_empty() && self.random.is_none() {
            return Track::builtin_names().map(str::to_owned).collect();
        }
        self.track.clone()
    }
}

/// Options of a study of the paper.
#[derive(Debug, Args)]
pub struct PaperStudyArgs {
    /// Seeds of each cell
    #[arg(long, default_value_t = 10, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub seeds: u32,
    /// Laps to drive after the warm-up laps
    #[arg(long, default_value_t = 20, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub laps: u32,
    /// Runs at the same time; by default one for each processor
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1024))]
    pub jobs: Option<u32>,
    /// Run everything again; the earlier tables stay as runs.before.csv and laps.before.csv
    #[arg(long)]
    pub fresh: bool,
    /// Folder for the results; by default out/study-NAME
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Print the table as JSON
    #[arg(long)]
    pub json: bool,
    /// Set any key of the configuration in every cell; may be repeated, each key once
    #[arg(long = "set", value_name = "SECTION.KEY=VALUE")]
    pub set: Vec<String>,
}
