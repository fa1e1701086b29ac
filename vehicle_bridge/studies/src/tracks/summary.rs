//! Cells summed up: a car on a track with a plant, over the seeds.

use comfy_table::{Cell as Column, CellAlignment, Table, presets};
use serde::Serialize;

use super::case::TracksCase;
use super::row::TracksRow;
use racing::record::median;

/// The track of a line that sums up all generated ones.
const GENERATED: &str = "(generated)";

/// Some runs summed up.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Summary {
    /// Name of the car.
    pub car: String,
    /// Name of the track; `(generated)` for all generated tracks together.
    pub track: String,
    /// The plant.
    pub plant: String,
    /// Runs.
    pub runs: usize,
    /// Runs that failed.
    pub failed: usize,
    /// Median of the best laps of the runs that did not fail \[s\].
    pub best_median_s: Option<f64>,
    /// Slowest of them \[s\].
    pub best_worst_s: Option<f64>,
    /// Median of the ratios to the optimum.
    pub ratio_median: Option<f64>,
    /// Greatest of them.
    pub ratio_worst: Option<f64>,
    /// Greatest number of laps until within 5 % of the best.
    pub laps_within_5_percent: Option<u32>,
    /// Share of the QPs that Clarabel solved.
    pub clarabel_share: Option<f64>,
    /// Greatest overhang of the body; negative is a distance kept \[m\].
    pub overhang_max_m: Option<f64>,
    /// Median of the runs' median step times \[us\].
    pub step_median_us: Option<f64>,
    /// Greatest of the times below which 99 % of a run's steps stay \[us\].
    pub step_p99_us: Option<f64>,
}

/// Sums up the runs of each cell in the order of the cases, all generated tracks of a car
/// together.
#[must_use]
pub fn summarize(cases: &[TracksCase], rows: &[TracksRow]) -> Vec<Summary> {
    let generated = |row: &TracksRow| {
        cases.iter().any(|c| c.generated && c.key.car == row.car && c.key.track == row.track)
    };
    let mut groups: Vec<([String; 3], Vec<&TracksRow>)> = Vec::new();
    for row in rows {
        let track = if generated(row) { GENERATED } else { &row.track };
        let name = [row.car.clone(), track.to_owned(), row.plant.clone()];
        match groups.iter_mut().find(|(n, _)| *n == name) {
            Some((_, rows)) => rows.push(row),
            None => groups.push((name, vec![row])),
        }
    }
    groups.into_iter().map(|(name, rows)| Summary::of(name, &rows)).collect()
}

impl Summary {
    /// The sum of some runs.
    #[must_use]
    pub fn of([car, track, plant]: [String; 3], rows: &[&TracksRow]) -> Self {
        let survived = || rows.iter().filter(|row| !row.failed());
        let most = |values: Vec<f64>| values.into_iter().reduce(f64::max);
        let middle = |mut values: Vec<f64>| Some(median(&mut values)).filter(|v| v.is_finite());
        let best: Vec<f64> = survived().filter_map(|row| row.best_lap_s).collect();
        let ratios: Vec<f64> = survived().filter_map(|row| row.ratio).collect();
        let all =
            |of: fn(&TracksRow) -> Option<f64>| rows.iter().filter_map(|row| of(row)).collect();
        let solver: u64 = rows.iter().map(|row| row.solver_steps).sum();
        let clarabel: u64 = rows.iter().map(|row| row.clarabel_steps).sum();
        Self {
            car,
            track,
            plant,
            runs: rows.len(),
            failed: rows.iter().filter(|row| row.failed()).count(),
            best_median_s: middle(best.clone()),
            best_worst_s: most(best),
            ratio_median: middle(ratios.clone()),
            ratio_worst: most(ratios),
            laps_within_5_percent: survived().filter_map(|row| row.lap_within_5_percent).max(),
            clarabel_share: (solver > 0).then(|| clarabel as f64 / solver as f64),
            overhang_max_m: most(all(|row| row.overhang_max_m)),
            step_median_us: middle(all(|row| row.step_median_us)),
            step_p99_us: most(all(|row| row.step_p99_us)),
        }
    }

    /// The cells of its line.
    #[must_use]
    pub(super) fn cells(&self) -> Vec<String> {
        let number = |value: Option<f64>, digits: usize| {
            value.map_or("–".to_owned(), |v| format!("{v:.digits$}"))
        };
        vec![
            self.car.clone(),
            self.track.clone(),
            self.plant.clone(),
            format!("{} of {}", self.failed, self.runs),
            number(self.best_median_s, 3),
            number(self.best_worst_s, 3),
            number(self.ratio_median, 3),
            number(self.ratio_worst, 3),
            self.laps_within_5_percent.map_or("–".to_owned(), |n| n.to_string()),
            number(self.overhang_max_m, 3),
            number(self.clarabel_share.map(|share| 100.0 * share), 2),
            number(self.step_median_us, 0),
            number(self.step_p99_us, 0),
        ]
    }
}

/// Head of the table, on the terminal and on the page.
pub(super) const HEAD: [&str; 13] = [
    "car",
    "track",
    "plant",
    "failed",
    "best [s]",
    "worst [s]",
    "ratio",
    "worst",
    "laps to 5 %",
    "overhang [m]",
    "Clarabel [%]",
    "step [us]",
    "99 % [us]",
];

/// The table for the terminal.
#[must_use]
pub fn text_table(summaries: &[Summary]) -> String {
    let mut table = Table::new();
    table.load_style(presets::UTF8_HORIZONTAL_ONLY);
    table.set_header(HEAD);
    for summary in summaries {
        let cells = summary.cells().into_iter().enumerate().map(|(i, text)| {
            let side = if i < 3 { CellAlignment::Left } else { CellAlignment::Right };
            Column::new(text).set_alignment(side)
        });
        table.add_row(cells.collect::<Vec<_>>());
    }
    table.to_string()
}
