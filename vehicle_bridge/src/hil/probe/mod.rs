//! Programs of the shipped benches: each prints what it measures, `name value` line by line.

mod damaged_log;
mod saver;

use anyhow::Result;

use crate::cli::{Probe, ProbeArgs};
use crate::console::result;

/// What a program measured.
type Measured = Vec<(&'static str, u64)>;

/// Runs one.
///
/// # Errors
/// If it cannot measure; what it measures is no error, however bad.
pub fn run(args: &ProbeArgs) -> Result<()> {
    let measured = match &args.probe {
        Probe::SaverKills { kills } => saver::kills(&args.dir, args.seed, *kills)?,
        Probe::Saver => saver::save(&args.dir)?,
        Probe::DamagedLog { network } => damaged_log::run(&args.dir, args.seed, &network.url())?,
    };
    for (name, value) in measured {
        result(&format!("{name} {value}"))?;
    }
    Ok(())
}
