//! A table of runs from any study: campaigns, cars on tracks, those of the paper.

use std::path::Path;

use anyhow::{Context as _, Result, bail, ensure};
use bounded_file::Limit;

use crate::campaign::{Sheet, distinct};

/// Columns between the axes and what was measured.
const SEED: &str = "seed";

/// The runs of a study as text.
#[derive(Debug, Clone)]
pub struct RunTable {
    /// Heading.
    pub title: String,
    /// Columns that distinguish the runs beside the seed.
    pub axes: Vec<String>,
    names: Vec<String>,
    rows: Vec<Vec<String>>,
}

impl RunTable {
    /// Reads `runs.csv` of a folder, or a table by its name. Lines of a campaign without a number,
    /// which are of other settings, are left out.
    ///
    /// # Errors
    /// If there is no table, or it is no CSV, or has no run.
    pub fn read(path: &Path) -> Result<Self> {
        let file = if path.is_dir() { path.join("runs.csv") } else { path.to_owned() };
        if path.is_dir() && !file.exists() {
            bail!(
                "no runs.csv in {}: expected the folder of a study; shards are merged first, \
                 with `lmpc study merge`",
                path.display()
            );
        }
        let text = bounded_file::text(&file, Limit::RUNS)?;
        let mut table = Self::parse(&text).with_context(|| file.display().to_string())?;
        let sheet = file.parent().map(Sheet::read);
        if let Some(Ok(sheet)) = sheet {
            table.title = sheet.title;
            table.axes = sheet.axes;
        }
        Ok(table)
    }

    /// The table of a CSV text; what stands before the column `seed` are axes.
    ///
    /// # Errors
    /// If it is no CSV or has no run.
    pub fn parse(text: &str) -> Result<Self> {
        let mut reader = csv::Reader::from_reader(text.as_bytes());
        let names: Vec<String> = reader.headers()?.iter().map(str::to_owned).collect();
        let number = names.iter().position(|name| name == "run");
        let mut rows = Vec::new();
        for record in reader.records() {
            let row: Vec<String> = record?.iter().map(str::to_owned).collect();
            if number.is_none_or(|number| !row[number].is_empty()) {
                rows.push(row);
            }
        }
        ensure!(!rows.is_empty(), "no run in the table");
        let axes = names.iter().take_while(|name| *name != SEED).filter(|name| *name != "run");
        let axes =
            if names.iter().any(|name| name == SEED) { axes.cloned().collect() } else { vec![] };
        Ok(Self { title: "Runs".to_owned(), axes, names, rows })
    }

    /// Names of the columns.
    #[must_use]
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// Number of runs.
    #[must_use]
    pub fn runs(&self) -> usize {
        self.rows.len()
    }

    /// Whether there is a column.
    #[must_use]
    pub fn has(&self, name: &str) -> bool {
        self.names.iter().any(|known| known == name)
    }

    /// The fields of a column.
    ///
    /// # Errors
    /// If there is no such column; the message lists those that there are.
    pub fn column(&self, name: &str) -> Result<Vec<&str>> {
        let place = self.names.iter().position(|known| known == name);
        let place = place.with_context(|| {
            format!("no column `{name}`, expected one of {}", self.names.join(", "))
        })?;
        Ok(self.rows.iter().map(|row| row[place].as_str()).collect())
    }

    /// Which runs failed; none where the table has no such column.
    #[must_use]
    pub fn failed(&self) -> Vec<bool> {
        let failures = self.column("failure").unwrap_or_default();
        let mut failed: Vec<bool> = failures.iter().map(|text| !text.is_empty()).collect();
        failed.resize(self.rows.len(), false);
        failed
    }

    /// The different values of a column: numbers by size, words in the order of their first run.
    ///
    /// # Errors
    /// If there is no such column.
    pub fn values(&self, name: &str) -> Result<Vec<&str>> {
        Ok(places(self.column(name)?.into_iter()).0)
    }

    /// The axes along which the runs differ.
    #[must_use]
    pub fn varied(&self) -> Vec<&str> {
        let several = |axis: &&str| self.values(axis).is_ok_and(|values| values.len() > 1);
        self.axes.iter().map(String::as_str).filter(several).collect()
    }
}

/// The different texts, and their numbers if all are: numbers by size, words in the order of their first
/// appearance.
pub(super) fn places<'a>(texts: impl Iterator<Item = &'a str>) -> (Vec<&'a str>, Option<Vec<f64>>) {
    let texts = distinct(texts);
    let numbers: Option<Vec<f64>> = texts.iter().map(|text| number(text)).collect();
    let Some(numbers) = numbers else { return (texts, None) };
    let mut both: Vec<(&str, f64)> = texts.into_iter().zip(numbers).collect();
    both.sort_by(|a, b| a.1.total_cmp(&b.1));
    let (texts, numbers) = both.into_iter().unzip();
    (texts, Some(numbers))
}

/// A field as a finite number.
pub(super) fn number(text: &str) -> Option<f64> {
    text.parse().ok().filter(|value: &f64| value.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_columns_before_the_seed_are_axes_and_lines_without_a_number_stay_out() {
        let text = "run,plant.mu,car,seed,failure,best_lap_s\n0,0.9,b,0,,5\n1,0.10,a,0,spin,\n\
                    ,0.5,a,0,,4\n2,0.9,a,1,,6\n";
        let table = RunTable::parse(text).unwrap();
        assert_eq!((table.axes.clone(), table.runs()), (vec!["plant.mu".into(), "car".into()], 3));
        assert_eq!(table.values("plant.mu").unwrap(), ["0.10", "0.9"]);
        assert_eq!(table.values("car").unwrap(), ["b", "a"]);
        assert_eq!(table.failed(), [false, true, false]);
        let error = table.column("grip").unwrap_err().to_string();
        assert!(error.contains("no column `grip`") && error.contains("plant.mu"), "{error}");
        assert!(RunTable::parse("a,b\n").is_err());
    }
}
