//! Cells of the matrix: a car on a track with a plant, over the seeds.

use super::case::TracksCase;
use super::row::TracksRow;

/// One cell of the grid: a track, and a car with a plant.
pub(super) struct Cell<'a> {
    /// Name of the car.
    pub(super) car: &'a str,
    /// Name of the track.
    pub(super) track: &'a str,
    /// The plant.
    pub(super) plant: &'a str,
    /// Its place in the order of the cases.
    number: usize,
    /// Runs to be done.
    pub(super) planned: usize,
    /// Runs done.
    pub(super) runs: Vec<&'a TracksRow>,
    /// The first of its cases.
    pub(super) case: &'a TracksCase,
}

/// Cells of the cases with their runs, those with most failures first.
pub(super) fn cells<'a>(cases: &'a [TracksCase], rows: &'a [TracksRow]) -> Vec<Cell<'a>> {
    let mut cells: Vec<Cell<'a>> = Vec::new();
    for case in cases {
        let key = &case.key;
        let same = |cell: &&mut Cell<'_>| {
            cell.car == key.car && cell.track == key.track && cell.plant == key.plant
        };
        // The seeds of a cell follow one another.
        if let Some(cell) = cells.last_mut().filter(same) {
            cell.planned += 1;
            continue;
        }
        let own = |row: &&TracksRow| {
            row.car == key.car && row.track == key.track && row.plant == key.plant
        };
        cells.push(Cell {
            car: &key.car,
            track: &key.track,
            plant: &key.plant,
            number: cells.len(),
            planned: 1,
            runs: rows.iter().filter(own).collect(),
            case,
        });
    }
    // Failed cells first; the sort is stable.
    cells.sort_by_key(|cell| std::cmp::Reverse(cell.failed()));
    cells
}

impl Cell<'_> {
    /// Number of failed runs.
    pub(super) fn failed(&self) -> usize {
        self.runs.iter().filter(|run| run.failed()).count()
    }

    /// Anchor of its runs on the page.
    pub(super) fn id(&self) -> String {
        format!("cell-{}", self.number)
    }

    /// Fastest lap of the runs that did not fail \[s\].
    fn best(&self) -> Option<f64> {
        let done = self.runs.iter().filter(|run| !run.failed());
        done.filter_map(|run| run.best_lap_s).min_by(f64::total_cmp)
    }

    /// The slowest ratio, or the slowest best lap where there is no optimum.
    pub(super) fn worth(&self) -> String {
        let done = || self.runs.iter().filter(|run| !run.failed());
        if let Some(ratio) = done().filter_map(|run| run.ratio).reduce(f64::max) {
            return format!("{ratio:.3}");
        }
        let slowest = done().filter_map(|run| run.best_lap_s).reduce(f64::max);
        slowest.map_or(String::new(), |best| format!("{best:.2} s"))
    }

    /// Symbol and style.
    pub(super) fn look(&self) -> (&'static str, &'static str) {
        match (self.failed(), self.runs.len() < self.planned) {
            (0, false) => ("\u{2713}", "ok"),
            (0, true) => ("\u{2026}", "open"),
            _ => ("\u{2717}", "failed"),
        }
    }

    /// Everything about it in a few lines.
    pub(super) fn hover(&self) -> String {
        let mut lines = vec![format!("{} on {}, {}", self.car, self.track, self.plant)];
        lines.push(format!(
            "{} of {} runs failed, {} planned",
            self.failed(),
            self.runs.len(),
            self.planned
        ));
        if let Some(best) = self.best() {
            lines.push(format!("best lap {best:.3} s"));
        }
        if let Some(optimum) = self.case.optimum {
            lines.push(format!("optimum {optimum:.3} s"));
        }
        for run in self.runs.iter().filter(|run| run.failed()) {
            lines.push(format!("seed {}: {}", run.seed, run.fail_message));
        }
        lines.join("\n")
    }
}
