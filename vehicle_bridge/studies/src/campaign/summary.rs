//! A table of a campaign: for each value of each axis what came of its runs.

use comfy_table::{Cell, CellAlignment, Table, presets};
use racing::record::median;

use super::rows::{Columns, Row};

/// For each value of each axis: runs, failed, beyond limits, median and slowest of the best laps.
#[must_use]
pub fn by_axis(axes: &[String], columns: &Columns, rows: &[Row]) -> String {
    let mut table = Table::new();
    table.load_style(presets::UTF8_HORIZONTAL_ONLY);
    let head = ["axis", "value", "runs", "failed", "beyond limits", "best lap [s]", "slowest [s]"];
    table.set_header(head);
    let all = ["all runs".to_owned()];
    let lines = axes.iter().flat_map(|axis| {
        let mut values: Vec<&str> = Vec::new();
        for row in rows {
            let value = row.get(columns, axis);
            if !values.contains(&value) {
                values.push(value);
            }
        }
        values.into_iter().map(move |value| (axis, value))
    });
    for (axis, value) in lines.chain(all.iter().map(|all| (all, ""))) {
        let own: Vec<&Row> = rows
            .iter()
            .filter(|row| columns.place(axis).is_none() || row.get(columns, axis) == value)
            .collect();
        let count =
            |name: &str| own.iter().filter(|row| !row.get(columns, name).is_empty()).count();
        let mut best: Vec<f64> = own
            .iter()
            .filter(|row| row.get(columns, "failure").is_empty())
            .filter_map(|row| row.get(columns, "best_lap_s").parse().ok())
            .collect();
        let time = |value: f64| {
            if value.is_finite() { format!("{value:.3}") } else { "\u{2013}".to_owned() }
        };
        let slowest = best.iter().copied().fold(f64::NAN, f64::max);
        let numbers = [
            own.len().to_string(),
            count("failure").to_string(),
            count("limits").to_string(),
            time(median(&mut best)),
            time(slowest),
        ];
        let mut line = vec![Cell::new(axis), Cell::new(value)];
        line.extend(numbers.map(|text| Cell::new(text).set_alignment(CellAlignment::Right)));
        table.add_row(line);
    }
    table.to_string()
}
