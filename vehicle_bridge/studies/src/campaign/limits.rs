//! What makes a campaign fail.

use anyhow::{Context as _, Result, ensure};
use serde::Deserialize;
use toml::{Table, Value};

use super::rows::{CampaignColumns, CampaignRow};

/// The key of the number of runs that may fail.
const FAILED_RUNS: &str = "failed_runs";

/// Limits of a campaign.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Limits {
    /// Runs that may fail.
    pub failed_runs: usize,
    columns: Vec<Limit>,
}

#[derive(Debug, Clone, PartialEq)]
struct Limit {
    column: String,
    bounds: Bounds,
}

#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
struct Bounds {
    least: Option<f64>,
    most: Option<f64>,
}

impl Limits {
    pub(super) fn parse(table: &Table, columns: &CampaignColumns) -> Result<Self> {
        let mut limits = Self::default();
        for (name, value) in table {
            if name == FAILED_RUNS {
                let count = value.as_integer().and_then(|count| usize::try_from(count).ok());
                limits.failed_runs = count.with_context(|| {
                    format!("limits, {FAILED_RUNS}: found {value}, expected a count")
                })?;
                continue;
            }
            ensure!(
                columns.place(name).is_some(),
                "limits: there is no column `{name}`, expected {FAILED_RUNS} or one of {}",
                columns.names.iter().collect::<Vec<_>>().join(", ")
            );
            let bounds: Bounds = Value::try_into(value.clone())
                .with_context(|| format!("limits, `{name}`: expected `least` or `most`"))?;
            let any = bounds.least.is_some() || bounds.most.is_some();
            ensure!(any, "limits, `{name}`: expected `least` or `most`");
            limits.columns.push(Limit { column: name.clone(), bounds });
        }
        Ok(limits)
    }

    /// The columns of a row that are beyond their limits, separated by blanks. A column without a
    /// value is beyond; a run that failed is counted as that and not judged.
    #[must_use]
    pub(super) fn broken(&self, columns: &CampaignColumns, row: &CampaignRow) -> String {
        if !row.get(columns, "failure").is_empty() {
            return String::new();
        }
        let beyond = |limit: &&Limit| {
            let value = row.get(columns, &limit.column).parse::<f64>();
            let inside = |value: f64| {
                limit.bounds.least.is_none_or(|least| value >= least)
                    && limit.bounds.most.is_none_or(|most| value <= most)
            };
            !value.is_ok_and(inside)
        };
        let names = self.columns.iter().filter(beyond).map(|limit| limit.column.as_str());
        names.collect::<Vec<_>>().join(" ")
    }
}
