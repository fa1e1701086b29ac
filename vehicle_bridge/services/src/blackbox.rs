//! The black box: a recording that is always on, in files of bounded size together.

use std::ffi::OsString;
use std::fs::{File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result};

/// What the files' names begin and end with.
const NAME: (&str, &str) = ("blackbox-", ".lcm");
/// Files the size is divided among. \[-\]
const FILES: u64 = 8;

/// Writes one file after another into a folder; the oldest go.
#[derive(Debug)]
pub struct BlackBox {
    folder: PathBuf,
    /// Of this start of the program.
    start: String,
    number: u32,
    /// A file ends at the first end of an event beyond this size. \[B\]
    each: u64,
    most: u64,
    file: File,
    size: u64,
}

impl BlackBox {
    /// Where it is unless told otherwise: the service manager's state folder, else the user's.
    #[must_use]
    pub fn default_folder() -> Option<PathBuf> {
        let variable = |name: &str| std::env::var_os(name).filter(|value| !value.is_empty());
        let state = || variable("XDG_STATE_HOME").map(|state| PathBuf::from(state).join("lmpc"));
        let home = || variable("HOME").map(|home| PathBuf::from(home).join(".local/state/lmpc"));
        let service = variable("STATE_DIRECTORY").map(|all| first(&all));
        service.or_else(state).or_else(home).map(|folder| folder.join("blackbox"))
    }

    /// Begins a new file in `folder`, which is made if it is not there; all files of the folder
    /// together stay below `most` bytes.
    ///
    /// # Errors
    /// If the folder or the file cannot be made.
    pub fn open(folder: &Path, most: u64) -> Result<Self> {
        let failed = || format!("cannot write the black box in {}", folder.display());
        std::fs::create_dir_all(folder).with_context(failed)?;
        let now = transport::now().utime / 1_000_000;
        let start = format!("{}-{}", utc(now), std::process::id());
        let each = (most / FILES).max(1);
        make_room(folder, most.saturating_sub(2 * each)).with_context(failed)?;
        let file = make(folder, &start, 0).with_context(failed)?;
        Ok(Self { folder: folder.to_owned(), start, number: 0, each, most, file, size: 0 })
    }

    fn rotate(&mut self) -> io::Result<()> {
        make_room(&self.folder, self.most.saturating_sub(2 * self.each))?;
        let file = make(&self.folder, &self.start, self.number + 1)?;
        (self.file, self.size, self.number) = (file, 0, self.number + 1);
        Ok(())
    }
}

impl Write for BlackBox {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        // Never without an end, should no end of an event be seen. Readers find the next event.
        if self.size >= 2 * self.each {
            self.rotate()?;
        }
        let written = self.file.write(bytes)?;
        self.size += written as u64;
        Ok(written)
    }

    /// Called between events.
    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()?;
        if self.size >= self.each { self.rotate() } else { Ok(()) }
    }
}

/// The first of a list of folders, as systemd gives them.
fn first(all: &OsString) -> PathBuf {
    PathBuf::from(all.to_string_lossy().split(':').next().unwrap_or_default())
}

fn make(folder: &Path, start: &str, number: u32) -> io::Result<File> {
    let path = folder.join(format!("{}{start}-{number:05}{}", NAME.0, NAME.1));
    OpenOptions::new().append(true).create_new(true).open(path)
}

/// Removes the oldest of our files until the others take at most `most` bytes.
fn make_room(folder: &Path, most: u64) -> io::Result<()> {
    let mut files = Vec::new();
    for entry in std::fs::read_dir(folder)? {
        let entry = entry?;
        let name = entry.file_name();
        let ours = name.to_str().is_some_and(|n| n.starts_with(NAME.0) && n.ends_with(NAME.1));
        if ours && entry.file_type()?.is_file() {
            // One that another bridge removed meanwhile takes no room.
            files.push((name, entry.metadata().map_or(0, |metadata| metadata.len())));
        }
    }
    // The names begin with the time.
    files.sort();
    let mut size: u64 = files.iter().map(|(_, size)| size).sum();
    for (name, of_file) in files {
        if size <= most {
            break;
        }
        match std::fs::remove_file(folder.join(name)) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
            _ => size -= of_file,
        }
    }
    Ok(())
}

/// A time \[s since 1970\] as `20261128T093000Z`, after Hinnant's `civil_from_days`.
fn utc(seconds: i64) -> String {
    let (days, second) = (seconds.div_euclid(86_400), seconds.rem_euclid(86_400));
    let shifted = days + 719_468;
    let (era, day_of_era) = (shifted.div_euclid(146_097), shifted.rem_euclid(146_097));
    let year_of_era =
        (day_of_era - day_of_era / 1460 + day_of_era / 36_524 - day_of_era / 146_096) / 365;
    let day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let index = (5 * day_of_year + 2) / 153;
    let day = day_of_year - (153 * index + 2) / 5 + 1;
    let month = if index < 10 { index + 3 } else { index - 9 };
    let year = year_of_era + era * 400 + i64::from(month <= 2);
    let (hour, minute, second) = (second / 3600, second / 60 % 60, second % 60);
    format!("{year:04}{month:02}{day:02}T{hour:02}{minute:02}{second:02}Z")
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "code of tests")]
    use super::*;

    #[test]
    fn its_files_stay_below_the_size_and_the_newest_are_kept() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("mine.lcm"), vec![0; 5000]).unwrap();
        for _ in 0..2 {
            let mut recording = BlackBox::open(folder.path(), 80_000).unwrap();
            // Where two starts fall into one second, the numbers go on.
            for event in 0..10_000_u32 {
                recording.write_all(&[b"event ", &event.to_be_bytes()[..]].concat()).unwrap();
                recording.flush().unwrap();
            }
            let mut files: Vec<_> =
                std::fs::read_dir(folder.path()).unwrap().map(|e| e.unwrap().path()).collect();
            files.retain(|path| !path.ends_with("mine.lcm"));
            files.sort();
            let sizes: u64 = files.iter().map(|p| std::fs::metadata(p).unwrap().len()).sum();
            assert!((50_000..=80_000).contains(&sizes), "{sizes} bytes");
            let last =
                files.iter().rev().map(|p| std::fs::read(p).unwrap()).find(|b| !b.is_empty());
            assert!(last.unwrap().ends_with(&9_999_u32.to_be_bytes()));
            drop(recording);
            std::thread::sleep(std::time::Duration::from_millis(1100));
        }
        assert!(folder.path().join("mine.lcm").exists(), "a file of others is left alone");
    }

    #[test]
    fn times_are_those_of_the_calendar() {
        // As `date -u -d @N +%Y%m%dT%H%M%SZ` prints them.
        let known = [
            (0, "19700101T000000Z"),
            (951_868_799, "20000229T235959Z"),
            (951_868_800, "20000301T000000Z"),
            (1_795_858_200, "20261128T093000Z"),
            (4_107_542_400, "21000301T000000Z"),
        ];
        for (seconds, text) in known {
            assert_eq!(utc(seconds), text);
        }
    }
}
