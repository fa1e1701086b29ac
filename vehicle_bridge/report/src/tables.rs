//! Tables of laps and of what did not go the normal way.

use controller::Action;

use racing::record::{LapRow, StepRow, is_fallback};
use racing::words::{action_word, kind_word, reason_word};
use svg_page::table;

/// A slack smaller than this is the solver's, not the car's.
const SLACK_SHOWN: f64 = 1e-3;

/// Most single steps listed.
const MOST_ROWS: usize = 200;

/// One row a lap.
#[must_use]
pub(super) fn laps(laps: &[LapRow]) -> String {
    let head = [
        "lap",
        "kind",
        "lap time [s]",
        "valid",
        "v max [m/s]",
        "|e_y| max [m]",
        "overhang [m]",
        "|alpha_f| max",
        "|alpha_r| max",
        "model error",
        "data support",
        "iterations",
        "grip f",
        "grip r",
        "fell back",
        "clipped",
    ];
    let rows: Vec<Vec<String>> = laps
        .iter()
        .map(|lap| {
            vec![
                lap.result.lap.to_string(),
                kind_word(lap.result.kind).to_owned(),
                format!("{:.3}", lap.result.lap_time),
                if lap.result.valid { "yes" } else { "no" }.to_owned(),
                format!("{:.2}", lap.v_max),
                format!("{:.3}", lap.e_y_max),
                number(lap.overhang_max, 3),
                format!("{:.3}", lap.alpha_f_max),
                format!("{:.3}", lap.alpha_r_max),
                number(lap.model_error_median, 3),
                number(lap.support_mean, 1),
                number(lap.iterations_mean, 1),
                format!("{:.3}", lap.grip[0]),
                format!("{:.3}", lap.grip[1]),
                lap.fallbacks.to_string(),
                lap.clipped.to_string(),
            ]
        })
        .collect();
    table(&head, &rows)
}

/// What fell back, what was cut, and which soft limits gave way, lap by lap and step by step.
#[must_use]
pub(super) fn events(laps: &[LapRow], steps: &[StepRow]) -> String {
    let head = [
        "lap",
        "fell back",
        "clipped",
        "lane slack max [m]",
        "front slip slack [rad]",
        "rear slip slack [rad]",
        "unsupported steps",
    ];
    let last = steps.last().map_or(0, |r| r.status.lap.get());
    let first = steps.first().map_or(1, |r| r.status.lap.get());
    let mut rows = Vec::new();
    for lap in first..=last {
        let own: Vec<&StepRow> = steps.iter().filter(|r| r.status.lap.get() == lap).collect();
        let most = |f: fn(&StepRow) -> f64| own.iter().map(|r| f(r)).fold(0.0, f64::max);
        let slack = [
            most(|r| r.status.lane_slack),
            most(|r| r.status.front_slip_slack),
            most(|r| r.status.rear_slip_slack),
        ];
        let fell = own.iter().filter(|r| is_fallback(&r.status)).count();
        let clipped = own.iter().filter(|r| r.status.clipped).count();
        let unsupported = own
            .iter()
            .filter(|r| r.status.action == Action::Learned && r.status.data_support_min <= 0.0)
            .count();
        if fell + clipped + unsupported > 0 || slack.iter().any(|&s| s > SLACK_SHOWN) {
            let mut row = vec![lap.to_string(), fell.to_string(), clipped.to_string()];
            row.extend(
                slack.iter().map(|s| if *s > SLACK_SHOWN { format!("{s:.3}") } else { "–".into() }),
            );
            row.push(unsupported.to_string());
            rows.push(row);
        }
    }
    let mut out = if rows.is_empty() {
        format!("<p>Nothing in {} laps.</p>\n", laps.len())
    } else {
        table(&head, &rows)
    };
    let fallen: Vec<Vec<String>> = steps
        .iter()
        .filter(|r| is_fallback(&r.status))
        .take(MOST_ROWS)
        .map(|r| {
            vec![
                format!("{:.2}", r.time),
                r.status.lap.to_string(),
                action_word(r.status.action).to_owned(),
                reason_word(r.status.reason).to_owned(),
                format!("{:?}", r.status.solve),
                format!("{:.2}", r.x.s),
                format!("{:.2}", r.x.v_x),
            ]
        })
        .collect();
    if !fallen.is_empty() {
        let head = ["time [s]", "lap", "action", "reason", "solver", "s [m]", "v_x [m/s]"];
        out.push_str(&table(&head, &fallen));
    }
    out
}

fn number(value: f64, digits: usize) -> String {
    if value.is_finite() { format!("{value:.digits$}") } else { "–".to_owned() }
}
