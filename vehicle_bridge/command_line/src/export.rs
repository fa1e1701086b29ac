//! Options of `lmpc export`.

use std::path::PathBuf;

use clap::Args;

const EXAMPLES: &str = "\
Examples:
  lmpc export drive.log --csv tables         tables/CAR_STATE.csv, tables/LMPC_TELEM.csv, ...
  lmpc export drive.log --csv tables --channel CAR/STATE --channel LMPC/CMD
  lmpc export car.log --csv tables --types pose.lcm
  lmpc export drive.log --mcap drive.mcap    open it in Foxglove with docs/foxglove-layout.json

CSV: one file for each channel, one row for each message, a header row. The first column, time_s,
is when the logger received the message [s since 1970]; then one column for each field, named by
its path: h.seq, frenet.s, pred[3].x. Arrays have a column for each index up to the longest array
in the log; cells a shorter array does not have stay empty. An array longer than 256 is one cell
of JSON, an array of byte one cell of hexadecimal digits; booleans are 0 and 1. PlotJuggler and
pandas read this as it is. Units stand with the fields in lcm_types/lcm.

MCAP: the messages as JSON under their channels' names, with JSON schemas that hold the fields'
comments; log times are those of the logger, what is no number (NaN) is null. For Foxglove's 3D
panel the topics scene/track, scene/car, scene/prediction, scene/safe_set and tf are added, drawn
from CAR/STATE, LMPC/TELEM and MAP/TRACK (which lmpc serve sends); the drawn car's size follows
the track's width, since a log does not tell it.

A damaged log gives what can still be read; what was skipped is counted, and the exit code is 3.";

/// Options of `lmpc export`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct ExportArgs {
    /// Log of `lmpc record` or lcm-logger
    #[arg(value_name = "LOG")]
    pub log: PathBuf,
    /// Folder for the tables; files of the same names are replaced
    #[arg(long, value_name = "DIR", required_unless_present = "mcap")]
    pub csv: Option<PathBuf>,
    /// MCAP file to write; one that is there is replaced
    #[arg(long, value_name = "FILE")]
    pub mcap: Option<PathBuf>,
    /// Only this channel; may be repeated
    #[arg(long = "channel", value_name = "NAME")]
    pub channels: Vec<String>,
    /// Message types in addition to our own; may be repeated
    #[arg(long, value_name = "FILE.lcm")]
    pub types: Vec<PathBuf>,
    /// Print the account of the log as JSON
    #[arg(long)]
    pub json: bool,
}
