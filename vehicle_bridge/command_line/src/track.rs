//! Options of `lmpc track`.

use std::path::PathBuf;

use clap::{Args, Subcommand};

const EXAMPLES: &str = "\
Examples:
  lmpc track show circuit.csv --out track.html    what an import makes of a file, before and after
  lmpc track convert circuit.csv circuit.toml     the track as it is raced, in our own format
  lmpc track random --car kart --seed 7 --out random.toml

A track file is one of those in docs/tracks.md. Points are smoothed as their own noise asks for, and
widths are cut where a bend is tighter than the width inside it; every change is printed.";

/// Options of `lmpc track`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct TrackArgs {
    /// What to do.
    #[command(subcommand)]
    pub action: TrackAction,
}

/// What `lmpc track` does.
#[derive(Debug, Subcommand)]
pub enum TrackAction {
    /// Print what an import changes, and draw the track before and after
    Show(ShowArgs),
    /// Write a track in our own format, from any other
    Convert(ConvertArgs),
    /// Write a random closed track at a car's scale
    Random(RandomArgs),
}

/// How a track file is read.
#[derive(Debug, Args)]
pub struct ImportArgs {
    /// Distance by which smoothing moves the points, root mean square; 0 for none, in metres
    #[arg(long, value_name = "METRES", value_parser = not_negative)]
    pub smooth: Option<f64>,
    /// Width of the track from edge to edge, for a file that has none, in metres
    #[arg(long, value_name = "METRES", value_parser = positive)]
    pub width: Option<f64>,
}

/// Options of `lmpc track show`.
#[derive(Debug, Args)]
pub struct ShowArgs {
    /// Track file, or the name of a track that ships with lmpc
    #[arg(value_name = "FILE")]
    pub file: String,
    /// Page to write, with map, curvature, widths and heading
    #[arg(long, value_name = "FILE.html")]
    pub out: Option<PathBuf>,
    /// Car by name or file that the track is to fit: room for its body, bends it gets round
    #[arg(long, value_name = "CAR")]
    pub car: Option<String>,
    /// How the file is read.
    #[command(flatten)]
    pub import: ImportArgs,
}

/// Options of `lmpc track convert`.
#[derive(Debug, Args)]
pub struct ConvertArgs {
    /// Track file, or the name of a track that ships with lmpc
    #[arg(value_name = "IN")]
    pub file: String,
    /// File to write
    #[arg(value_name = "OUT.toml")]
    pub out: PathBuf,
    /// How the file is read.
    #[command(flatten)]
    pub import: ImportArgs,
}

/// Options of `lmpc track random`.
#[derive(Debug, Args)]
pub struct RandomArgs {
    /// Car by name or file; the track has its scale
    #[arg(long, value_name = "CAR", default_value = "barc")]
    pub car: String,
    /// Seed; the same seed and car give the same track
    #[arg(long, default_value_t = 0)]
    pub seed: u64,
    /// File to write
    #[arg(long, value_name = "FILE.toml")]
    pub out: PathBuf,
}

fn not_negative(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value >= 0.0 && value.is_finite() => Ok(value),
        _ => Err("expected metres, 0 or more".to_owned()),
    }
}

fn positive(text: &str) -> Result<f64, String> {
    not_negative(text)
        .ok()
        .filter(|value| *value > 0.0)
        .ok_or_else(|| "expected metres, above 0".to_owned())
}
