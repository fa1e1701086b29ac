//! Options of `lmpc study`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

const EXAMPLES: &str = "\
Examples:
  lmpc study crc --seeds 10          Table I: error and full regression over five rate costs
  lmpc study bandwidth --seeds 10    the figure over the bandwidth h, kinematic nominal model
  lmpc study hardware                Table II, with a plant that differs from the model

A study that is interrupted goes on where it stopped when it is started again with the same
options. It writes runs.csv, laps.csv and report.html.";

/// Options of `lmpc study`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct StudyArgs {
    /// Which study
    #[arg(value_enum)]
    pub name: StudyName,
    /// Seeds of each cell
    #[arg(long, default_value_t = 10, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub seeds: u32,
    /// Laps to drive after the warm-up laps
    #[arg(long, default_value_t = 20, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub laps: u32,
    /// Runs at the same time; by default one for each processor
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1024))]
    pub jobs: Option<u32>,
    /// Run everything again, also what an earlier start has finished
    #[arg(long)]
    pub fresh: bool,
    /// Folder for the results; by default out/study-NAME
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Print the table as JSON
    #[arg(long)]
    pub json: bool,
    /// Set any key of the configuration in every cell; may be repeated
    #[arg(long = "set", value_name = "SECTION.KEY=VALUE")]
    pub set: Vec<String>,
}

/// The studies of the paper.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum StudyName {
    /// Table I: cost of the control rate.
    Crc,
    /// Bandwidth of the regression's kernel.
    Bandwidth,
    /// Table II: the tenth-scale car, emulated.
    Hardware,
}

impl StudyName {
    /// The name as on the command line.
    #[must_use]
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Crc => "crc",
            Self::Bandwidth => "bandwidth",
            Self::Hardware => "hardware",
        }
    }
}
