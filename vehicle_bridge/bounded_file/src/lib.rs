//! Reads a file that a user names, up to a size: a wrong name may be that of a device without end, or
//! of a file larger than the memory.
//!
//! A regular file that is too long is refused before a byte of it is read. Pipes and devices have no
//! length: they are read up to the limit.

use std::fs::{self, File};
use std::io::{self, Read as _};
use std::path::{Path, PathBuf};

/// Bytes of one MiB.
const MIB: u64 = 1 << 20;

/// Most that is read of a file, and what a user does about one that is longer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Limit {
    /// Most bytes \[B\].
    most: u64,
    /// What to do.
    cure: &'static str,
}

impl Limit {
    /// Of settings, cars, tracks, maps, benches and studies: a survey of a long circuit takes a few MiB.
    pub const SETTINGS: Self = Self {
        most: 64 * MIB,
        cure: "name the file that is meant, or take fewer points of a survey",
    };
    /// Of recordings in tables and of learned data: a table of 100 states a second for eight hours.
    pub const RECORDING: Self = Self {
        most: 512 * MIB,
        cure: "name the file that is meant, or cut the recording into parts",
    };
    /// Of tables of runs: the ten million of the largest campaign.
    pub const RUNS: Self =
        Self { most: 4096 * MIB, cure: "name the table that is meant, or take fewer runs" };
}

/// Why a file was not read.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// The file system refuses.
    #[error("cannot read {}: {reason}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// What the system says.
        reason: io::Error,
    },
    /// A folder.
    #[error("cannot read {}: it is a folder, expected a file", .0.display())]
    Folder(PathBuf),
    /// Longer than the limit.
    #[error(
        "cannot read {}: it is {found}, expected at most {} MiB; {}",
        path.display(), limit.most / MIB, limit.cure
    )]
    Long {
        /// The file.
        path: PathBuf,
        /// How long it is, in words.
        found: String,
        /// What is read at most.
        limit: Limit,
    },
    /// No text.
    #[error(
        "cannot read {}: line {line} has a byte that is not UTF-8, expected a text; save it as UTF-8",
        path.display()
    )]
    Text {
        /// The file.
        path: PathBuf,
        /// Line of the byte, from 1.
        line: usize,
    },
}

impl ReadError {
    /// Whether there is no file of that name.
    #[must_use]
    pub fn is_missing(&self) -> bool {
        matches!(self, Self::File { reason, .. } if reason.kind() == io::ErrorKind::NotFound)
    }
}

/// The bytes of a file.
///
/// # Errors
/// [`ReadError`], but not that of texts.
pub fn bytes(path: &Path, limit: Limit) -> Result<Vec<u8>, ReadError> {
    let failed = |reason| ReadError::File { path: path.to_owned(), reason };
    let long = |found| ReadError::Long { path: path.to_owned(), found, limit };
    let there = fs::metadata(path).map_err(failed)?;
    if there.is_dir() {
        return Err(ReadError::Folder(path.to_owned()));
    }
    if there.is_file() && there.len() > limit.most {
        return Err(long(format!("{} MiB long", there.len() / MIB)));
    }
    let mut bytes = Vec::new();
    let file = File::open(path).map_err(failed)?;
    file.take(limit.most + 1).read_to_end(&mut bytes).map_err(failed)?;
    if bytes.len() as u64 > limit.most {
        return Err(long("without a known end".to_owned()));
    }
    Ok(bytes)
}

/// The text of a file.
///
/// # Errors
/// [`ReadError`].
pub fn text(path: &Path, limit: Limit) -> Result<String, ReadError> {
    String::from_utf8(bytes(path, limit)?).map_err(|error| {
        let byte = error.utf8_error().valid_up_to();
        let line = error.as_bytes()[..byte].iter().filter(|&&b| b == b'\n').count() + 1;
        ReadError::Text { path: path.to_owned(), line }
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "code of tests")]

    use super::*;

    #[test]
    fn a_file_up_to_the_limit_is_read_and_a_longer_one_is_not() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.csv");
        fs::write(&path, "1,2\n3,4\n").unwrap();
        assert_eq!(text(&path, Limit { most: 8, ..Limit::SETTINGS }).unwrap(), "1,2\n3,4\n");
        assert!(text(&path, Limit { most: 7, ..Limit::SETTINGS }).is_err());
        // Sparse: its bytes take no room on the disk, and would take all memory.
        File::options().write(true).open(&path).unwrap().set_len(1 << 40).unwrap();
        for limit in [Limit::SETTINGS, Limit::RECORDING] {
            let error = bytes(&path, limit).unwrap_err().to_string();
            assert!(error.contains("1048576 MiB long, expected at most"), "{error}");
            assert!(error.contains("a.csv") && error.contains(limit.cure), "{error}");
        }
    }

    #[cfg(unix)]
    #[test]
    fn a_device_without_end_is_refused_and_an_empty_one_read() {
        let error = bytes(Path::new("/dev/zero"), Limit::SETTINGS).unwrap_err().to_string();
        assert!(error.contains("/dev/zero: it is without a known end"), "{error}");
        assert!(error.contains("at most 64 MiB"), "{error}");
        assert!(bytes(Path::new("/dev/null"), Limit::SETTINGS).unwrap().is_empty());
    }

    #[test]
    fn what_is_no_text_or_no_file_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let error = text(folder.path(), Limit::SETTINGS).unwrap_err().to_string();
        assert!(error.contains("is a folder, expected a file"), "{error}");
        let path = folder.path().join("a.csv");
        let error = text(&path, Limit::SETTINGS).unwrap_err();
        assert!(error.is_missing() && error.to_string().contains("a.csv"), "{error}");
        fs::write(&path, b"1\n2\n\xff3\n").unwrap();
        let error = text(&path, Limit::SETTINGS).unwrap_err().to_string();
        assert!(error.contains("a.csv: line 3 has a byte"), "{error}");
        assert_eq!(bytes(&path, Limit::SETTINGS).unwrap().len(), 7);
    }
}
