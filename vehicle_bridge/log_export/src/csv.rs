//! One CSV file for each channel of a log.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::{self, File};
use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result};

use super::Types;
use super::columns::ColumnTree;
use super::log::{self, Account, Stream};

/// Name of the first column: when a message was received, since 1970. \[s\]
pub const TIME: &str = "time_s";

/// A file being written.
struct Sheet {
    columns: ColumnTree,
    path: PathBuf,
    writer: csv::Writer<File>,
    cells: Vec<String>,
}

/// Writes the messages of `log` to files in `folder`, which is made if it is not there. The log is
/// read twice: first for the longest arrays, then for the rows.
///
/// # Errors
/// If the log cannot be read or a file not be written.
pub fn write(log: &Path, types: &Types, channels: &[String], folder: &Path) -> Result<Account> {
    let mut columns: BTreeMap<Stream, ColumnTree> = BTreeMap::new();
    log::read(log, types, channels, |entry| {
        let stream = stream(entry);
        if let Some(columns) = columns.get_mut(&stream) {
            columns.grow(entry.value);
        } else {
            columns.insert(stream, ColumnTree::of(entry.value));
        }
        Ok(())
    })?;
    fs::create_dir_all(folder).with_context(|| format!("cannot make {}", folder.display()))?;
    let mut sheets = sheets(columns, types, folder)?;
    let account = log::read(log, types, channels, |entry| {
        let Some(sheet) = sheets.get_mut(&stream(entry)) else { return Ok(()) };
        sheet.cells.clear();
        sheet.cells.push(seconds(entry.event.utime));
        sheet.columns.cells(types, entry.of, entry.value, &mut sheet.cells);
        let Sheet { writer, path, cells, .. } = sheet;
        writer.write_record(cells).with_context(|| format!("cannot write {}", path.display()))
    })?;
    for Sheet { mut writer, path, .. } in sheets.into_values() {
        writer.flush().with_context(|| format!("cannot write {}", path.display()))?;
    }
    Ok(account)
}

fn stream(entry: &log::DecodedEvent<'_>) -> Stream {
    Stream { channel: entry.event.channel.clone(), type_name: entry.of.full_name() }
}

/// Microseconds as seconds, digit for digit.
fn seconds(utime: i64) -> String {
    let (whole, micros) = (utime.unsigned_abs() / 1_000_000, utime.unsigned_abs() % 1_000_000);
    format!("{}{whole}.{micros:06}", if utime < 0 { "-" } else { "" })
}

fn sheets(
    columns: BTreeMap<Stream, ColumnTree>,
    types: &Types,
    folder: &Path,
) -> Result<BTreeMap<Stream, Sheet>> {
    let mut taken = BTreeSet::new();
    let mut sheets = BTreeMap::new();
    for (stream, columns) in columns {
        let Some(of) = types.get(&stream.type_name) else { continue };
        let path = folder.join(file_name(&stream, &mut taken));
        let cannot = || format!("cannot write {}", path.display());
        let mut writer = csv::Writer::from_path(&path).with_context(cannot)?;
        let names = columns.names(types, of);
        let header = std::iter::once(TIME).chain(names.iter().map(String::as_str));
        writer.write_record(header).with_context(cannot)?;
        sheets.insert(stream, Sheet { columns, path, writer, cells: Vec::new() });
    }
    Ok(sheets)
}

/// `CAR_STATE.csv`; the type is added where a channel carries several, or two channels would meet.
fn file_name(stream: &Stream, taken: &mut BTreeSet<String>) -> String {
    let keep = |c: char| if c.is_alphanumeric() || "-.".contains(c) { c } else { '_' };
    let stem: String = stream.channel.chars().map(keep).collect();
    let stem = if stem.starts_with('.') { format!("_{stem}") } else { stem };
    let typed = format!("{stem}.{}", stream.type_name);
    let numbered = (2..).map(|n| format!("{typed}.{n}"));
    let mut names = [stem, typed.clone()].into_iter().chain(numbered);
    // Names without case, for file systems that do not tell.
    let free = names.find(|name| taken.insert(name.to_lowercase())).unwrap_or(typed);
    format!("{free}.csv")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_never_meet_and_stay_in_their_folder() {
        let mut taken = BTreeSet::new();
        let mut name = |channel: &str, type_name: &str| {
            let stream = Stream { channel: channel.to_owned(), type_name: type_name.to_owned() };
            file_name(&stream, &mut taken)
        };
        assert_eq!(name("CAR/STATE", "a.b"), "CAR_STATE.csv");
        assert_eq!(name("CAR/STATE", "a.c"), "CAR_STATE.a.c.csv");
        assert_eq!(name("car_state", "a.c"), "car_state.a.c.2.csv");
        assert_eq!(name("../../etc", "a.c"), "_.._.._etc.csv");
    }

    #[test]
    fn times_keep_their_digits() {
        assert_eq!(seconds(1_700_000_000_000_001), "1700000000.000001");
        assert_eq!(seconds(-1), "-0.000001");
    }
}
