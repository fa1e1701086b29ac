//! Learned data on disk. A save never destroys the previous one.

use std::io::{self, BufWriter, Write as _};
use std::path::Path;

use anyhow::{Context as _, Result, bail};
pub use atomic_file::backup;
use atomic_file::replace;
use bounded_file::Limit;
use controller::{Controller, Learned};

/// Loads learned data into a controller.
///
/// # Errors
/// If the file cannot be read, is damaged, or belongs to another car, track or configuration.
pub fn load(path: &Path, controller: &mut Controller) -> Result<()> {
    let bytes = bounded_file::bytes(path, Limit::RECORDING)?;
    let previous = backup(path);
    let hint = if previous.exists() {
        format!("; the file before it is {}", previous.display())
    } else {
        String::new()
    };
    controller
        .load(&bytes)
        .with_context(|| format!("{}: the learned data are refused{hint}", path.display()))
}

/// Saves what a controller has learned: written beside the old file, synced, then renamed over
/// it; the old one stays as `.bak`.
///
/// # Errors
/// If the file cannot be written; the old one is still there.
pub fn save(path: &Path, controller: &Controller) -> Result<()> {
    if path.is_dir() {
        bail!("cannot save to {}: it is a folder, expected a file", path.display());
    }
    write(path, &controller.learned_data())
        .with_context(|| format!("cannot save {}", path.display()))
}

/// Writes learned data as [`save`] does.
///
/// # Errors
/// If the file cannot be written; the old one is still there.
pub fn write(path: &Path, learned: &Learned) -> io::Result<()> {
    replace(path, |file| {
        let mut file = BufWriter::new(file);
        learned.write(|bytes| file.write_all(bytes))?;
        file.flush()
    })
}
