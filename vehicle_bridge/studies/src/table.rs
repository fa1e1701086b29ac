//! The study's table, with the paper's numbers.

use comfy_table::{Cell as Column, CellAlignment, Table, presets};
use serde::Serialize;

use super::definition::{Cell, Definition, Paper};
use super::ledger::RunRow;
use racing::record::{mean, median};

/// One cell summed up.
#[derive(Debug, Clone, Serialize)]
pub struct CellSummary {
    /// The cell.
    #[serde(flatten)]
    pub cell: Cell,
    /// Runs in it.
    pub runs: usize,
    /// Runs that failed.
    pub failed: usize,
    /// Mean iteration of failure of those.
    pub itf_mean: Option<f64>,
    /// Median lap time of iteration 20 of the others \[s\].
    pub ilt20_median_s: Option<f64>,
    /// Fastest and slowest lap time of iteration 20 \[s\].
    pub ilt20_range_s: Option<[f64; 2]>,
    /// Median of the best laps \[s\].
    pub best_median_s: Option<f64>,
    /// Steps that fell back in all runs.
    pub fallbacks: u64,
    /// What the paper reports.
    pub paper: Option<String>,
}

/// Sums up every cell, in the order of `cells`.
#[must_use]
pub fn summarize(study: &Definition, cells: &[Cell], runs: &[RunRow]) -> Vec<CellSummary> {
    cells.iter().map(|cell| of_cell(study, cell, runs)).collect()
}

fn of_cell(study: &Definition, cell: &Cell, runs: &[RunRow]) -> CellSummary {
    let own: Vec<&RunRow> = runs.iter().filter(|run| belongs(run, cell)).collect();
    let known = |value: f64| value.is_finite().then_some(value);
    let failures: Vec<f64> = own.iter().filter_map(|r| r.itf).map(f64::from).collect();
    let mut ilt: Vec<f64> = own.iter().filter_map(|r| r.ilt20_s).collect();
    let mut best: Vec<f64> = own.iter().filter_map(|r| r.best_lap_s).collect();
    let middle = median(&mut ilt);
    CellSummary {
        cell: cell.clone(),
        runs: own.len(),
        failed: failures.len(),
        itf_mean: known(mean(&failures)),
        ilt20_median_s: known(middle),
        // Sorted by the median.
        ilt20_range_s: ilt.first().zip(ilt.last()).map(|(a, b)| [*a, *b]),
        best_median_s: known(median(&mut best)),
        fallbacks: own.iter().map(|r| r.fallbacks).sum(),
        paper: study.paper(cell).map(paper_text),
    }
}

/// Whether a run is one of a cell.
#[must_use]
pub(super) fn belongs(run: &RunRow, cell: &Cell) -> bool {
    run.regression == cell.regression
        && run.nominal == cell.nominal
        && run.control_rate_cost.to_bits() == cell.control_rate_cost.to_bits()
        && run.bandwidth.to_bits() == cell.bandwidth.to_bits()
}

fn paper_text(paper: &Paper) -> String {
    let mut parts = Vec::new();
    if let Some(time) = paper.lap_time_s {
        parts.push(format!("{time} s"));
    }
    match (paper.failed_runs, paper.failed_in) {
        (Some(runs), Some(lap)) if runs > 0 => parts.push(format!("{runs} of 10 fail, lap {lap}")),
        (Some(_), _) => parts.push("none fails".to_owned()),
        (None, Some(lap)) => parts.push(format!("fails in lap {lap}")),
        (None, None) => {}
    }
    parts.join(", ")
}

/// Head of the table, on the terminal and on the page.
pub(super) const HEAD: [&str; 11] = [
    "regression",
    "rate cost",
    "h",
    "runs",
    "failed",
    "in lap",
    "lap 20 [s]",
    "range [s]",
    "best [s]",
    "fell back",
    "paper",
];

/// The table for the terminal.
#[must_use]
pub fn text_table(summaries: &[CellSummary]) -> String {
    let mut table = Table::new();
    table.load_style(presets::UTF8_HORIZONTAL_ONLY);
    table.set_header(HEAD);
    for row in summaries.iter().map(cells_of) {
        let cells = row.into_iter().enumerate().map(|(i, text)| {
            let side = if i == 0 || i == 10 { CellAlignment::Left } else { CellAlignment::Right };
            Column::new(text).set_alignment(side)
        });
        table.add_row(cells.collect::<Vec<_>>());
    }
    table.to_string()
}

/// The columns of a cell's row, as text.
#[must_use]
pub(super) fn cells_of(s: &CellSummary) -> Vec<String> {
    let number = |value: Option<f64>, digits: usize| {
        value.map_or("–".to_owned(), |v| format!("{v:.digits$}"))
    };
    vec![
        s.cell.regression.clone(),
        s.cell.control_rate_cost.to_string(),
        s.cell.bandwidth.to_string(),
        s.runs.to_string(),
        s.failed.to_string(),
        number(s.itf_mean, 1),
        number(s.ilt20_median_s, 2),
        s.ilt20_range_s.map_or("–".to_owned(), |[a, b]| format!("{a:.2}–{b:.2}")),
        number(s.best_median_s, 2),
        s.fallbacks.to_string(),
        s.paper.clone().unwrap_or_else(|| "–".to_owned()),
    ]
}
