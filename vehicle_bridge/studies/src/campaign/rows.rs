//! The table of a campaign's runs on disk: one line a run, written as soon as it ends.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result, ensure};
use bounded_file::Limit;
use csv::StringRecord;
use serde::{Deserialize, Serialize};

use super::case::CampaignCase;
use super::file::Campaign;
use crate::csv_file::{self, Folder};

/// The table of the runs.
pub(super) const RUNS: &str = "runs.csv";
/// What the table belongs to.
const SHEET: &str = "study.toml";

/// The columns of a campaign.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CampaignColumns {
    pub(super) names: StringRecord,
    axes: usize,
}

/// Columns behind the axes and the seed.
const USUAL: [&str; 9] = [
    "failure",
    "laps_completed",
    "best_lap_s",
    "median_lap_s",
    "last_lap_s",
    "overhang_max_m",
    "fallbacks",
    "clipped",
    "clarabel_steps",
];
/// Columns behind those that the campaign records.
const LAST: [&str; 7] =
    ["limits", "fail_lap", "fail_time_s", "fail_s_m", "fail_message", "lap_times_s", "settings"];

impl CampaignColumns {
    fn new(axes: &[String], measures: &[String]) -> Self {
        let words = ["run"].into_iter().chain(axes.iter().map(String::as_str)).chain(["seed"]);
        let names = words.chain(USUAL).chain(measures.iter().map(String::as_str)).chain(LAST);
        Self { names: names.collect(), axes: axes.len() }
    }

    /// Their names in order.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.names.iter()
    }

    /// The columns of a table with this head.
    pub(super) fn of(names: StringRecord, axes: usize) -> Self {
        Self { names, axes }
    }

    /// The place of a column.
    pub(super) fn place(&self, name: &str) -> Option<usize> {
        self.names.iter().position(|known| known == name)
    }
}

impl Campaign {
    /// The columns of its table.
    #[must_use]
    pub fn columns(&self) -> CampaignColumns {
        let measures: Vec<String> = self.measures.iter().map(|m| m.name.clone()).collect();
        CampaignColumns::new(&self.axes, &measures)
    }

    /// The planned runs as a CSV table: number, axes, seed, fingerprint.
    ///
    /// # Errors
    /// None that can happen in memory.
    pub fn list(&self, cases: &[&CampaignCase]) -> Result<String> {
        let mut writer = csv::Writer::from_writer(Vec::new());
        let axes = self.axes.iter().map(String::as_str);
        writer.write_record(["run"].into_iter().chain(axes).chain(["seed", "settings"]))?;
        for case in cases {
            let (number, seed) = (case.number.to_string(), case.seed.to_string());
            let mut fields = vec![number.as_str()];
            fields.extend(case.axes.iter().map(String::as_str));
            fields.extend([seed.as_str(), case.settings.as_str()]);
            writer.write_record(fields)?;
        }
        Ok(String::from_utf8(writer.into_inner().map_err(|e| e.into_error())?)?)
    }
}

/// A finished run: its fields in the order of the columns.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CampaignRow {
    pub(super) fields: Vec<String>,
}

impl CampaignRow {
    /// The row of a run that has not begun.
    pub(super) fn new(case: &CampaignCase, columns: &CampaignColumns) -> Self {
        let mut fields = vec![String::new(); columns.names.len()];
        fields[0] = case.number.to_string();
        fields[1..=case.axes.len()].clone_from_slice(&case.axes);
        fields[1 + case.axes.len()] = case.seed.to_string();
        if let Some(last) = fields.last_mut() {
            last.clone_from(&case.settings);
        }
        Self { fields }
    }

    /// A row that another process drove, from its fields.
    ///
    /// # Errors
    /// If they are not those of a run of this campaign: another number of fields, another run,
    /// axes, seed or fingerprint.
    pub fn of(fields: Vec<String>, campaign: &Campaign, columns: &CampaignColumns) -> Result<Self> {
        let wanted = columns.names.len();
        ensure!(fields.len() == wanted, "found {} fields, expected {wanted}", fields.len());
        let row = Self { fields };
        let case = campaign.cases.iter().find(|case| case.number == row.number());
        let own =
            case.is_some_and(|case| Self::new(case, columns).key(columns) == row.key(columns));
        ensure!(
            own,
            "run {} is of another campaign or version: {:?}",
            row.fields[0],
            row.key(columns)
        );
        Ok(row)
    }

    /// Number of the run; the greatest there is for a row without one.
    #[must_use]
    pub fn number(&self) -> usize {
        self.fields[0].parse().unwrap_or(usize::MAX)
    }

    /// The fields in the order of the columns.
    pub fn fields(&self) -> impl Iterator<Item = &str> {
        self.fields.iter().map(String::as_str)
    }

    /// Sets the field of a column.
    pub(super) fn set(&mut self, columns: &CampaignColumns, name: &str, value: String) {
        if let Some(place) = columns.place(name) {
            self.fields[place] = value;
        }
    }

    /// The field of a column; empty if there is no such column.
    #[must_use]
    pub fn get(&self, columns: &CampaignColumns, name: &str) -> &str {
        columns.place(name).map_or("", |place| &self.fields[place])
    }

    /// What distinguishes runs: axes, seed and fingerprint.
    fn key(&self, columns: &CampaignColumns) -> Vec<String> {
        let mut key = self.fields[1..columns.axes + 2].to_vec();
        key.extend(self.fields.last().cloned());
        key
    }

    fn record(&self) -> StringRecord {
        StringRecord::from(self.fields.clone())
    }
}

/// What a table belongs to: shards of one campaign have the same.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Sheet {
    /// Heading.
    pub title: String,
    /// Runs of the whole campaign.
    pub runs: usize,
    /// Runs that may fail.
    pub failed_runs: usize,
    /// Keys of the axes.
    pub axes: Vec<String>,
}

impl Sheet {
    /// The sheet of a campaign.
    #[must_use]
    pub fn of(campaign: &Campaign) -> Self {
        Self {
            title: campaign.title.clone(),
            runs: campaign.cases.len(),
            failed_runs: campaign.limits.failed_runs,
            axes: campaign.axes.clone(),
        }
    }

    pub(crate) fn read(folder: &Path) -> Result<Self> {
        let path = folder.join(SHEET);
        let text = bounded_file::text(&path, Limit::SETTINGS).with_context(|| {
            format!("{} is no folder of a campaign: no {SHEET}", folder.display())
        })?;
        toml::from_str(&text).with_context(|| path.display().to_string())
    }

    pub(super) fn write(&self, folder: &Folder) -> Result<()> {
        let path = folder.file(SHEET);
        let text = toml::to_string(self)?;
        std::fs::write(&path, text).with_context(|| format!("cannot write {}", path.display()))
    }
}

/// A part of a campaign: every n-th run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shard {
    /// Which part, from 1.
    pub part: usize,
    /// Number of parts.
    pub of: usize,
}

impl Shard {
    /// Whether a run belongs to it.
    #[must_use]
    pub fn has(&self, number: usize) -> bool {
        number % self.of == self.part - 1
    }

    /// The folder of its rows within that of the campaign.
    #[must_use]
    pub fn folder(&self, out: &Path) -> PathBuf {
        let digits = self.of.to_string().len();
        out.join(format!("shard-{:0digits$}-of-{}", self.part, self.of))
    }
}

/// The finished runs of a campaign.
#[derive(Debug)]
pub struct Rows {
    folder: Folder,
    columns: CampaignColumns,
    /// Runs of this campaign.
    pub rows: Vec<CampaignRow>,
    /// Runs in the table with other settings or of other versions; they stay there, without a number.
    pub others: Vec<CampaignRow>,
}

impl Rows {
    /// Opens the table in `folder`: runs of `cases` in it count as done, all others stay in the
    /// table. With `fresh` the table is put aside as `runs.before.csv`.
    ///
    /// # Errors
    /// If the folder cannot be read or written, another study writes to it, or the table has a line
    /// that is no row or other columns; only a torn last line is dropped.
    pub fn open(
        folder: &Path,
        campaign: &Campaign,
        cases: &[&CampaignCase],
        fresh: bool,
    ) -> Result<Self> {
        let folder = Folder::lock(folder)?;
        let (columns, path) = (campaign.columns(), folder.file(RUNS));
        if fresh {
            csv_file::put_aside(&path)?;
        }
        let found = csv_file::open_records(&path, &columns.names)?;
        // Draws of whole numbers may give two runs the same axes: either row will do for either.
        let mut wanted: BTreeMap<Vec<String>, VecDeque<String>> = BTreeMap::new();
        for case in cases {
            let row = CampaignRow::new(case, &columns);
            wanted.entry(row.key(&columns)).or_default().push_back(case.number.to_string());
        }
        let (mut rows, mut others, mut changed) = (Vec::new(), Vec::new(), false);
        for record in found {
            let mut row = CampaignRow { fields: record.iter().map(str::to_owned).collect() };
            let number = wanted.get_mut(&row.key(&columns)).and_then(VecDeque::pop_front);
            let own = number.is_some();
            let (number, limits) =
                (number.unwrap_or_default(), campaign.limits.broken(&columns, &row));
            changed |= row.fields[0] != number || row.get(&columns, "limits") != limits;
            row.fields[0] = number;
            row.set(&columns, "limits", limits);
            if own { &mut rows } else { &mut others }.push(row);
        }
        let rows = Self { folder, columns, rows, others };
        Sheet::of(campaign).write(&rows.folder)?;
        if changed {
            rows.rewrite()?;
        }
        Ok(rows)
    }

    /// Numbers of the runs that are done.
    #[must_use]
    pub fn done(&self) -> BTreeSet<usize> {
        self.rows.iter().filter_map(|row| row.fields[0].parse().ok()).collect()
    }

    /// The columns.
    #[must_use]
    pub fn columns(&self) -> &CampaignColumns {
        &self.columns
    }

    /// Adds a finished run.
    ///
    /// # Errors
    /// If the table cannot be written.
    pub fn add(&mut self, row: CampaignRow) -> Result<()> {
        let path = self.folder.file(RUNS);
        csv_file::append_records(&path, &self.columns.names, &[row.record()])?;
        self.rows.push(row);
        Ok(())
    }

    /// Puts the runs into the order of their numbers, whatever order they finished in.
    ///
    /// # Errors
    /// If the table cannot be written.
    pub fn sort(&mut self) -> Result<()> {
        self.rows.sort_by_key(|row| row.fields[0].parse::<usize>().ok());
        self.rewrite()
    }

    fn rewrite(&self) -> Result<()> {
        let all: Vec<StringRecord> =
            self.rows.iter().chain(&self.others).map(CampaignRow::record).collect();
        csv_file::replace_records(&self.folder.file(RUNS), &self.columns.names, &all)
    }
}
