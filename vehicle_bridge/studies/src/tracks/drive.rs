//! One run of the matrix, from a case to its row.

use controller::fhocp::Backend;
use controller::{LapKind, Status};

use super::case::TracksCase;
use super::row::TracksRow;
use hosting::timing::{StepTime, percentile};
use racing::record::{StepRow, is_fallback, mean};
use racing::words::{action_word, reason_word};
use racing::{Race, RaceError};

/// Steps before a failure that are kept.
pub const LAST_STEPS: usize = 100;
/// Steps before a failure that its row describes.
const DESCRIBED_STEPS: usize = 10;
/// A lap is close to the best below this many times its time.
const CLOSE: f64 = 1.05;
/// The word for a race that cannot begin.
const REFUSED: &str = "refused";

/// A finished run.
#[derive(Debug, Clone)]
pub struct Run {
    /// Its row.
    pub row: TracksRow,
    /// The last steps of a run that failed.
    pub last_steps: Vec<StepRow>,
}

/// Drives a case. A race that cannot begin, or whose vehicle fails, is a failed run.
#[must_use]
pub fn drive(case: &TracksCase) -> Run {
    let race = || -> Result<Race, RaceError> {
        let mut race = Race::new(case.options.clone())?;
        race.run(|_| {})?;
        Ok(race)
    };
    match race() {
        Ok(race) => of_race(case, &race),
        Err(error) => {
            let (failure, fail_message) = (REFUSED.to_owned(), error.to_string());
            let row = TracksRow { failure, fail_message, ..TracksRow::new(&case.key) };
            Run { row, last_steps: Vec::new() }
        }
    }
}

fn of_race(case: &TracksCase, race: &Race) -> Run {
    let mut row = TracksRow::new(&case.key);
    laps(&mut row, race, case.optimum);
    steps(&mut row, race);
    let mut last_steps = Vec::new();
    if let Some(failure) = &race.failure {
        failure.reason.as_str().clone_into(&mut row.failure);
        row.fail_lap = Some(failure.iteration);
        row.fail_time_s = Some(failure.time);
        row.fail_s_m = finite(failure.x.s);
        row.fail_v_x_mps = finite(failure.x.v_x);
        row.fail_e_y_m = finite(failure.x.e_y);
        row.fail_e_psi_rad = finite(failure.x.e_psi);
        row.fail_beyond_m = finite(failure.beyond);
        row.fail_message = failure.to_string();
        row.fail_last_steps = describe(tail(&race.steps, DESCRIBED_STEPS));
        last_steps = tail(&race.steps, LAST_STEPS).to_vec();
    }
    Run { row, last_steps }
}

fn laps(row: &mut TracksRow, race: &Race, optimum: Option<f64>) {
    let of = |kind: LapKind| race.laps.iter().filter(move |lap| lap.result.kind == kind);
    let learned = || of(LapKind::Learning);
    let valid = learned().filter(|lap| lap.result.valid).map(|lap| lap.result.lap_time);
    row.laps = learned().count() as u32;
    row.best_lap_s = valid.min_by(f64::total_cmp);
    row.rate(optimum);
    row.lap_within_5_percent = row.best_lap_s.and_then(|best| {
        let close = |time: f64| time <= CLOSE * best;
        learned().find(|lap| close(lap.result.lap_time)).and_then(|lap| lap.iteration)
    });
    let warm_up: Vec<f64> = of(LapKind::Warmup).map(|lap| lap.result.lap_time).collect();
    row.warm_up_lap_mean_s = finite(mean(&warm_up));
    let times: Vec<String> = learned().map(|lap| format!("{:.3}", lap.result.lap_time)).collect();
    row.lap_times_s = times.join(" ");
}

fn steps(row: &mut TracksRow, race: &Race) {
    let count =
        |of: fn(&Status) -> bool| race.steps.iter().filter(|step| of(&step.status)).count() as u64;
    row.steps = race.steps.len() as u64;
    row.solver_steps = count(|s| s.solver.is_some());
    row.clarabel_steps = count(|s| s.solver == Some(Backend::Clarabel));
    row.fallbacks = count(is_fallback);
    row.clipped = count(|s| s.clipped);
    let overhang = race.steps.iter().map(|s| s.overhang).fold(f64::NAN, f64::max);
    row.overhang_max_m = finite(race.failure.map_or(overhang, |f| overhang.max(f.beyond)));
    let solved = race.steps.iter().zip(&race.times).filter(|(s, _)| s.status.solver.is_some());
    // Some systems count processor time in coarse ticks: a step takes no more than it lasted.
    let step = |time: &StepTime| 1e6 * time.processor.min(time.total);
    let mut times: Vec<f64> = solved.map(|(_, time)| step(time)).collect();
    times.sort_by(f64::total_cmp);
    row.step_median_us = finite(percentile(&times, 0.5)).map(tenths);
    row.step_p99_us = finite(percentile(&times, 0.99)).map(tenths);
}

fn finite(value: f64) -> Option<f64> {
    value.is_finite().then_some(value)
}

fn tenths(value: f64) -> f64 {
    (10.0 * value).round() / 10.0
}

fn tail(steps: &[StepRow], count: usize) -> &[StepRow] {
    &steps[steps.len().saturating_sub(count)..]
}

/// What was done in some steps, and how far the soft limits of their plans gave way.
fn describe(steps: &[StepRow]) -> String {
    let mut parts: Vec<(String, usize)> = Vec::new();
    for status in steps.iter().map(|step| &step.status) {
        let reason = reason_word(status.reason);
        let gap = if reason.is_empty() { "" } else { " " };
        let solver = if status.solver == Some(Backend::Clarabel) { " by clarabel" } else { "" };
        let text = format!("{}{gap}{reason}{solver}", action_word(status.action));
        match parts.last_mut() {
            Some((last, count)) if *last == text => *count += 1,
            _ => parts.push((text, 1)),
        }
    }
    let did: Vec<String> = parts.iter().map(|(text, n)| format!("{n} x {text}")).collect();
    let most = |of: fn(&Status) -> f64| steps.iter().map(|s| of(&s.status)).fold(0.0, f64::max);
    format!(
        "{}; greatest slacks: lane {:.3} m, slip {:.3} and {:.3} rad, speed {:.2} m/s, terminal \
         {:.2}",
        did.join(", "),
        most(|s| s.lane_slack),
        most(|s| s.front_slip_slack),
        most(|s| s.rear_slip_slack),
        most(|s| s.speed_slack),
        most(|s| s.terminal_slack_cost)
    )
}
