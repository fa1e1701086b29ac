//! Folders for results, looked at before the work whose results go there.

use std::fs;
use std::path::Path;

use anyhow::{Context as _, Result, bail};

/// Makes a folder for results.
///
/// # Errors
/// If it cannot be made or written.
pub(super) fn results(folder: &Path) -> Result<()> {
    fs::create_dir_all(folder)
        .with_context(|| format!("cannot make the folder {}", folder.display()))?;
    writable(folder)
}

/// Whether a file of this name will be writable, as far as its folder tells; the file stays as it is.
///
/// # Errors
/// If its folder is missing or cannot be written.
pub(super) fn file(path: &Path) -> Result<()> {
    if path.is_dir() {
        bail!("cannot save to {}: it is a folder, expected a file", path.display());
    }
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    writable(folder.unwrap_or(Path::new(".")))
        .with_context(|| format!("cannot save {}", path.display()))
}

/// Refuses to write over the file that is read.
///
/// # Errors
/// If both names are those of one file.
pub(super) fn other_than(read: &Path, written: &Path) -> Result<()> {
    let same =
        read.canonicalize().is_ok_and(|read| written.canonicalize().is_ok_and(|w| w == read));
    if same && written.is_file() {
        bail!(
            "{} is the file that is read, expected another to write; give it another name",
            written.display()
        );
    }
    Ok(())
}

fn writable(folder: &Path) -> Result<()> {
    let probe = folder.join(format!(".lmpc-{}", std::process::id()));
    fs::write(&probe, b"?")
        .and_then(|()| fs::remove_file(&probe))
        .with_context(|| format!("cannot write into the folder {}", folder.display()))
}
