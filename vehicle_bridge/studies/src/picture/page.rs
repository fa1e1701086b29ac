//! The page of the figures.

use std::fmt::Write as _;

use anyhow::{Context as _, Result};
use svg_page::{card, escape, page as html_page, table as html_table};

use super::figure::{Drawing, Figure};
use super::table::RunTable;

const HEAD: [&str; 8] =
    ["panel", "line", "at", "runs", "failed", "median or share", "least", "greatest"];

/// A page of figures, each with its numbers; needs no network.
///
/// # Errors
/// If a figure asks for a column that is not there, or for too many lines or panels.
pub fn page(table: &RunTable, figures: &[Figure]) -> Result<String> {
    let failed = table.failed().iter().filter(|failed| **failed).count();
    let beyond = table.column("limits").unwrap_or_default();
    let beyond = beyond.iter().filter(|text| !text.is_empty()).count();
    let mut body = String::from("<div class=\"facts\">");
    for (number, what, class) in [
        (table.runs(), "runs", ""),
        (failed, "failed", if failed > 0 { " bad" } else { " good" }),
        (beyond, "beyond a limit", if beyond > 0 { " bad" } else { " good" }),
    ] {
        if what != "beyond a limit" || table.has("limits") {
            let _ =
                write!(body, "<div class=\"fact{class}\"><b>{number}</b><span>{what}</span></div>");
        }
    }
    body.push_str("</div>\n");
    let mut drawings = Vec::new();
    for figure in figures {
        let drawing = figure.draw(table);
        drawings.push(drawing.with_context(|| format!("{} over {}", figure.y, figure.x))?);
    }
    let (small, wide): (Vec<&Drawing>, Vec<&Drawing>) =
        drawings.iter().partition(|drawing| drawing.facets.facets.len() == 1 && figures.len() > 1);
    for drawing in wide {
        body.push_str(&content(drawing));
    }
    body.push_str("<div class=\"columns\">\n");
    for drawing in small {
        body.push_str(&content(drawing));
    }
    body.push_str("</div>\n");
    let axes: Vec<String> = table
        .varied()
        .iter()
        .map(|axis| format!("{axis} ({})", table.values(axis).map_or(0, |values| values.len())))
        .collect();
    let lead = if axes.is_empty() { String::new() } else { format!("Axes: {}.", axes.join(", ")) };
    Ok(html_page(&table.title, &lead, &body, ""))
}

fn content(drawing: &Drawing) -> String {
    let used: Vec<usize> =
        (0..HEAD.len()).filter(|&i| drawing.numbers.iter().any(|row| !row[i].is_empty())).collect();
    let head: Vec<&str> = used.iter().map(|&i| HEAD[i]).collect();
    let rows: Vec<Vec<String>> =
        drawing.numbers.iter().map(|row| used.iter().map(|&i| row[i].clone()).collect()).collect();
    let content = format!(
        "{}{}<details><summary>Numbers of \u{201c}{}\u{201d}</summary>{}</details>\n",
        drawing.facets.svg(),
        drawing.facets.legend(),
        escape(&drawing.title),
        html_table(&head, &rows)
    );
    card(&drawing.title, &drawing.note, &content)
}
