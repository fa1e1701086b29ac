//! The study as one page, with plots like the paper's.

use super::definition::{Cell, Definition};
use super::ledger::{RunRow, StudyLap};
use super::table::{CellSummary, HEAD, belongs, cells_of};
use racing::record::{mean, median};
use svg_page::scale::ScaleKind;
use svg_page::{Chart, Mark, Series, card, page as html_page, table};

/// The page.
#[must_use]
pub fn page(
    study: &Definition,
    summaries: &[CellSummary],
    runs: &[RunRow],
    laps: &[StudyLap],
) -> String {
    let rows: Vec<Vec<String>> = summaries.iter().map(cells_of).collect();
    let mut body = card("Beside the paper", "", &table(&HEAD, &rows));
    body.push_str("<div class=\"columns\">\n");
    for regression in &study.regressions {
        let own: Vec<&CellSummary> =
            summaries.iter().filter(|s| &s.cell.regression == regression).collect();
        let name = heading(regression);
        let note = "Median over the seeds that still drive.";
        body.push_str(&card(
            &format!("Lap times, {name}"),
            note,
            &over_iterations(
                &own,
                laps,
                "lap time [s]",
                ScaleKind::Linear,
                |lap| lap.lap_time_s,
                median,
            ),
        ));
        body.push_str(&card(
            &format!("Runs still on the track, {name}"),
            "Share of the seeds that finished the iteration.",
            &survivors(&own, runs),
        ));
        for (what, of) in [
            ("median", (|lap: &StudyLap| lap.model_error_median) as fn(&StudyLap) -> Option<f64>),
            ("mean", |lap: &StudyLap| lap.model_error_mean),
        ] {
            let middle: fn(&mut [f64]) -> f64 = if what == "mean" { |v| mean(v) } else { median };
            let note = "Frobenius norm of A_learned - A_plant, at the same points and with the \
                        same discretisation; a run's last point is the lap it failed in.";
            body.push_str(&card(
                &format!("Model error, {what}, {name}"),
                note,
                &over_iterations(&own, laps, "|A_learned - A_plant|", ScaleKind::Log, of, middle),
            ));
        }
    }
    body.push_str("</div>\n");
    html_page(&study.title, &study.lead, &body, "")
}

fn heading(regression: &str) -> String {
    match regression {
        "nominal" => "nominal model alone".to_owned(),
        other => format!("{other} regression"),
    }
}

/// A value over the iterations, one line a cell.
fn over_iterations(
    cells: &[&CellSummary],
    laps: &[StudyLap],
    y_label: &str,
    kind: ScaleKind,
    value: impl Fn(&StudyLap) -> Option<f64>,
    middle: fn(&mut [f64]) -> f64,
) -> String {
    let mut chart = Chart::new("iteration", y_label);
    chart.y_kind = kind;
    chart.x_whole = true;
    for (i, summary) in cells.iter().enumerate() {
        let own: Vec<&StudyLap> = laps.iter().filter(|lap| of_cell(lap, &summary.cell)).collect();
        let last = own.iter().filter_map(|lap| lap.iteration).max().unwrap_or(0);
        let points = (1..=last)
            .map(|iteration| {
                let at = own.iter().filter(|lap| lap.iteration == Some(iteration));
                let mut values: Vec<f64> = at.filter_map(|lap| value(lap)).collect();
                (f64::from(iteration), middle(&mut values))
            })
            .collect();
        chart.series.push(Series::new(
            &label(cells, &summary.cell),
            &format!("s{}", i % 6),
            Mark::DotLine,
            points,
        ));
    }
    chart.html()
}

fn survivors(cells: &[&CellSummary], runs: &[RunRow]) -> String {
    let mut chart = Chart::new("iteration", "share of runs");
    chart.y_range = Some((0.0, 1.05));
    chart.x_whole = true;
    let last = runs.iter().map(|run| run.laps_completed).max().unwrap_or(1).max(1);
    for (i, summary) in cells.iter().enumerate() {
        let own: Vec<&RunRow> = runs.iter().filter(|r| belongs(r, &summary.cell)).collect();
        let points = (1..=last)
            .map(|iteration| {
                let done = own.iter().filter(|r| r.laps_completed >= iteration).count();
                (f64::from(iteration), done as f64 / own.len().max(1) as f64)
            })
            .collect();
        chart.series.push(Series::new(
            &label(cells, &summary.cell),
            &format!("s{}", i % 6),
            Mark::Line,
            points,
        ));
    }
    chart.html()
}

fn of_cell(lap: &StudyLap, cell: &Cell) -> bool {
    lap.regression == cell.regression
        && lap.nominal == cell.nominal
        && lap.control_rate_cost.to_bits() == cell.control_rate_cost.to_bits()
        && lap.bandwidth.to_bits() == cell.bandwidth.to_bits()
}

/// Name of a cell within its plot.
fn label(cells: &[&CellSummary], cell: &Cell) -> String {
    let differ = |of: fn(&Cell) -> f64| {
        cells.iter().any(|other| of(&other.cell).to_bits() != of(cell).to_bits())
    };
    let mut parts = Vec::new();
    if differ(|c| c.control_rate_cost) {
        parts.push(format!("rate cost {}", cell.control_rate_cost));
    }
    if differ(|c| c.bandwidth) || parts.is_empty() {
        parts.push(format!("h {}", cell.bandwidth));
    }
    parts.join(", ")
}
