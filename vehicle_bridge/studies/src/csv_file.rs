//! Tables that survive a kill: rows are appended whole, a torn line is dropped when read again.

use std::fs::{self, File, OpenOptions};
use std::io::Write as _;
use std::path::Path;

use anyhow::{Context as _, Result};
use serde::Serialize;
use serde::de::DeserializeOwned;

/// The rows of a table up to the first that cannot be read; none if there is no table.
pub(super) fn read<T: DeserializeOwned>(path: &Path) -> Result<Vec<T>> {
    match fs::read(path) {
        Ok(bytes) => {
            let whole = bytes.iter().rposition(|&b| b == b'\n').map_or(0, |i| i + 1);
            let mut reader = csv::Reader::from_reader(&bytes[..whole]);
            Ok(reader.deserialize().map_while(Result::ok).collect())
        }
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(Vec::new()),
        Err(error) => Err(error).with_context(|| format!("cannot read {}", path.display())),
    }
}

fn encode<T: Serialize>(rows: &[T], header: bool) -> Result<Vec<u8>> {
    let mut writer = csv::WriterBuilder::new().has_headers(header).from_writer(Vec::new());
    for row in rows {
        writer.serialize(row)?;
    }
    Ok(writer.into_inner().map_err(|e| e.into_error())?)
}

/// Appends rows in one write, so that a kill leaves at most one torn line.
pub(super) fn append<T: Serialize>(path: &Path, rows: &[T]) -> Result<()> {
    let write = || -> Result<()> {
        let mut file = OpenOptions::new().create(true).append(true).open(path)?;
        let header = file.metadata()?.len() == 0;
        file.write_all(&encode(rows, header)?)?;
        Ok(file.sync_data()?)
    };
    write().with_context(|| format!("cannot write {}", path.display()))
}

/// Writes a whole table beside the old one and puts it in its place.
pub(super) fn replace<T: Serialize>(path: &Path, rows: &[T]) -> Result<()> {
    let write = || -> Result<()> {
        let next = path.with_extension("csv.new");
        let mut file = File::create(&next)?;
        file.write_all(&encode(rows, true)?)?;
        file.sync_all()?;
        Ok(fs::rename(&next, path)?)
    };
    write().with_context(|| format!("cannot write {}", path.display()))
}
