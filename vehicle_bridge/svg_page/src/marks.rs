//! Marks of small multiples: a shape a line, crosses for failures.

use std::fmt::Write as _;

use super::escape;
use super::facets::{Frame, Line};

/// Crosses, with their number where there is room for it.
pub(crate) fn failures(
    line: &Line,
    i: usize,
    frame: &Frame,
    (aside, y): (f64, f64),
    many: bool,
    out: &mut String,
) {
    let cross = |x: f64| {
        format!(
            "<path class=\"cross s{}\" d=\"M{:.1} {:.1}l6 6m0 -6l-6 6\"/>",
            i % 6,
            x - 3.0,
            y - 8.0
        )
    };
    for x in &line.failures {
        out.push_str(&cross(frame.x(*x)));
    }
    for spot in line.spots.iter().filter(|spot| spot.failed > 0) {
        let x = frame.x(spot.x) + if many { 0.0 } else { aside - 6.0 };
        let _ = write!(out, "<g><title>{}</title>{}", escape(&spot.title), cross(x));
        if !many {
            let (x, failed) = (x + 5.0, spot.failed);
            let _ = write!(out, "<text class=\"count\" x=\"{x:.1}\" y=\"{y:.1}\">{failed}</text>");
        }
        out.push_str("</g>");
    }
}

/// The mark of a line: circle, square, triangle, diamond, and the last two hollow.
pub(crate) fn mark(i: usize, x: f64, y: f64) -> String {
    let hollow = if i % 6 >= 4 { " hollow" } else { "" };
    let d = match i % 4 {
        0 => format!("M{:.1} {y:.1}a3.6 3.6 0 1 0 7.2 0a3.6 3.6 0 1 0 -7.2 0Z", x - 3.6),
        1 => format!("M{:.1} {:.1}h6.4v6.4h-6.4Z", x - 3.2, y - 3.2),
        2 => format!("M{x:.1} {:.1}l4.2 7.2h-8.4Z", y - 4.6),
        _ => format!("M{x:.1} {:.1}l4.4 4.4l-4.4 4.4l-4.4 -4.4Z", y - 4.4),
    };
    format!("<path class=\"dot s{}{hollow}\" d=\"{d}\"/>", i % 6)
}
