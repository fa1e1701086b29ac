//! Learned data on disk. A save never destroys the previous one.

use std::fs::{self, File};
use std::io::{self, BufWriter, Write as _};
use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result, bail};
use controller::{Controller, Learned};

/// Loads learned data into a controller.
///
/// # Errors
/// If the file cannot be read, is damaged, or belongs to another car, track or configuration.
pub fn load(path: &Path, controller: &mut Controller) -> Result<()> {
    let bytes = fs::read(path).with_context(|| format!("cannot read {}", path.display()))?;
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

fn replace(path: &Path, write: impl FnOnce(&File) -> io::Result<()>) -> io::Result<()> {
    if let Some(folder) = path.parent().filter(|p| !p.as_os_str().is_empty()) {
        fs::create_dir_all(folder)?;
    }
    let next = suffixed(path, ".new");
    let file = File::create(&next)?;
    write(&file)?;
    file.sync_all()?;
    drop(file);
    if path.exists() {
        // A second name for the old file: it has a name at every moment.
        let old = backup(path);
        match fs::remove_file(&old) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
            _ => {}
        }
        if fs::hard_link(path, &old).is_err() {
            fs::copy(path, &old)?;
        }
    }
    fs::rename(&next, path)?;
    if let Some(folder) = path.parent().filter(|p| !p.as_os_str().is_empty()) {
        // The rename itself is on disk once its folder is.
        File::open(folder)?.sync_all()?;
    }
    Ok(())
}

/// Where the file before this one stays: its name with `.bak` behind it.
#[must_use]
pub fn backup(path: &Path) -> PathBuf {
    suffixed(path, ".bak")
}

fn suffixed(path: &Path, suffix: &str) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(suffix);
    PathBuf::from(name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_file_before_stays() {
        let folder = std::env::temp_dir().join(format!("lmpc-save-{}", std::process::id()));
        let path = folder.join("learned.lmpc");
        replace(&path, |mut file| file.write_all(b"first")).unwrap();
        replace(&path, |mut file| file.write_all(b"second")).unwrap();
        replace(&path, |mut file| file.write_all(b"third")).unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"third");
        assert_eq!(fs::read(backup(&path)).unwrap(), b"second");
        assert!(!suffixed(&path, ".new").exists());
        fs::remove_dir_all(&folder).unwrap();
    }
}
