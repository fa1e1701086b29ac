//! Tables that survive a kill: rows are appended whole, and only a torn last line is dropped.
//!
//! Each row is one line. A line without its end was being written when the process was killed; it is
//! cut off when the table is opened. Everything else that cannot be read stops the program: what
//! this version cannot read it must not overwrite.

use std::fs::{self, OpenOptions, TryLockError};
use std::io::Write as _;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result, bail};
use bounded_file::Limit;
use csv::{ErrorKind as Fault, StringRecord};
use serde::Serialize;
use serde::de::DeserializeOwned;

/// What to do about a table that cannot be read.
const CURE: &str = "the file was left as it is. Correct or remove that line, or move the file away \
                    to begin a new table";

/// Opens a table: cuts off a torn last line and reads the others. No rows if there is no table.
///
/// # Errors
/// If the file cannot be read, has other columns than `T`, or has a line that is no row.
pub(super) fn open<T: DeserializeOwned + Serialize + Default>(path: &Path) -> Result<Vec<T>> {
    let columns = columns::<T>()?;
    open_as(path, &columns, |record| record.deserialize(Some(&columns)))
}

/// [`open`] for a table whose columns are known only now: each row as its fields.
///
/// # Errors
/// As [`open`].
pub(super) fn open_records(path: &Path, columns: &StringRecord) -> Result<Vec<StringRecord>> {
    open_as(path, columns, |record| Ok(record.clone()))
}

/// The head of a table; `None` if there is no table, or none of its lines is whole.
///
/// # Errors
/// If the file cannot be read.
pub(super) fn head(path: &Path) -> Result<Option<StringRecord>> {
    let Some(bytes) = bytes(path)? else { return Ok(None) };
    let Some(end) = bytes.iter().position(|&b| b == b'\n') else { return Ok(None) };
    let mut reader = csv::Reader::from_reader(&bytes[..end]);
    let head = reader.headers().with_context(|| format!("{}, line 1", path.display()))?;
    Ok(Some(head.clone()))
}

/// The bytes of a file, if there is one.
fn bytes(path: &Path) -> Result<Option<Vec<u8>>> {
    match bounded_file::bytes(path, Limit::RUNS) {
        Ok(bytes) => Ok(Some(bytes)),
        Err(error) if error.is_missing() => Ok(None),
        Err(error) => Err(error.into()),
    }
}

fn open_as<R>(
    path: &Path,
    columns: &StringRecord,
    row: impl Fn(&StringRecord) -> Result<R, csv::Error>,
) -> Result<Vec<R>> {
    let Some(bytes) = bytes(path)? else { return Ok(Vec::new()) };
    let whole = bytes.iter().rposition(|&b| b == b'\n').map_or(0, |i| i + 1);
    let rows = parse(path, &bytes[..whole], columns, row)?;
    if whole < bytes.len() {
        let cut = || {
            let file = OpenOptions::new().write(true).open(path)?;
            file.set_len(whole as u64)?;
            file.sync_all()
        };
        cut().with_context(|| format!("cannot cut the torn last line off {}", path.display()))?;
    }
    Ok(rows)
}

fn parse<R>(
    path: &Path,
    lines: &[u8],
    columns: &StringRecord,
    row: impl Fn(&StringRecord) -> Result<R, csv::Error>,
) -> Result<Vec<R>> {
    if lines.is_empty() {
        return Ok(Vec::new());
    }
    let refuse =
        |line: u64, fault: String| format!("{}, line {line}: {fault}; {CURE}", path.display());
    let mut reader = csv::ReaderBuilder::new().from_reader(lines);
    let header = reader.headers().map_err(|e| anyhow::anyhow!(refuse(1, fault(&e, None))))?.clone();
    if header != *columns {
        bail!(refuse(1, other_columns(&header, columns)));
    }
    let (mut rows, mut record) = (Vec::new(), StringRecord::new());
    loop {
        // Blank lines may stand before the record: its own line is known once it is read.
        let read = reader.read_record(&mut record);
        let line = record.position().map_or(1, csv::Position::line);
        match read {
            Ok(false) => return Ok(rows),
            Ok(true) if record.iter().any(|field| field.contains('\n')) => {
                bail!(refuse(line, "a quotation mark is not closed in this line".to_owned()));
            }
            Ok(true) => match row(&record) {
                Ok(row) => rows.push(row),
                Err(e) => bail!(refuse(line, fault(&e, Some(columns)))),
            },
            Err(e) => {
                let line = e.position().map_or(line, csv::Position::line);
                bail!(refuse(line, fault(&e, Some(columns))));
            }
        }
    }
}

/// The columns of a table of `T`.
fn columns<T: Serialize + Default>() -> Result<StringRecord> {
    let bytes = encode(&[T::default()], true)?;
    Ok(csv::Reader::from_reader(&bytes[..]).headers()?.clone())
}

fn other_columns(found: &StringRecord, expected: &StringRecord) -> String {
    let only = |of: &StringRecord, other: &StringRecord| -> Vec<String> {
        let apart = of.iter().filter(|name| !other.iter().any(|known| known == *name));
        apart.map(|name| format!("`{name}`")).collect()
    };
    let (unknown, missing) = (only(found, expected), only(expected, found));
    let list = |label: &str, names: &[String]| match names {
        [] => String::new(),
        names => format!(", {label} {}", names.join(", ")),
    };
    format!(
        "these are not the columns this version of lmpc writes{}{}{}",
        list("unknown are", &unknown),
        list("missing are", &missing),
        if unknown.is_empty() && missing.is_empty() { ", their order differs" } else { "" }
    )
}

/// What is wrong with a line.
fn fault(error: &csv::Error, columns: Option<&StringRecord>) -> String {
    match error.kind() {
        Fault::UnequalLengths { expected_len, len, .. } => {
            format!("{len} columns, expected {expected_len}")
        }
        Fault::Utf8 { .. } => "not UTF-8 text".to_owned(),
        Fault::Deserialize { err, .. } => {
            let index = err.field().and_then(|i| usize::try_from(i).ok());
            match index.zip(columns).and_then(|(i, columns)| columns.get(i)) {
                Some(name) => format!("column `{name}`: {}", err.kind()),
                None => err.kind().to_string(),
            }
        }
        _ => error.to_string(),
    }
}

/// Rows as text, each one line: a line break within a field becomes a blank.
fn encode<T: Serialize>(rows: &[T], header: bool) -> Result<Vec<u8>> {
    let mut writer = csv::WriterBuilder::new().has_headers(header).from_writer(Vec::new());
    for row in rows {
        writer.serialize(row)?;
    }
    let lines = rows.len() + usize::from(header && !rows.is_empty());
    one_line_each(finish(writer)?, lines)
}

/// [`encode`] for rows of fields below the given columns.
fn encode_records(columns: &StringRecord, rows: &[StringRecord], header: bool) -> Result<Vec<u8>> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    for row in header.then_some(columns).into_iter().chain(rows) {
        writer.write_record(row)?;
    }
    one_line_each(finish(writer)?, rows.len() + usize::from(header))
}

fn finish(writer: csv::Writer<Vec<u8>>) -> Result<Vec<u8>> {
    Ok(writer.into_inner().map_err(|e| e.into_error())?)
}

fn one_line_each(bytes: Vec<u8>, lines: usize) -> Result<Vec<u8>> {
    let breaks = bytes.iter().filter(|b| matches!(b, b'\n' | b'\r')).count();
    if breaks == lines {
        return Ok(bytes);
    }
    let mut writer = csv::WriterBuilder::new().from_writer(Vec::new());
    for record in csv::ReaderBuilder::new().has_headers(false).from_reader(&bytes[..]).records() {
        let record = record?;
        writer.write_record(record.iter().map(|field| field.replace(['\n', '\r'], " ")))?;
    }
    finish(writer)
}

/// Appends rows in one write, so that a kill leaves at most one torn line.
pub(super) fn append<T: Serialize>(path: &Path, rows: &[T]) -> Result<()> {
    append_bytes(path, |header| encode(rows, header))
}

/// [`append`] for rows of fields below the given columns.
pub(super) fn append_records(
    path: &Path,
    columns: &StringRecord,
    rows: &[StringRecord],
) -> Result<()> {
    append_bytes(path, |header| encode_records(columns, rows, header))
}

fn append_bytes(path: &Path, text: impl FnOnce(bool) -> Result<Vec<u8>>) -> Result<()> {
    let write = || -> Result<()> {
        let mut file = OpenOptions::new().create(true).append(true).open(path)?;
        let header = file.metadata()?.len() == 0;
        file.write_all(&text(header)?)?;
        Ok(file.sync_data()?)
    };
    write().with_context(|| format!("cannot write {}", path.display()))
}

/// Writes the whole table anew; the one before it stays as `.bak`.
pub(super) fn replace<T: Serialize>(path: &Path, rows: &[T]) -> Result<()> {
    replace_bytes(path, &encode(rows, true)?)
}

/// [`replace`] for rows of fields below the given columns.
pub(super) fn replace_records(
    path: &Path,
    columns: &StringRecord,
    rows: &[StringRecord],
) -> Result<()> {
    replace_bytes(path, &encode_records(columns, rows, true)?)
}

fn replace_bytes(path: &Path, bytes: &[u8]) -> Result<()> {
    atomic_file::replace(path, |mut file| file.write_all(bytes))
        .with_context(|| format!("cannot write {}", path.display()))
}

/// Puts a table aside as `NAME.before.csv`, or with the next free number: an earlier one stays.
pub(super) fn put_aside(path: &Path) -> Result<()> {
    if !path.exists() {
        return Ok(());
    }
    let mut aside = path.with_extension("before.csv");
    let mut number = 2;
    while aside.exists() {
        aside = path.with_extension(format!("before-{number}.csv"));
        number += 1;
    }
    fs::rename(path, &aside).with_context(|| format!("cannot put {} aside", path.display()))
}

/// The folder of a study while one program writes in it.
#[derive(Debug)]
pub(super) struct Folder {
    path: PathBuf,
    /// Locked until it is dropped.
    _lock: fs::File,
}

impl Folder {
    /// Locks the folder, which is made if it does not exist.
    pub(super) fn lock(path: &Path) -> Result<Self> {
        fs::create_dir_all(path)
            .with_context(|| format!("cannot make the folder {}", path.display()))?;
        let file = path.join(".lock");
        let lock =
            fs::File::create(&file).with_context(|| format!("cannot write {}", file.display()))?;
        match lock.try_lock() {
            Err(TryLockError::WouldBlock) => bail!(
                "another lmpc study writes to {}: wait until it has ended, or give another --out",
                path.display()
            ),
            // A file system without locks: two studies in one folder are then the user's care.
            Ok(()) | Err(TryLockError::Error(_)) => {}
        }
        Ok(Self { path: path.to_owned(), _lock: lock })
    }

    pub(super) fn file(&self, name: &str) -> PathBuf {
        self.path.join(name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde::Deserialize;

    #[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
    struct Row {
        name: String,
        seed: u64,
        time_s: Option<f64>,
    }

    fn row(name: &str, seed: u64, time_s: f64) -> Row {
        Row { name: name.to_owned(), seed, time_s: Some(time_s) }
    }

    fn rows() -> Vec<Row> {
        vec![row("plain", 12, 3.9), row("a, \"b\"\nc", 3, 0.1), row("\u{e9}", 4, 1e-7)]
    }

    /// The rows as they come back: each on one line.
    fn stored() -> Vec<Row> {
        let mut rows = rows();
        rows[1].name = "a, \"b\" c".to_owned();
        rows
    }

    #[test]
    fn a_kill_at_any_byte_costs_the_torn_line_alone() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("runs.csv");
        append(&path, &rows()).unwrap();
        let bytes = fs::read(&path).unwrap();
        for length in 0..=bytes.len() {
            fs::write(&path, &bytes[..length]).unwrap();
            let lines = bytes[..length].iter().filter(|b| **b == b'\n').count();
            let mut expected = stored();
            expected.truncate(lines.saturating_sub(1));
            assert_eq!(open::<Row>(&path).unwrap(), expected, "cut at {length}");
            let more = row("more", length as u64, 1.0);
            append(&path, std::slice::from_ref(&more)).unwrap();
            expected.push(more);
            assert_eq!(open::<Row>(&path).unwrap(), expected, "written after a cut at {length}");
        }
    }

    #[test]
    fn a_line_that_is_no_row_is_refused_and_nothing_is_touched() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("runs.csv");
        for (text, line, message) in [
            ("name,seed,time_s\na,1,\nb,2\nc,3,1.5\n", 3, "2 columns, expected 3"),
            ("name,seed,time_s\na,1,\nb,x,2\nc,3,1.5\n", 3, "column `seed`"),
            ("name,seed,time_s\n\na,1,\nb,2,fast\n", 4, "column `time_s`"),
            ("name,seed,time_s\n\"a,1,\nb\",2,3\nc,3,1.5\n", 2, "quotation mark"),
            ("name,seed,time_s\nc,3,1.5\n\"b,2,", 0, ""),
            ("name,seed\na,1\n", 1, "missing are `time_s`"),
            ("name,seed,time_s,grip\na,1,2,3\n", 1, "unknown are `grip`"),
            ("seed,name,time_s\n1,a,2\n", 1, "their order differs"),
        ] {
            fs::write(&path, text).unwrap();
            if line == 0 {
                assert_eq!(open::<Row>(&path).unwrap(), [row("c", 3, 1.5)]);
                continue;
            }
            let error = format!("{:#}", open::<Row>(&path).unwrap_err());
            let place = format!("runs.csv, line {line}: ");
            assert!(error.contains(&place) && error.contains(message), "{text:?}: {error}");
            assert!(error.contains(CURE) && fs::read_to_string(&path).unwrap() == text, "{text:?}");
        }
        fs::write(&path, b"name,seed,time_s\na,1,2\n\xff,1,2\n").unwrap();
        let error = format!("{:#}", open::<Row>(&path).unwrap_err());
        assert!(error.contains("line 3: not UTF-8"), "{error}");
    }

    #[test]
    fn tables_put_aside_stay() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("runs.csv");
        for content in ["one", "two", "three"] {
            fs::write(&path, content).unwrap();
            put_aside(&path).unwrap();
        }
        put_aside(&path).unwrap();
        for (name, content) in [("before", "one"), ("before-2", "two"), ("before-3", "three")] {
            let aside = folder.path().join(format!("runs.{name}.csv"));
            assert_eq!(fs::read_to_string(aside).unwrap(), content);
        }
    }

    #[test]
    fn a_folder_has_one_writer() {
        let folder = tempfile::tempdir().unwrap();
        let first = Folder::lock(folder.path()).unwrap();
        let error = Folder::lock(folder.path()).unwrap_err().to_string();
        assert!(error.contains("another lmpc study"), "{error}");
        drop(first);
        Folder::lock(folder.path()).unwrap();
    }
}
