//! `runs.csv` and `laps.csv` of a study: every finished run is on disk before the next begins,
//! and a study that was interrupted goes on from there.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result};
use serde::{Deserialize, Serialize};

use super::csv_file::{append, read, replace};

/// One run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
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
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
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
    /// Number of the lap.
    pub lap: u32,
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

/// Key of a run.
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
    folder: PathBuf,
    /// Finished runs.
    pub runs: Vec<RunRow>,
    /// Their laps.
    pub laps: Vec<StudyLap>,
}

impl Ledger {
    /// Opens the tables in `folder`, keeping the runs for which `wanted` holds. What a kill left
    /// half written is dropped.
    ///
    /// # Errors
    /// If the folder cannot be read or written.
    pub fn open(folder: &Path, wanted: impl Fn(&RunRow) -> bool) -> Result<Self> {
        fs::create_dir_all(folder)
            .with_context(|| format!("cannot make the folder {}", folder.display()))?;
        let mut runs: Vec<RunRow> = read(&folder.join("runs.csv"))?;
        runs.retain(wanted);
        let keys: Vec<Key> = runs.iter().map(RunRow::key).collect();
        let mut laps: Vec<StudyLap> = read(&folder.join("laps.csv"))?;
        laps.retain(|lap| keys.contains(&lap.key()));
        // A run whose laps were lost is run again.
        runs.retain(|run| {
            let finished = |l: &&StudyLap| l.iteration.is_some() && l.lap_time_s.is_some();
            let own = laps.iter().filter(|l| l.key() == run.key());
            own.filter(finished).count() == run.laps_completed as usize
        });
        let ledger = Self { folder: folder.to_owned(), runs, laps };
        ledger.rewrite()?;
        Ok(ledger)
    }

    /// Adds a finished run: its laps first, so that a run on record is complete.
    ///
    /// # Errors
    /// If the tables cannot be written.
    pub fn add(&mut self, run: RunRow, laps: Vec<StudyLap>) -> Result<()> {
        append(&self.folder.join("laps.csv"), &laps)?;
        append(&self.folder.join("runs.csv"), std::slice::from_ref(&run))?;
        self.runs.push(run);
        self.laps.extend(laps);
        Ok(())
    }

    /// Puts the tables into the order of `keys`, whatever order the runs finished in.
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
        replace(&self.folder.join("runs.csv"), &self.runs)?;
        replace(&self.folder.join("laps.csv"), &self.laps)
    }
}
