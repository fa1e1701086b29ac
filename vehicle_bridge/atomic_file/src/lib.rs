//! Replaces a file so that a whole one exists at every moment, and keeps the one before it.
//!
//! [`replace`] writes `NAME.new`, syncs it, keeps the present file as `NAME.bak`, renames the new file
//! over `NAME` and syncs the folder. A process that is killed at any point leaves whole files under
//! `NAME` and `NAME.bak`. What is no file, as a device or a pipe, is written to and not replaced; of a
//! link the file that it leads to is replaced.

use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};

/// Writes `path` anew through `write`; makes its folder if there is none.
///
/// # Errors
/// If the new file cannot be written or renamed; the present one is then untouched.
pub fn replace(path: &Path, write: impl FnOnce(&File) -> io::Result<()>) -> io::Result<()> {
    if fs::metadata(path).is_ok_and(|there| !there.is_file()) {
        return write(&File::options().write(true).open(path)?);
    }
    let target = if path.is_symlink() { fs::canonicalize(path)? } else { path.to_owned() };
    let path = target.as_path();
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    if let Some(folder) = folder {
        fs::create_dir_all(folder)?;
    }
    let next = suffixed(path, ".new");
    let file = File::create(&next)?;
    write(&file)?;
    file.sync_all()?;
    drop(file);
    if path.exists() {
        // A second name for the present file: it has a name at every moment.
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
    sync(folder.unwrap_or(Path::new(".")))
}

/// Where the file before the present one stays: its name followed by `.bak`.
#[must_use]
pub fn backup(path: &Path) -> PathBuf {
    suffixed(path, ".bak")
}

/// Brings the rename to the disk.
#[cfg(unix)]
fn sync(folder: &Path) -> io::Result<()> {
    File::open(folder)?.sync_all()
}

/// Windows has no way to sync a folder; NTFS journals the rename.
#[cfg(not(unix))]
fn sync(_: &Path) -> io::Result<()> {
    Ok(())
}

fn suffixed(path: &Path, suffix: &str) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(suffix);
    PathBuf::from(name)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "code of tests")]
    use std::io::Write as _;

    use super::*;

    #[test]
    fn the_file_before_stays() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("below").join("learned.lmpc");
        for content in [b"first", b"other", b"third"] {
            replace(&path, |mut file| file.write_all(content)).unwrap();
        }
        assert_eq!(fs::read(&path).unwrap(), b"third");
        assert_eq!(fs::read(backup(&path)).unwrap(), b"other");
        assert!(!suffixed(&path, ".new").exists());
    }

    #[cfg(unix)]
    #[test]
    fn what_is_no_file_is_not_replaced_and_a_link_stays_one() {
        let folder = tempfile::tempdir().unwrap();
        // A socket, which cannot be opened for writing.
        let path = folder.path().join("socket");
        let socket = std::os::unix::net::UnixListener::bind(&path).unwrap();
        replace(&path, |mut file| file.write_all(b"first")).unwrap_err();
        assert!(!fs::metadata(&path).unwrap().is_file());
        drop(socket);
        let (link, real) = (folder.path().join("link"), folder.path().join("real"));
        fs::write(&real, b"first").unwrap();
        std::os::unix::fs::symlink(&real, &link).unwrap();
        replace(&link, |mut file| file.write_all(b"other")).unwrap();
        assert!(link.is_symlink());
        assert_eq!(fs::read(&real).unwrap(), b"other");
        assert_eq!(fs::read(backup(&real)).unwrap(), b"first");
    }

    #[test]
    fn a_write_that_fails_leaves_both_files() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("learned.lmpc");
        for content in [b"first", b"other"] {
            replace(&path, |mut file| file.write_all(content)).unwrap();
        }
        replace(&path, |_| Err(io::Error::other("disk full"))).unwrap_err();
        assert_eq!(fs::read(&path).unwrap(), b"other");
        assert_eq!(fs::read(backup(&path)).unwrap(), b"first");
    }
}
