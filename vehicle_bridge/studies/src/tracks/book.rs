//! The runs on disk: every finished run is a line of `runs.csv` before the next is waited for.

use std::fs;
use std::path::Path;

use anyhow::{Context as _, Result};

use super::case::TracksCase;
use super::drive::Run;
use super::row::{TracksKey, TracksRow};
use crate::csv_file::{Folder, append, open, put_aside, replace};
use racing::files;

/// The table of the runs.
const RUNS: &str = "runs.csv";
/// The folder of the last steps of failed runs.
const FAILURES: &str = "failures";

/// The finished runs of a matrix.
#[derive(Debug)]
pub struct Book {
    folder: Folder,
    /// Runs of this matrix.
    pub rows: Vec<TracksRow>,
    /// Runs in the table of other cells, settings or versions; they stay there.
    pub others: Vec<TracksRow>,
}

impl Book {
    /// Opens the table in `folder`. With `resume` the runs of `keys` in it count as done, and all
    /// others stay in the table. Without, the table is put aside as `runs.before.csv`.
    ///
    /// # Errors
    /// If the folder cannot be read or written, another study writes to it, or the table has a line
    /// that is no row; only a torn last line is dropped.
    pub fn open(folder: &Path, keys: &[TracksKey], resume: bool) -> Result<Self> {
        let folder = Folder::lock(folder)?;
        let path = folder.file(RUNS);
        if !resume {
            put_aside(&path)?;
        }
        let mut wanted: Vec<&TracksKey> = keys.iter().collect();
        wanted.sort();
        let (rows, others): (Vec<TracksRow>, Vec<TracksRow>) = open::<TracksRow>(&path)?
            .into_iter()
            .partition(|row| wanted.binary_search(&&row.key()).is_ok());
        Ok(Self { folder, rows, others })
    }

    /// Adds a finished run of a case. One that failed leaves its last steps, and its track if
    /// that was generated.
    ///
    /// # Errors
    /// If a file cannot be written.
    pub fn add(&mut self, run: Run, case: &TracksCase) -> Result<()> {
        if run.row.failed() {
            self.keep_failure(&run, case)?;
        }
        append(&self.folder.file(RUNS), std::slice::from_ref(&run.row))?;
        self.rows.push(run.row);
        Ok(())
    }

    fn keep_failure(&self, run: &Run, case: &TracksCase) -> Result<()> {
        let folder = self.folder.file(FAILURES);
        let failed = |path: &Path| format!("cannot write {}", path.display());
        fs::create_dir_all(&folder).with_context(|| failed(&folder))?;
        if !run.last_steps.is_empty() {
            let path = folder.join(trace_name(&run.row));
            files::write_trajectory(&path, &run.last_steps).with_context(|| failed(&path))?;
        }
        if let Some(text) = case.track().to_toml().filter(|_| case.generated) {
            let path = folder.join(format!("{}.toml", case.track().name()));
            fs::write(&path, text).with_context(|| failed(&path))?;
        }
        Ok(())
    }

    /// Measures the kept runs against the optima known now.
    pub fn rate(&mut self, cases: &[TracksCase]) {
        let mut places: Vec<&TracksCase> = cases.iter().collect();
        places.sort_by(|a, b| a.key.cmp(&b.key));
        for row in &mut self.rows {
            let key = row.key();
            if let Ok(i) = places.binary_search_by(|case| case.key.cmp(&key)) {
                row.rate(places[i].optimum);
            }
        }
    }

    /// Puts the table into the order of `keys`, whatever order the runs finished in.
    ///
    /// # Errors
    /// If the table cannot be written.
    pub fn sort(&mut self, keys: &[TracksKey]) -> Result<()> {
        let mut places: Vec<(&TracksKey, usize)> = keys.iter().zip(0..).collect();
        places.sort();
        self.rows.sort_by_cached_key(|row| {
            let key = row.key();
            places.binary_search_by(|(k, _)| (*k).cmp(&key)).map(|i| places[i].1).ok()
        });
        self.rewrite()
    }

    fn rewrite(&self) -> Result<()> {
        let all: Vec<&TracksRow> = self.rows.iter().chain(&self.others).collect();
        replace(&self.folder.file(RUNS), &all)
    }
}

/// The file of a failed run's last steps.
#[must_use]
pub(super) fn trace_name(row: &TracksRow) -> String {
    let plain = |text: &str| -> String {
        let keep = |c: char| c.is_alphanumeric() || "-_.=".contains(c);
        text.chars().map(|c| if keep(c) { c } else { '_' }).collect()
    };
    let words = [&row.car, &row.track, &row.plant].map(|word| plain(word));
    format!("{}-{}.csv", words.join("-"), row.seed)
}

#[cfg(test)]
mod tests {
    use super::*;
    use racing::RaceOptions;
    use vehicle_model::{CarParams, Track};

    fn key(track: &str, seed: u64, settings: &str) -> TracksKey {
        let (car, track, plant) = ("barc".to_owned(), track.to_owned(), "none".to_owned());
        TracksKey { car, track, plant, seed, settings: settings.to_owned() }
    }

    fn case(key: &TracksKey) -> TracksCase {
        let track = std::sync::Arc::new(Track::builtin("l").unwrap());
        let car = CarParams::builtin("barc").unwrap();
        let options = RaceOptions::new(controller::Config::default(), car, track);
        TracksCase { key: key.clone(), optimum: Some(3.0), generated: false, options }
    }

    fn run(key: &TracksKey) -> Run {
        let row = TracksRow {
            best_lap_s: Some(3.9),
            fail_message: "a, \"b\"".into(),
            ..TracksRow::new(key)
        };
        Run { row, last_steps: Vec::new() }
    }

    #[test]
    fn resuming_keeps_what_has_the_same_settings() {
        let folder = tempfile::tempdir().unwrap();
        let (one, two, other) = (key("l", 0, "a"), key("l", 1, "a"), key("m", 0, "a"));
        let mut book = Book::open(folder.path(), &[], false).unwrap();
        for key in [&other, &two, &one] {
            book.add(run(key), &case(key)).unwrap();
        }
        // A kill in mid-line.
        let path = folder.path().join(RUNS);
        let torn = fs::read_to_string(&path).unwrap() + "barc,l,none,7,";
        fs::write(&path, torn).unwrap();

        let keys = [one.clone(), key("l", 1, "b"), key("l", 2, "b")];
        drop(book);
        let mut book = Book::open(folder.path(), &keys, true).unwrap();
        assert_eq!(book.rows, [run(&one).row]);
        book.add(run(&keys[2]), &case(&keys[2])).unwrap();
        book.add(run(&keys[1]), &case(&keys[1])).unwrap();
        book.rate(&[case(&keys[0])]);
        assert_eq!(book.rows[0].ratio, Some(1.3), "measured against what is known now");
        book.sort(&keys).unwrap();
        drop(book);
        let text = fs::read_to_string(&path).unwrap();
        let rows: Vec<TracksKey> =
            open::<TracksRow>(&path).unwrap().iter().map(TracksRow::key).collect();
        let kept = [&keys[..], &[other, two]].concat();
        assert_eq!(rows, kept, "other cells and other settings stay in the table");

        // A line in the middle that is no row stops the study, and the table stays as it is.
        let broken = text.replacen("\nbarc,", "\nbarc;", 1);
        fs::write(&path, &broken).unwrap();
        let error = Book::open(folder.path(), &keys, true).unwrap_err().to_string();
        assert!(error.contains("runs.csv, line 2: "), "{error}");
        assert_eq!(fs::read_to_string(&path).unwrap(), broken);

        let book = Book::open(folder.path(), &keys, false).unwrap();
        assert!(book.rows.is_empty());
        assert_eq!(fs::read_to_string(folder.path().join("runs.before.csv")).unwrap(), broken);
    }
}
