//! `runs.csv` and `laps.csv` of a study: every finished run is on disk before the next begins,
//! and a study that was interrupted goes on from there. Runs with other settings stay in the tables.

use std::path::Path;

use anyhow::Result;
use controller::LapNumber;
use serde::{Deserialize, Serialize};

use super::csv_file::{Folder, append, open, put_aside, replace};

/// The table of the runs.
const RUNS: &str = "runs.csv";
/// The table of their laps.
const LAPS: &str = "laps.csv";

/// One run.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct RunRow {
    /// Regression mode.
    pub regression: String,
    /// Nominal model.
    pub nominal: String,
    /// Cost of the control rate.
    pub control_rate_cost: f64,
    /// Bandwidth.
    pub bandwidth: f64,
    /// Seed.
    pub seed: u64,
    /// Learning laps finished.
    pub laps_completed: u32,
    /// Iteration of failure; 0 if in a warm-up lap, none if there was no failure.
    pub itf: Option<u32>,
    /// Lap time of iteration 20 \[s\].
    pub ilt20_s: Option<f64>,
    /// Fastest learning lap \[s\].
    pub best_lap_s: Option<f64>,
    /// Why it failed; empty if it did not.
    pub failure: String,
    /// Steps that fell back.
    pub fallbacks: u64,
    /// Fingerprint of everything that was set.
    pub settings: String,
}

/// One lap of a run.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct StudyLap {
    /// Regression mode.
    pub regression: String,
    /// Nominal model.
    pub nominal: String,
    /// Cost of the control rate.
    pub control_rate_cost: f64,
    /// Bandwidth.
    pub bandwidth: f64,
    /// Seed.
    pub seed: u64,
    /// Its number.
    pub lap: LapNumber,
    /// `warmup` or `learning`.
    pub kind: String,
    /// Number among the learning laps.
    pub iteration: Option<u32>,
    /// Lap time; none for the lap in which the run failed \[s\].
    pub lap_time_s: Option<f64>,
    /// Whether the whole lap was inside the track.
    pub valid: bool,
    /// Greatest v_x [m/s].
    pub v_max_mps: f64,
    /// Greatest |e_y| \[m\].
    pub e_y_max_m: f64,
    /// Steps that fell back.
    pub fallbacks: u64,
    /// Median Frobenius norm of the learned model's error.
    pub model_error_median: Option<f64>,
    /// Mean Frobenius norm of the learned model's error.
    pub model_error_mean: Option<f64>,
    /// Fingerprint of everything that was set.
    pub settings: String,
}

/// Key of a run: mode, nominal model, rate cost, bandwidth, seed, fingerprint of the settings.
type Key = (String, String, String, String, u64, String);

impl RunRow {
    /// Key of the run.
    #[must_use]
    pub fn key(&self) -> Key {
        let (cost, h) = (self.control_rate_cost.to_string(), self.bandwidth.to_string());
        let (mode, nominal) = (self.regression.clone(), self.nominal.clone());
        (mode, nominal, cost, h, self.seed, self.settings.clone())
    }
}

impl StudyLap {
    fn key(&self) -> Key {
        let (cost, h) = (self.control_rate_cost.to_string(), self.bandwidth.to_string());
        let (mode, nominal) = (self.regression.clone(), self.nominal.clone());
        (mode, nominal, cost, h, self.seed, self.settings.clone())
    }
}

/// The tables of a study on disk.
#[derive(Debug)]
pub struct Ledger {
    folder: Folder,
    /// Finished runs of this study.
    pub runs: Vec<RunRow>,
    /// Their laps.
    pub laps: Vec<StudyLap>,
    /// Runs in the table with other settings or of another version; they stay there.
    pub other_runs: Vec<RunRow>,
    other_laps: Vec<StudyLap>,
}

impl Ledger {
    /// Opens the tables in `folder`. Runs of `keys` are kept as finished; all others stay in the
    /// tables. With `fresh` the tables are put aside as `runs.before.csv` and `laps.before.csv`.
    ///
    /// # Errors
    /// If the folder cannot be read or written, another study writes to it, or a table has a line
    /// that is no row; only a torn last line is dropped.
    pub fn open(folder: &Path, keys: &[Key], fresh: bool) -> Result<Self> {
        let folder = Folder::lock(folder)?;
        let (runs_file, laps_file) = (folder.file(RUNS), folder.file(LAPS));
        if fresh {
            put_aside(&runs_file)?;
            put_aside(&laps_file)?;
        }
        let (all_runs, all_laps) = (open::<RunRow>(&runs_file)?, open::<StudyLap>(&laps_file)?);
        let (mut runs, other_runs): (Vec<_>, Vec<_>) =
            all_runs.into_iter().partition(|run| keys.contains(&run.key()));
        let (mut laps, other_laps): (Vec<_>, Vec<_>) =
            all_laps.into_iter().partition(|lap| keys.contains(&lap.key()));
        // What a kill left half written of a run is done again: its laps without the run, and a
        // run whose laps are gone.
        let found = (runs.len(), laps.len());
        runs.retain(|run| {
            let finished = |l: &&StudyLap| l.iteration.is_some() && l.lap_time_s.is_some();
            let own = laps.iter().filter(|l| l.key() == run.key());
            own.filter(finished).count() == run.laps_completed as usize
        });
        let kept: Vec<Key> = runs.iter().map(RunRow::key).collect();
        laps.retain(|lap| kept.contains(&lap.key()));
        let whole = found == (runs.len(), laps.len());
        let ledger = Self { folder, runs, laps, other_runs, other_laps };
        if !whole {
            ledger.rewrite()?;
        }
        Ok(ledger)
    }

    /// Adds a finished run: its laps first, so that a run on record is complete.
    ///
    /// # Errors
    /// If the tables cannot be written.
    pub fn add(&mut self, run: RunRow, laps: Vec<StudyLap>) -> Result<()> {
        append(&self.folder.file(LAPS), &laps)?;
        append(&self.folder.file(RUNS), std::slice::from_ref(&run))?;
        self.runs.push(run);
        self.laps.extend(laps);
        Ok(())
    }

    /// Puts the tables into the order of `keys`, whatever order the runs finished in; runs with
    /// other settings come last.
    ///
    /// # Errors
    /// If the tables cannot be written.
    pub fn sort(&mut self, keys: &[Key]) -> Result<()> {
        let place = |key: &Key| keys.iter().position(|k| k == key);
        self.runs.sort_by_key(|run| place(&run.key()));
        self.laps.sort_by_key(|lap| (place(&lap.key()), lap.lap));
        self.rewrite()
    }

    fn rewrite(&self) -> Result<()> {
        let runs: Vec<&RunRow> = self.runs.iter().chain(&self.other_runs).collect();
        let laps: Vec<&StudyLap> = self.laps.iter().chain(&self.other_laps).collect();
        replace(&self.folder.file(RUNS), &runs)?;
        replace(&self.folder.file(LAPS), &laps)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    fn run(seed: u64, settings: &str) -> RunRow {
        let words = ["error", "dynamic", settings].map(str::to_owned);
        let [regression, nominal, settings] = words;
        RunRow { regression, nominal, seed, laps_completed: 2, settings, ..RunRow::default() }
    }

    fn laps(run: &RunRow) -> Vec<StudyLap> {
        let lap = |number| StudyLap {
            regression: run.regression.clone(),
            nominal: run.nominal.clone(),
            seed: run.seed,
            lap: LapNumber::new(number),
            iteration: Some(number),
            lap_time_s: Some(4.0 + f64::from(number)),
            settings: run.settings.clone(),
            ..StudyLap::default()
        };
        vec![lap(1), lap(2)]
    }

    fn tables(folder: &Path) -> (Vec<RunRow>, Vec<StudyLap>) {
        (open(&folder.join(RUNS)).unwrap(), open(&folder.join(LAPS)).unwrap())
    }

    #[test]
    fn a_kill_at_any_byte_of_either_table_costs_one_run() {
        let folder = tempfile::tempdir().unwrap();
        let all = [run(7, "other"), run(0, "now"), run(1, "now")];
        let mut ledger = Ledger::open(folder.path(), &[], false).unwrap();
        let mut before = (0, 0);
        let length = |name| fs::metadata(folder.path().join(name)).unwrap().len() as usize;
        for run in &all {
            before = if run.seed == 1 { (length(LAPS), length(RUNS)) } else { before };
            ledger.add(run.clone(), laps(run)).unwrap();
        }
        drop(ledger);
        let bytes = |name| fs::read(folder.path().join(name)).unwrap();
        let (laps_bytes, runs_bytes) = (bytes(LAPS), bytes(RUNS));
        let keys = [all[1].key(), all[2].key()];
        let laps_cuts = (before.0..laps_bytes.len()).map(|cut| (cut, before.1));
        let runs_cuts = (before.1..runs_bytes.len()).map(|cut| (laps_bytes.len(), cut));
        for (laps_end, runs_end) in laps_cuts.chain(runs_cuts) {
            fs::write(folder.path().join(LAPS), &laps_bytes[..laps_end]).unwrap();
            fs::write(folder.path().join(RUNS), &runs_bytes[..runs_end]).unwrap();
            let mut ledger = Ledger::open(folder.path(), &keys, false).unwrap();
            assert_eq!(ledger.runs, all[1..2], "cut at {laps_end} and {runs_end}");
            ledger.add(all[2].clone(), laps(&all[2])).unwrap();
            ledger.sort(&keys).unwrap();
            let (runs, found) = tables(folder.path());
            assert_eq!(runs, [1, 2, 0].map(|i| all[i].clone()));
            assert_eq!(found, [1, 2, 0].map(|i| laps(&all[i])).concat());
        }
    }

    #[test]
    fn other_settings_stay_and_fresh_puts_the_tables_aside() {
        let folder = tempfile::tempdir().unwrap();
        let (old, new) = (run(0, "version 1"), run(0, "version 2"));
        Ledger::open(folder.path(), &[], false).unwrap().add(old.clone(), laps(&old)).unwrap();
        let mut ledger = Ledger::open(folder.path(), &[new.key()], false).unwrap();
        assert!(ledger.runs.is_empty());
        ledger.add(new.clone(), laps(&new)).unwrap();
        ledger.sort(&[new.key()]).unwrap();
        drop(ledger);
        assert_eq!(tables(folder.path()).0, [new.clone(), old.clone()]);

        // A line in the middle that is no row stops the study, and the table stays as it is.
        let text = fs::read_to_string(folder.path().join(RUNS)).unwrap();
        let broken = text.replacen("\nerror,", "\nerror;", 1);
        fs::write(folder.path().join(RUNS), &broken).unwrap();
        let error = Ledger::open(folder.path(), &[new.key()], false).unwrap_err();
        assert!(error.to_string().contains("runs.csv, line 2"), "{error}");
        assert_eq!(fs::read_to_string(folder.path().join(RUNS)).unwrap(), broken);

        let ledger = Ledger::open(folder.path(), &[new.key()], true).unwrap();
        assert!(ledger.runs.is_empty() && ledger.other_runs.is_empty());
        assert_eq!(fs::read_to_string(folder.path().join("runs.before.csv")).unwrap(), broken);
        assert!(folder.path().join("laps.before.csv").exists());
    }
}
