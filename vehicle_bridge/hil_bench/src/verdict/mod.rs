//! Runs summed up: what was tested, each limit against what was measured, PASS or FAIL; as a page
//! ([`page()`]), as JUnit ([`junit()`]) and as JSON ([`json()`]).

mod distribution;
mod junit;
mod page;
mod record;
mod strip;
mod tested;
mod times;

pub use distribution::{Distribution, number};
pub use junit::junit;
pub use page::page;
pub use record::json;
pub use tested::Tested;

use super::bench::Scenario;
use super::run::RunOutcome;

/// A scenario and its runs.
#[derive(Debug, Clone)]
pub struct Verdict<'a> {
    /// The scenario.
    pub scenario: &'a Scenario,
    /// Its runs by seed.
    pub runs: Vec<RunOutcome>,
}

impl Verdict<'_> {
    /// Runs that broke a limit.
    #[must_use]
    pub fn failed(&self) -> usize {
        self.runs.iter().filter(|run| !run.broken.is_empty()).count()
    }

    /// Runs that were repeated because the computer itself stood still.
    #[must_use]
    pub fn repeated(&self) -> usize {
        self.runs.iter().map(|run| run.disturbed.len()).sum()
    }

    /// One distribution for each expectation.
    #[must_use]
    pub fn distributions(&self) -> Vec<Distribution> {
        let of = |expectation| Distribution::new(expectation, &self.runs);
        self.scenario.expectations.iter().map(of).collect()
    }

    /// The run that is shown: the first that failed, else the first.
    fn shown(&self) -> Option<&RunOutcome> {
        self.runs.iter().find(|run| !run.broken.is_empty()).or(self.runs.first())
    }

    /// `3 of 10`, with what was repeated.
    fn counted(&self, failed: usize) -> String {
        let text = format!("{failed} of {}", self.runs.len());
        match self.repeated() {
            0 => text,
            repeated => format!("{text}, {repeated} repeated"),
        }
    }
}

/// `PASS` or `FAIL`.
fn word(passed: bool) -> &'static str {
    if passed { "PASS" } else { "FAIL" }
}

/// Whether every run of every scenario met its limits.
fn passed(verdicts: &[Verdict<'_>]) -> bool {
    verdicts.iter().all(|verdict| verdict.failed() == 0)
}

/// The verdicts, those that failed first, else in the file's order.
fn failed_first<'v, 'b>(verdicts: &'v [Verdict<'b>]) -> Vec<&'v Verdict<'b>> {
    let mut sorted: Vec<_> = verdicts.iter().collect();
    sorted.sort_by_key(|verdict| verdict.failed() == 0);
    sorted
}

/// Rows of a table in a terminal, one for each expectation, failed scenarios first: row, scenario,
/// expected, measure, limit, measured, runs that broke this limit.
#[must_use]
pub fn rows(verdicts: &[Verdict<'_>]) -> Vec<Vec<String>> {
    let mut rows = Vec::new();
    for verdict in failed_first(verdicts) {
        let s = verdict.scenario;
        let row = s.row.map_or(String::new(), |row| row.to_string());
        rows.extend(verdict.distributions().into_iter().map(|d| {
            let failed = verdict.counted(d.broken);
            let measured = d.text();
            vec![row.clone(), s.name.clone(), s.expected.clone(), d.name, d.limit, measured, failed]
        }));
    }
    rows
}
