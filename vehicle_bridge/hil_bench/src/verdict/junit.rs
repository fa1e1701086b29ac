//! The verdict as JUnit XML: one suite for each scenario, one case for each run.

use std::fmt::Write as _;

use svg_page::escape;

use super::{Distribution, Tested, Verdict, number, word};
use crate::bench::Bench;
use crate::run::RunOutcome;

/// JUnit XML, as Jenkins and Surefire read it. What was tested and the distributions are properties
/// of the suites; the values of a run against its limits are the case's `system-out`.
#[must_use]
pub fn junit(bench: &Bench, tested: &Tested, verdicts: &[Verdict<'_>]) -> String {
    let total: usize = verdicts.iter().map(|v| v.runs.len()).sum();
    let failed: usize = verdicts.iter().map(Verdict::failed).sum();
    let mut xml = format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
         <testsuites name=\"{}\" tests=\"{total}\" failures=\"{failed}\">\n",
        escape(&bench.title)
    );
    for verdict in verdicts {
        suite(verdict, tested, &mut xml);
    }
    xml.push_str("</testsuites>\n");
    xml
}

fn suite(verdict: &Verdict<'_>, tested: &Tested, xml: &mut String) {
    let name = escape(&verdict.scenario.name);
    let time: f64 = verdict.runs.iter().map(|run| run.duration).sum();
    let _ = writeln!(
        xml,
        "<testsuite name=\"{name}\" tests=\"{}\" failures=\"{}\" errors=\"0\" skipped=\"0\" time=\"{time:.3}\">",
        verdict.runs.len(),
        verdict.failed()
    );
    xml.push_str("<properties>\n");
    let mut property = |name: &str, value: &str| {
        let (name, value) = (escape(name), escape(value));
        let _ = writeln!(xml, "<property name=\"{name}\" value=\"{value}\"/>");
    };
    property("verdict", word(verdict.failed() == 0));
    for (name, value) in tested.lines() {
        property(name, &value);
    }
    property("expected", &verdict.scenario.expected);
    let distributions = verdict.distributions();
    for d in &distributions {
        let failed = verdict.counted(d.broken);
        property(&d.name, &format!("limit {}: {}; broken by {failed}", d.limit, d.text()));
    }
    xml.push_str("</properties>\n");
    for run in &verdict.runs {
        let inside = case(run, &distributions);
        let _ = writeln!(
            xml,
            "<testcase classname=\"{name}\" name=\"seed {}\" time=\"{:.3}\">{inside}</testcase>",
            run.seed, run.duration
        );
    }
    xml.push_str("</testsuite>\n");
}

/// Failure and values of a run.
fn case(run: &RunOutcome, distributions: &[Distribution]) -> String {
    let mut inside = String::new();
    let broken = escape(&run.broken.join("; "));
    if !broken.is_empty() {
        let _ = write!(inside, "<failure type=\"limit\" message=\"{broken}\">{broken}</failure>");
    }
    let line = |d: &Distribution| {
        let value = run.values.get(d.name.as_str()).map_or("never happened".to_owned(), number);
        format!("{} {value}, limit {}\n", d.name, d.limit)
    };
    let mut text: String = distributions.iter().map(line).collect();
    if !run.disturbed.is_empty() {
        text = format!("{text}disturbed, repeated: {}\n", run.disturbed.join("\n"));
    }
    let _ = write!(inside, "<system-out>{}</system-out>", escape(&text));
    inside
}
