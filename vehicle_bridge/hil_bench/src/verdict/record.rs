//! The verdict as JSON, for programs.

use std::collections::BTreeMap;

use serde::Serialize;

use super::{Tested, Verdict, failed_first, passed, word};
use crate::bench::Bench;
use crate::fault::Fault;
use crate::timeline::Timeline;

/// Name of this format: readers refuse another one.
const FORMAT: &str = "lmpc-verdict-1";

#[derive(Serialize)]
struct Record<'a> {
    format: &'static str,
    title: &'a str,
    verdict: &'static str,
    tested: &'a Tested,
    scenarios: Vec<ScenarioRecord<'a>>,
}

#[derive(Serialize)]
struct ScenarioRecord<'a> {
    name: &'a str,
    row: Option<u32>,
    expected: &'a str,
    verdict: &'static str,
    failed: usize,
    faults: &'a [Fault],
    limits: Vec<LimitRecord>,
    runs: Vec<RunRecord<'a>>,
    /// Of the run that the page shows.
    timeline: Option<&'a Timeline>,
    timeline_seed: Option<u64>,
}

#[derive(Serialize)]
struct LimitRecord {
    measure: String,
    unit: &'static str,
    least: Option<f64>,
    most: Option<f64>,
    measured: usize,
    broken: usize,
    min: Option<f64>,
    median: Option<f64>,
    p99: Option<f64>,
    max: Option<f64>,
}

#[derive(Serialize)]
struct RunRecord<'a> {
    seed: u64,
    duration_s: f64,
    values: BTreeMap<String, f64>,
    broken: &'a [String],
    disturbed: &'a [String],
}

/// The same content as the page, with the values of every run.
///
/// # Errors
/// None that a verdict can have: the names of its maps are texts.
pub fn json(
    bench: &Bench,
    tested: &Tested,
    verdicts: &[Verdict<'_>],
) -> Result<String, serde_json::Error> {
    let record = Record {
        format: FORMAT,
        title: &bench.title,
        verdict: word(passed(verdicts)),
        tested,
        scenarios: failed_first(verdicts).into_iter().map(scenario).collect(),
    };
    Ok(serde_json::to_string_pretty(&record)? + "\n")
}

fn scenario<'a>(verdict: &'a Verdict<'_>) -> ScenarioRecord<'a> {
    let limits = verdict.distributions().into_iter().map(|d| LimitRecord {
        unit: d.unit,
        least: d.least,
        most: d.most,
        measured: d.values.len(),
        broken: d.broken,
        min: d.quantile(0.0),
        median: d.quantile(0.5),
        p99: d.quantile(0.99),
        max: d.quantile(1.0),
        measure: d.name,
    });
    let runs = verdict.runs.iter().map(|run| RunRecord {
        seed: run.seed,
        duration_s: run.duration,
        values: run.values.iter().map(|(name, value)| (name.text(), value)).collect(),
        broken: &run.broken,
        disturbed: &run.disturbed,
    });
    let shown = verdict.shown().filter(|run| !run.timeline.is_empty());
    ScenarioRecord {
        name: &verdict.scenario.name,
        row: verdict.scenario.row,
        expected: &verdict.scenario.expected,
        verdict: word(verdict.failed() == 0),
        failed: verdict.failed(),
        faults: &verdict.scenario.faults,
        limits: limits.collect(),
        runs: runs.collect(),
        timeline: shown.map(|run| &run.timeline),
        timeline_seed: shown.map(|run| run.seed),
    }
}
