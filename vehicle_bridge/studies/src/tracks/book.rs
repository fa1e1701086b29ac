//! The runs on disk: every finished run is a line of `runs.csv` before the next is waited for.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result};

use super::case::Case;
use super::drive::Run;
use super::row::{Key, Row};
use crate::csv_file::{append, read, replace};
use racing::files;

/// The table of the runs.
const RUNS: &str = "runs.csv";
/// What becomes of it when a study begins anew.
const BEFORE: &str = "runs.before.csv";
/// The folder of the last steps of failed runs.
const FAILURES: &str = "failures";

/// The finished runs of a matrix.
#[derive(Debug)]
pub struct Book {
    folder: PathBuf,
    /// Runs of this matrix.
    pub rows: Vec<Row>,
    /// Runs in the table that belong to other cells; they stay there.
    others: Vec<Row>,
}

impl Book {
    /// Opens the table in `folder`. With `resume` the runs of `keys` in it are kept, and so are
    /// runs of other cells; a run of this matrix with other settings is dropped. Without, the
    /// table is put aside as `runs.before.csv`.
    ///
    /// # Errors
    /// If the folder cannot be read or written.
    pub fn open(folder: &Path, keys: &[Key], resume: bool) -> Result<Self> {
        fs::create_dir_all(folder)
            .with_context(|| format!("cannot make the folder {}", folder.display()))?;
        let path = folder.join(RUNS);
        if !resume && path.exists() {
            fs::rename(&path, folder.join(BEFORE))
                .with_context(|| format!("cannot put {} aside", path.display()))?;
        }
        let mut wanted: Vec<&Key> = keys.iter().collect();
        wanted.sort();
        let all: Vec<Row> = read(&path)?;
        let (rows, others): (Vec<Row>, Vec<Row>) =
            all.into_iter().partition(|row| wanted.binary_search(&&row.key()).is_ok());
        let others = others
            .into_iter()
            .filter(|row| !keys.iter().any(|key| key.is_same_run(&row.key())))
            .collect();
        let book = Self { folder: folder.to_owned(), rows, others };
        book.rewrite()?;
        Ok(book)
    }

    /// Adds a finished run of a case. One that failed leaves its last steps, and its track if
    /// that was generated.
    ///
    /// # Errors
    /// If a file cannot be written.
    pub fn add(&mut self, run: Run, case: &Case) -> Result<()> {
        if run.row.failed() {
            self.keep_failure(&run, case)?;
        }
        append(&self.folder.join(RUNS), std::slice::from_ref(&run.row))?;
        self.rows.push(run.row);
        Ok(())
    }

    fn keep_failure(&self, run: &Run, case: &Case) -> Result<()> {
        let folder = self.folder.join(FAILURES);
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
    pub fn rate(&mut self, cases: &[Case]) {
        let mut places: Vec<&Case> = cases.iter().collect();
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
    pub fn sort(&mut self, keys: &[Key]) -> Result<()> {
        let mut places: Vec<(&Key, usize)> = keys.iter().zip(0..).collect();
        places.sort();
        self.rows.sort_by_cached_key(|row| {
            let key = row.key();
            places.binary_search_by(|(k, _)| (*k).cmp(&key)).map(|i| places[i].1).ok()
        });
        self.rewrite()
    }

    fn rewrite(&self) -> Result<()> {
        let all: Vec<&Row> = self.rows.iter().chain(&self.others).collect();
        replace(&self.folder.join(RUNS), &all)
    }
}

/// The file of a failed run's last steps.
#[must_use]
pub(super) fn trace_name(row: &Row) -> String {
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

    fn key(track: &str, seed: u64, settings: &str) -> Key {
        let (car, track, plant) = ("barc".to_owned(), track.to_owned(), "none".to_owned());
        Key { car, track, plant, seed, settings: settings.to_owned() }
    }

    fn case(key: &Key) -> Case {
        let track = std::sync::Arc::new(Track::builtin("l").unwrap());
        let car = CarParams::builtin("barc").unwrap();
        let options = RaceOptions::new(controller::Config::default(), car, track);
        Case { key: key.clone(), optimum: Some(3.0), generated: false, options }
    }

    fn run(key: &Key) -> Run {
        let row = Row { best_lap_s: Some(3.9), fail_message: "a, \"b\"".into(), ..Row::new(key) };
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
        let mut book = Book::open(folder.path(), &keys, true).unwrap();
        assert_eq!(book.rows, [run(&one).row]);
        book.add(run(&keys[2]), &case(&keys[2])).unwrap();
        book.add(run(&keys[1]), &case(&keys[1])).unwrap();
        book.rate(&[case(&keys[0])]);
        assert_eq!(book.rows[0].ratio, Some(1.3), "measured against what is known now");
        book.sort(&keys).unwrap();
        let rows: Vec<Key> = read::<Row>(&path).unwrap().iter().map(Row::key).collect();
        assert_eq!(rows, [&keys[..], &[other]].concat(), "other cells stay in the table");

        let book = Book::open(folder.path(), &keys, false).unwrap();
        assert!(book.rows.is_empty() && folder.path().join(BEFORE).exists());
    }
}
