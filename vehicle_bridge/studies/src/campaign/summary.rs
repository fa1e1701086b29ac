//! A table of a campaign: along each axis what came of its runs.

use comfy_table::{Cell, CellAlignment, Table, presets};
use racing::record::median;

use super::rows::{CampaignColumns, CampaignRow};

/// An axis with more values than this is shown in ranges, if they are numbers.
const MOST_VALUES: usize = 12;
/// Ranges of such an axis.
const RANGES: usize = 5;

/// For each value of each axis, or each range of values: runs, failed, beyond limits, median and
/// slowest of the best laps.
#[must_use]
pub fn by_axis(axes: &[String], columns: &CampaignColumns, rows: &[CampaignRow]) -> String {
    let mut table = Table::new();
    table.load_style(presets::UTF8_HORIZONTAL_ONLY);
    let head = ["axis", "value", "runs", "failed", "beyond limits", "best lap [s]", "slowest [s]"];
    table.set_header(head);
    for axis in axes {
        let values = distinct(rows.iter().map(|row| row.get(columns, axis)));
        let numbers: Option<Vec<f64>> = values.iter().map(|value| value.parse().ok()).collect();
        match numbers.filter(|numbers| numbers.len() > MOST_VALUES) {
            Some(numbers) => {
                for (from, to) in ranges(numbers) {
                    let inside =
                        |text: &str| text.parse::<f64>().is_ok_and(|v| v >= from && v <= to);
                    let own = rows.iter().filter(|row| inside(row.get(columns, axis))).collect();
                    let name = format!("{} to {}", short(from), short(to));
                    table.add_row(line(axis, &name, columns, &own));
                }
            }
            None => {
                for value in values.iter().take(MOST_VALUES) {
                    let own = rows.iter().filter(|r| r.get(columns, axis) == *value).collect();
                    table.add_row(line(axis, value, columns, &own));
                }
                if values.len() > MOST_VALUES {
                    let more = format!("and {} more", values.len() - MOST_VALUES);
                    table.add_row(vec![Cell::new(axis), Cell::new(more)]);
                }
            }
        }
    }
    table.add_row(line("all runs", "", columns, &rows.iter().collect()));
    table.to_string()
}

/// The different texts in the order of their first appearance.
pub(crate) fn distinct<'a>(texts: impl Iterator<Item = &'a str>) -> Vec<&'a str> {
    let mut seen = std::collections::BTreeSet::new();
    texts.filter(|text| seen.insert(*text)).collect()
}

/// Ranges with as many values each.
pub(crate) fn ranges(mut numbers: Vec<f64>) -> Vec<(f64, f64)> {
    numbers.sort_by(f64::total_cmp);
    ranges_of(&numbers, RANGES)
}

/// `count` ranges of sorted numbers with as many each; `count` is at most their number.
pub(crate) fn ranges_of(numbers: &[f64], count: usize) -> Vec<(f64, f64)> {
    let ends = |i: usize| {
        let (from, to) = (i * numbers.len() / count, (i + 1) * numbers.len() / count);
        (numbers[from], numbers[to - 1])
    };
    (0..count).map(ends).collect()
}

/// A number with four significant digits.
pub(crate) fn short(value: f64) -> String {
    let digits = 3 - value.abs().log10().floor().clamp(-9.0, 3.0) as i32;
    let text = format!("{value:.*}", usize::try_from(digits).unwrap_or(0));
    if text.contains('.') {
        return text.trim_end_matches('0').trim_end_matches('.').to_owned();
    }
    text
}

fn line(axis: &str, value: &str, columns: &CampaignColumns, own: &Vec<&CampaignRow>) -> Vec<Cell> {
    let count = |name: &str| own.iter().filter(|row| !row.get(columns, name).is_empty()).count();
    let stayed = own.iter().filter(|row| row.get(columns, "failure").is_empty());
    let mut best: Vec<f64> =
        stayed.filter_map(|row| row.get(columns, "best_lap_s").parse().ok()).collect();
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
    let mut cells = vec![Cell::new(axis), Cell::new(value)];
    cells.extend(numbers.map(|text| Cell::new(text).set_alignment(CellAlignment::Right)));
    cells
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_hold_every_value_once() {
        let numbers: Vec<f64> = (0..23).rev().map(f64::from).collect();
        let found = ranges(numbers.clone());
        for number in numbers {
            let inside = found.iter().filter(|(from, to)| number >= *from && number <= *to);
            assert_eq!(inside.count(), 1, "{number} in {found:?}");
        }
    }

    #[test]
    fn numbers_are_short() {
        for (value, text) in [
            (0.75, "0.75"),
            (0.000_123_456, "0.0001235"),
            (1234.56, "1235"),
            (-2.5, "-2.5"),
            (0.0, "0"),
            (100.0, "100"),
        ] {
            assert_eq!(short(value), text);
        }
    }
}
