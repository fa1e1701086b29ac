//! The shards of a campaign in one table.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result, bail, ensure};
use csv::StringRecord;

use super::rows::{CampaignColumns, CampaignRow, RUNS, Sheet};
use crate::csv_file::{self, Folder};

/// What came of a merge.
#[derive(Debug)]
pub struct Merged {
    /// What the rows belong to.
    pub sheet: Sheet,
    /// The columns.
    pub columns: CampaignColumns,
    /// The rows in the order of the runs.
    pub rows: Vec<CampaignRow>,
    /// Numbers of the runs that no shard has.
    pub missing: Vec<usize>,
}

/// Merges the tables of `folders` into one in `out`. A run that several of them have must have the
/// same row in each; rows of other settings stay where they are.
///
/// # Errors
/// If a folder has no table, folders belong to different campaigns, two have different rows of a run,
/// or the table cannot be written.
pub fn merge(folders: &[PathBuf], out: &Path) -> Result<Merged> {
    let first = folders.first().context("no folder to merge")?;
    let sheet = Sheet::read(first)?;
    let mut columns: Option<(StringRecord, &Path)> = None;
    let mut found: BTreeMap<usize, (StringRecord, &Path)> = BTreeMap::new();
    for folder in folders {
        let other = Sheet::read(folder)?;
        let (a, b) = (first.display(), folder.display());
        ensure!(other == sheet, "{a} and {b} are of different campaigns: {sheet:?}, {other:?}");
        let path = folder.join(RUNS);
        let Some(head) = csv_file::head(&path)? else { continue };
        if let Some((known, of)) = columns.as_ref().filter(|(known, _)| *known != head) {
            bail!(
                "{} and {b} have different columns: {}, {}",
                of.display(),
                list(known),
                list(&head)
            );
        }
        for record in csv_file::open_records(&path, &head)? {
            let Ok(number) = record[0].parse::<usize>() else { continue };
            match found.get(&number) {
                Some((known, of)) if *known != record => bail!(
                    "{} and {b} have different rows of run {number}: shards of another version or of \
                     a changed file",
                    of.display()
                ),
                _ => found.insert(number, (record, folder)),
            };
        }
        columns.get_or_insert((head, folder));
    }
    let (names, _) = columns.context("no shard has a finished run")?;
    let beyond = found.keys().find(|number| **number >= sheet.runs);
    ensure!(beyond.is_none(), "run {} of {} runs", beyond.unwrap_or(&0), sheet.runs);
    let folder = Folder::lock(out)?;
    let records: Vec<StringRecord> = found.values().map(|(record, _)| record.clone()).collect();
    csv_file::replace_records(&folder.file(RUNS), &names, &records)?;
    sheet.write(&folder)?;
    let missing = (0..sheet.runs).filter(|number| !found.contains_key(number)).collect();
    let fields = |record: &StringRecord| record.iter().map(str::to_owned).collect();
    let rows = records.iter().map(|record| CampaignRow { fields: fields(record) }).collect();
    let columns = CampaignColumns::of(names, sheet.axes.len());
    Ok(Merged { sheet, columns, rows, missing })
}

fn list(columns: &StringRecord) -> String {
    columns.iter().collect::<Vec<_>>().join(",")
}
