//! Options of `lmpc bench`.

use std::path::PathBuf;

use clap::Args;

const EXAMPLES: &str = "\
Examples:
  lmpc bench                          the step by phase and the QP alone, 4, 100 and 1,000 laps
  lmpc bench --laps 4 --steps 1000    no search through many laps, but more samples
  lmpc bench --case 0 --json          the first set-up only, for a program
  lmpc bench --case 0 --laps 4 --dump-qp out/qp   keep its optimal control problems ...
  lmpc bench --read-qp out/qp                     ... and solve them with both solvers

Times are in microseconds. Everything runs in this process and on one thread; steps in which the
system took the processor away are counted and left out.";

/// Options of `lmpc bench`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct BenchArgs {
    /// Learned steps, and QPs, of each measurement
    #[arg(long, default_value_t = 300, value_name = "N", value_parser = clap::value_parser!(u32).range(10..=1_000_000))]
    pub steps: u32,
    /// Laps stored, each number apart; growth is from the first to the last
    #[arg(long, default_value = "4,100,1000", value_delimiter = ',', value_name = "N,...", value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub laps: Vec<u32>,
    /// Initial laps among those stored, at most; the others were learned, as in a race. With as
    /// many as are stored the search has its hardest time: the car is faster than all its data. The
    /// full-size car, whose laps are long, always stores initial laps
    #[arg(long, default_value_t = 4, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub initial: u32,
    /// One set-up only: 0 and 1 are the 1:10 car with N 10, 2 with N 20, 3 the full-size car with N 60
    #[arg(long, value_name = "I", value_parser = clap::value_parser!(u32).range(0..=3))]
    pub case: Option<u32>,
    /// Write the optimal control problem of each measured step to a file of its own in this folder
    #[arg(long, value_name = "DIR")]
    pub dump_qp: Option<PathBuf>,
    /// Measure nothing else: solve the problems of this folder or file with both solvers, and compare
    #[arg(long, value_name = "DIR|FILE", conflicts_with_all = ["dump_qp", "case", "laps", "initial", "steps"])]
    pub read_qp: Option<PathBuf>,
    /// Print the results as JSON
    #[arg(long)]
    pub json: bool,
}
