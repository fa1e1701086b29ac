//! Self-contained pages: one style sheet, charts as SVG, no network.

use std::fmt::Write as _;

pub mod chart;
pub mod facets;
mod marks;
pub mod panels;
pub mod scale;

pub use chart::{Chart, Mark, ReferenceLine, Series};

/// `text` with the characters that mean something in HTML replaced.
#[must_use]
pub fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// The `d` of an SVG path through points, lifted where one is not finite.
#[must_use]
pub fn path(points: impl IntoIterator<Item = (f64, f64)>, decimals: usize) -> String {
    let mut d = String::new();
    let mut pen = 'M';
    for (x, y) in points {
        if x.is_finite() && y.is_finite() {
            let _ = write!(d, "{pen}{x:.decimals$} {y:.decimals$}");
            pen = 'L';
        } else {
            pen = 'M';
        }
    }
    d
}

/// A whole page from its parts; `title` and `lead` are plain text, the rest is HTML.
#[must_use]
pub fn page(title: &str, lead: &str, body: &str, script: &str) -> String {
    styled_page(title, lead, "", body, script)
}

/// The same with rules of its own behind the common style sheet.
#[must_use]
pub fn styled_page(title: &str, lead: &str, css: &str, body: &str, script: &str) -> String {
    let title = escape(title);
    format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <title>{title}</title>\n<style>\n{}{css}</style>\n</head>\n<body>\n<header>\n<h1>{title}</h1>\n\
         <p>{}</p>\n</header>\n<main>\n{body}</main>\n\
         <footer>lmpc {}</footer>\n<script>\n{script}</script>\n</body>\n</html>\n",
        include_str!("page.css"),
        escape(lead),
        env!("CARGO_PKG_VERSION"),
    )
}

/// A card: a heading, what it shows, and the content as HTML.
#[must_use]
pub fn card(heading: &str, note: &str, content: &str) -> String {
    let note = if note.is_empty() { String::new() } else { format!("<p>{}</p>\n", escape(note)) };
    format!("<section>\n<h2>{}</h2>\n{note}{content}</section>\n", escape(heading))
}

/// A table; cells are plain text, numbers are aligned by the style sheet.
#[must_use]
pub fn table(head: &[&str], rows: &[Vec<String>]) -> String {
    let cells = |tag: &str, row: &[String]| -> String {
        row.iter().map(|cell| format!("<{tag}>{}</{tag}>", escape(cell))).collect()
    };
    let head: Vec<String> = head.iter().map(|&h| h.to_owned()).collect();
    let body: String = rows.iter().map(|row| format!("<tr>{}</tr>\n", cells("td", row))).collect();
    format!(
        "<div class=\"scroll\"><table>\n<thead><tr>{}</tr></thead>\n<tbody>\n{body}</tbody>\n\
         </table></div>\n",
        cells("th", &head)
    )
}
