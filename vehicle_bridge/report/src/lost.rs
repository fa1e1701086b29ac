//! Where laps lose time against the time-optimal one.

use super::LapView;
use optimum_store::Known;
use svg_page::{Chart, table};

/// Sections of the table.
const SECTIONS: u32 = 12;

/// Time a lap has lost when it is at s, [s \[m\], lost \[s\]], from line to line; empty for a lap
/// that did not begin and end on the line.
fn lost(lap: &LapView<'_>, known: &Known, length: f64) -> Vec<(f64, f64)> {
    let (Some(before), Some(after), Some(_)) = (lap.before, lap.after, lap.time) else {
        return Vec::new();
    };
    let own = lap.steps.iter().map(|row| (row.x.s, row.time));
    let ends = [(before.x.s - length, before.time), (after.x.s + length, after.time)];
    let mut places: Vec<(f64, f64)> = own.chain(ends).collect();
    places.sort_by(|a, b| a.1.total_cmp(&b.1));
    let Some(start) = time_at(&places, 0.0) else { return Vec::new() };
    let end = time_at(&places, length).map(|time| (length, time));
    let inside = places.iter().copied().filter(|p| p.0 > 0.0 && p.0 < length);
    std::iter::once((0.0, start))
        .chain(inside)
        .chain(end)
        .map(|(s, time)| (s, time - start - known.time_at(s)))
        .collect()
}

/// The value at s between points in the order of s.
fn time_at(points: &[(f64, f64)], s: f64) -> Option<f64> {
    let pair = points.windows(2).find(|p| p[0].0 <= s && s <= p[1].0 && p[0].0 < p[1].0)?;
    let part = (s - pair[0].0) / (pair[1].0 - pair[0].0);
    Some(pair[0].1 + part * (pair[1].1 - pair[0].1))
}

/// Chart of the time lost along every lap, and a table by section for the best one.
#[must_use]
pub(super) fn html(laps: &[LapView<'_>], known: &Known, length: f64) -> String {
    let mut chart = Chart::new("s [m]", "time lost [s]");
    chart.height = 230.0;
    chart.x_range = Some((0.0, length));
    for lap in laps {
        let points = lost(lap, known, length);
        if points.is_empty() {
            continue;
        }
        chart.series.push(lap.line(points));
    }
    let mut out = chart.html();
    if let Some(best) = laps.iter().find(|lap| lap.best) {
        out.push_str(&sections(best, known, length));
    }
    out
}

fn sections(lap: &LapView<'_>, known: &Known, length: f64) -> String {
    let points = lost(lap, known, length);
    let slowest = |speeds: &mut dyn Iterator<Item = f64>| {
        let least = speeds.fold(f64::INFINITY, f64::min);
        if least.is_finite() { format!("{least:.2}") } else { "–".to_owned() }
    };
    let rows: Vec<Vec<String>> = (0..SECTIONS)
        .filter_map(|i| {
            let end = |i: u32| length * f64::from(i) / f64::from(SECTIONS);
            let (begin, end) = (end(i), end(i + 1));
            let lost = time_at(&points, end)? - time_at(&points, begin)?;
            let here = |s: f64| s >= begin && s < end;
            let own = &mut lap.steps.iter().filter(|r| here(r.x.s)).map(|r| r.x.v_x);
            let best = &mut known.points.iter().filter(|p| here(p[0])).map(|p| p[2]);
            Some(vec![
                format!("{begin:.1} – {end:.1}"),
                format!("{lost:+.3}"),
                slowest(own),
                slowest(best),
            ])
        })
        .collect();
    let head = ["s [m], best lap", "time lost [s]", "slowest [m/s]", "time-optimal [m/s]"];
    table(&head, &rows)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_between_points_is_interpolated_and_none_is_made_up() {
        let points = [(-1.0, 0.0), (1.0, 2.0), (1.0, 3.0), (3.0, 4.0)];
        assert_eq!(time_at(&points, 0.0), Some(1.0));
        assert_eq!(time_at(&points, 2.0), Some(3.5));
        assert_eq!(time_at(&points, 3.5), None);
    }
}
