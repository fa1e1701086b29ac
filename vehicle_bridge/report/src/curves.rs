//! Charts over laps and along the lap.

use super::LapView;
use hosting::timing::{PHASES, StepTime, percentile};
use optimum_store::Known;
use racing::record::{LapRow, StepRow};
use svg_page::scale::ScaleKind;
use svg_page::{Chart, Mark, ReferenceLine, Series};

/// Lap time over laps, with the best so far and what is known to be possible.
#[must_use]
pub(super) fn lap_times(laps: &[LapRow], optimal: Option<&Known>) -> String {
    let mut chart = Chart::new("lap", "lap time [s]");
    chart.x_whole = true;
    let points = |keep: fn(&LapRow) -> bool| -> Vec<(f64, f64)> {
        let kept = laps.iter().filter(|lap| keep(lap));
        kept.map(|lap| (f64::from(lap.result.lap.get()), lap.result.lap_time)).collect()
    };
    let mut best = f64::INFINITY;
    let so_far = laps.iter().filter(|lap| lap.is_learning() && lap.result.valid).map(|lap| {
        best = best.min(lap.result.lap_time);
        (f64::from(lap.result.lap.get()), best)
    });
    let so_far: Vec<(f64, f64)> = so_far.collect();
    chart.series.push(Series::new("warm-up", "soft", Mark::DotLine, points(|l| !l.is_learning())));
    chart.series.push(Series::new("learning", "s0", Mark::DotLine, points(LapRow::is_learning)));
    chart.series.push(Series::new("best so far", "best dashed", Mark::Line, so_far));
    chart.references.extend(optimal.map(time_optimal));
    chart.html()
}

fn time_optimal(lap: &Known) -> ReferenceLine {
    ReferenceLine { y: lap.lap_time_s, label: format!("time-optimal {:.3} s", lap.lap_time_s) }
}

/// Learned laps only: what the warm-up laps' scale hides.
#[must_use]
pub(super) fn learned_lap_times(laps: &[LapRow], optimal: Option<&Known>) -> Option<String> {
    let learned: Vec<LapRow> =
        laps.iter().filter(|lap| lap.is_learning()).skip(2).cloned().collect();
    (learned.len() > 3).then(|| {
        let mut chart = Chart::new("lap", "lap time [s]");
        chart.x_whole = true;
        let points =
            learned.iter().map(|l| (f64::from(l.result.lap.get()), l.result.lap_time)).collect();
        chart.series.push(Series::new("learning", "s0", Mark::DotLine, points));
        chart.references.extend(optimal.map(time_optimal));
        chart.html()
    })
}

/// Error of the learned model over laps.
#[must_use]
pub(super) fn model_error(laps: &[LapRow]) -> String {
    let mut chart = Chart::new("lap", "|A_learned - A_car| (Frobenius)");
    let over = |value: fn(&LapRow) -> f64| {
        let learned = laps.iter().filter(|lap| lap.is_learning());
        learned.map(|lap| (f64::from(lap.result.lap.get()), value(lap))).collect::<Vec<_>>()
    };
    chart.y_kind = ScaleKind::Log;
    chart.x_whole = true;
    chart.series.push(Series::new(
        "median of the lap",
        "s0",
        Mark::DotLine,
        over(|l| l.model_error_median),
    ));
    chart.series.push(Series::new(
        "mean of the lap",
        "s1 dashed",
        Mark::Line,
        over(|l| l.model_error_mean),
    ));
    chart.html()
}

/// Charts along the lap.
pub(super) struct Along {
    /// Length of the track [m].
    pub(super) length: f64,
}

/// A line to compare laps with.
pub(super) struct Line {
    /// Name when the mouse rests on it.
    pub(super) title: String,
    /// Class of its style.
    pub(super) class: &'static str,
    /// Places [m] and values.
    pub(super) points: Vec<(f64, f64)>,
}

impl Along {
    /// A value over s for every lap, hidden and shown by the lap chooser.
    pub(super) fn chart(
        &self,
        laps: &[LapView<'_>],
        y_label: &str,
        value: impl Fn(&StepRow) -> f64,
        lines: Vec<Line>,
        references: Vec<ReferenceLine>,
    ) -> String {
        let mut chart = Chart::new("s [m]", y_label);
        chart.height = 230.0;
        chart.x_range = Some((0.0, self.length));
        for lap in laps {
            chart.series.push(lap.line(self.points(lap, &value)));
        }
        for Line { title, class, points } in lines {
            let series = Series::new(&title, class, Mark::Line, points);
            chart.series.push(Series { label: None, ..series });
        }
        chart.references = references;
        chart.html()
    }

    /// From line to line, where the values of the steps around it are interpolated.
    fn points(&self, lap: &LapView<'_>, value: impl Fn(&StepRow) -> f64) -> Vec<(f64, f64)> {
        let own = lap.steps.iter().map(|row| (row.x.s, value(row)));
        let before = lap.before.map(|row| (row.x.s - self.length, value(row)));
        let after = lap.after.map(|row| (row.x.s + self.length, value(row)));
        let all: Vec<(f64, f64)> = before.into_iter().chain(own).chain(after).collect();
        let at = |s: f64| {
            let pair = all.windows(2).find(|p| p[0].0 <= s && s <= p[1].0 && p[0].0 < p[1].0)?;
            let part = (s - pair[0].0) / (pair[1].0 - pair[0].0);
            Some((s, pair[0].1 + part * (pair[1].1 - pair[0].1)))
        };
        let inside = all.iter().copied().filter(|p| p.0 > 0.0 && p.0 < self.length);
        at(0.0).into_iter().chain(inside).chain(at(self.length)).collect()
    }
}

/// A slip guard as a reference line, if it is on.
#[must_use]
pub(super) fn guard(limit: f64) -> Vec<ReferenceLine> {
    if limit <= 0.0 {
        return Vec::new();
    }
    vec![ReferenceLine { y: limit, label: format!("guard {limit}") }]
}

/// Histogram of the step times.
#[must_use]
pub(super) fn step_times(times: &[StepTime]) -> String {
    let mut totals: Vec<f64> = times.iter().map(|t| t.total * 1e3).collect();
    totals.sort_by(f64::total_cmp);
    let top = percentile(&totals, 0.995).max(1e-3);
    let bins = 60_usize;
    let mut counts = vec![0_usize; bins];
    for total in totals.iter().filter(|t| **t <= top) {
        counts[((total / top * bins as f64) as usize).min(bins - 1)] += 1;
    }
    let mut chart = Chart::new("control step [ms] (slowest 0.5 % not drawn)", "steps");
    chart.height = 220.0;
    let points: Vec<(f64, f64)> = counts
        .iter()
        .enumerate()
        .map(|(i, &n)| ((i as f64 + 0.5) * top / bins as f64, n as f64))
        .collect();
    let most = counts.iter().copied().max().unwrap_or(1) as f64;
    chart.y_range = Some((0.0, 1.08 * most));
    chart.series.push(Series::new("steps", "s0", Mark::Bars, points));
    chart.html()
}

/// Percentiles of the step times by phase, as rows of a table.
#[must_use]
pub(super) fn step_table(times: &[StepTime]) -> Vec<Vec<String>> {
    let row = |name: &str, mut values: Vec<f64>| {
        values.sort_by(f64::total_cmp);
        let mut cells = vec![name.to_owned()];
        for share in [0.5, 0.9, 0.99, 1.0] {
            cells.push(format!("{:.3}", percentile(&values, share) * 1e3));
        }
        cells
    };
    let mut rows: Vec<Vec<String>> = PHASES
        .iter()
        .enumerate()
        .map(|(i, phase)| row(phase.1, times.iter().map(|t| t.phases[i]).collect()))
        .collect();
    rows.push(row("whole step", times.iter().map(|t| t.total).collect()));
    rows
}
