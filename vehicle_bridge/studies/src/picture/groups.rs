//! Groups of runs along a column: its values, or ranges of them where they are many numbers.

use anyhow::{Result, ensure};

use super::table::RunTable;
use crate::campaign::{ranges, short};

/// A column with more values than this is divided into ranges.
pub(super) const MOST: usize = 6;

/// The groups of a column.
#[derive(Debug, Clone)]
pub(super) struct Groups {
    /// Name of each group; one empty name without a column.
    pub(super) names: Vec<String>,
    /// The group of each run.
    pub(super) of: Vec<usize>,
}

impl Groups {
    /// The groups along `column`, or one group of all runs.
    pub(super) fn new(table: &RunTable, column: Option<&str>) -> Result<Self> {
        let Some(column) = column else {
            return Ok(Self { names: vec![String::new()], of: vec![0; table.runs()] });
        };
        let (values, fields) = (table.values(column)?, table.column(column)?);
        let numbers: Option<Vec<f64>> = values.iter().map(|text| text.parse().ok()).collect();
        if let Some(numbers) = numbers.filter(|numbers| numbers.len() > MOST) {
            let ranges = ranges(numbers);
            let inside = |text: &str| {
                let value: f64 = text.parse().unwrap_or(f64::NAN);
                ranges.iter().position(|(_, to)| value <= *to).unwrap_or(0)
            };
            return Ok(Self {
                names: ranges
                    .iter()
                    .map(|(a, b)| format!("{} to {}", short(*a), short(*b)))
                    .collect(),
                of: fields.iter().map(|text| inside(text)).collect(),
            });
        }
        ensure!(
            values.len() <= 4 * MOST,
            "`{column}` has {} different words, expected at most {}: filter the table first",
            values.len(),
            4 * MOST
        );
        let place = |text: &&str| values.iter().position(|value| value == text).unwrap_or(0);
        Ok(Self {
            names: values.iter().map(|text| (*text).to_owned()).collect(),
            of: fields.iter().map(place).collect(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn many_numbers_become_ranges_that_hold_every_run() {
        let lines: String = (0..23).map(|i| format!("{},{i}\n", 0.5 * f64::from(i))).collect();
        let table = RunTable::parse(&format!("mu,seed\n{lines}")).unwrap();
        let groups = Groups::new(&table, Some("mu")).unwrap();
        assert_eq!(groups.names.len(), 5);
        assert!(groups.names[0].starts_with("0 to "), "{:?}", groups.names);
        for group in 0..5 {
            let size = groups.of.iter().filter(|g| **g == group).count();
            assert!((4..=5).contains(&size), "{size}");
        }
        assert_eq!(groups.of[22], 4);
        assert_eq!(Groups::new(&table, None).unwrap().names, [""]);
    }
}
