//! The values of all runs on one line, against their limit.

use std::fmt::Write as _;

use super::Distribution;

const WIDTH: f64 = 180.0;
const HEIGHT: f64 = 26.0;
/// Of the ends of the line.
const MARGIN: f64 = 8.0;
/// Dots of one strip at most: more are quantiles. \[-\]
const DOTS: u32 = 100;

/// The strip as an `svg` element: a dot for each run, the median as a bar, limits as thick lines
/// with what they refuse hatched. Empty if nothing was measured.
#[must_use]
pub(super) fn strip(d: &Distribution) -> String {
    let (Some(&first), Some(&last)) = (d.values.first(), d.values.last()) else {
        return String::new();
    };
    let limits = || d.least.into_iter().chain(d.most);
    let low = limits().fold(first, f64::min);
    let high = limits().fold(last, f64::max);
    if !(low.is_finite() && high.is_finite()) {
        return String::new();
    }
    let room = (0.12 * (high - low)).max(1e-9 * high.abs().max(1.0));
    let (low, high) = (low - room, high + room);
    let x = |value: f64| MARGIN + (WIDTH - 2.0 * MARGIN) * (value - low) / (high - low);
    let middle = 0.5 * HEIGHT;
    let mut out = format!(
        "<svg class=\"strip\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" role=\"img\" aria-label=\"{}\">\
         <path class=\"axis\" d=\"M{MARGIN} {middle}H{}\"/>",
        svg_page::escape(&format!("{}, limit {}", d.text(), d.limit)),
        WIDTH - MARGIN
    );
    let mut refused = |from: f64, to: f64, at: f64| {
        let _ = write!(
            out,
            "<rect class=\"refused\" x=\"{from:.1}\" y=\"3\" width=\"{:.1}\" height=\"{}\"/>\
             <path class=\"limit\" d=\"M{at:.1} 1V{}\"/>",
            (to - from).max(0.0),
            HEIGHT - 6.0,
            HEIGHT - 1.0
        );
    };
    if let Some(least) = d.least {
        refused(0.0, x(least), x(least));
    }
    if let Some(most) = d.most {
        refused(x(most), WIDTH, x(most));
    }
    let few = d.values.len() <= DOTS as usize;
    let shares = (0..=DOTS).filter_map(|i| d.quantile(f64::from(i) / f64::from(DOTS)));
    let dots: Vec<f64> = if few { d.values.clone() } else { shares.collect() };
    for value in dots {
        let _ = write!(out, "<circle cx=\"{:.1}\" cy=\"{middle}\" r=\"3\"/>", x(value));
    }
    if let Some(median) = d.quantile(0.5) {
        let at = x(median);
        let _ = write!(out, "<path class=\"median\" d=\"M{at:.1} 6V{}\"/>", HEIGHT - 6.0);
    }
    out.push_str("</svg>");
    out
}
