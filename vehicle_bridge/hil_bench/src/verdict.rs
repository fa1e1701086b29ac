//! Runs summed up: expected, limit, measured.

use super::bench::{Bench, Scenario};
use super::measure::Expectation;
use super::run::Outcome;

/// A scenario and its runs.
#[derive(Debug, Clone)]
pub struct Verdict<'a> {
    /// The scenario.
    pub scenario: &'a Scenario,
    /// Its runs by seed.
    pub runs: Vec<Outcome>,
}

/// A measure over the runs.
#[derive(Debug, Clone, PartialEq)]
pub struct Distribution {
    /// The limit in words.
    pub limit: String,
    /// What is measured.
    pub name: String,
    /// Runs that measured it. \[-\]
    pub count: usize,
    /// Median.
    pub median: f64,
    /// 99th percentile.
    pub p99: f64,
    /// Largest.
    pub max: f64,
    /// Smallest.
    pub min: f64,
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
        self.scenario.expectations.iter().map(|e| self.distribution(e)).collect()
    }

    fn distribution(&self, expectation: &Expectation) -> Distribution {
        let mut values: Vec<f64> =
            self.runs.iter().filter_map(|run| run.values.get(&expectation.measure)).collect();
        values.sort_by(f64::total_cmp);
        let at = |share: f64| {
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "an index")]
            let index = (share * values.len() as f64).ceil() as usize;
            values.get(index.saturating_sub(1)).copied().unwrap_or(f64::NAN)
        };
        Distribution {
            limit: expectation.limit(),
            name: expectation.measure.text(),
            count: values.len(),
            median: at(0.5),
            p99: at(0.99),
            max: at(1.0),
            min: at(0.0),
        }
    }
}

impl Distribution {
    /// In a cell of a table.
    #[must_use]
    pub fn text(&self) -> String {
        let n = |value: f64| {
            if value.fract() == 0.0 { format!("{value}") } else { format!("{value:.1}") }
        };
        if self.count == 0 {
            "never happened".to_owned()
        } else if self.min == self.max {
            n(self.max)
        } else {
            format!(
                "{} to {}, p50 {}, p99 {}",
                n(self.min),
                n(self.max),
                n(self.median),
                n(self.p99)
            )
        }
    }
}

/// JUnit XML: one suite for each scenario, one case for each run.
#[must_use]
pub fn junit(bench: &Bench, verdicts: &[Verdict<'_>]) -> String {
    use std::fmt::Write as _;
    let escape = svg_page::escape;
    let total: usize = verdicts.iter().map(|v| v.runs.len()).sum();
    let failed: usize = verdicts.iter().map(Verdict::failed).sum();
    let mut xml = format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
         <testsuites name=\"{}\" tests=\"{total}\" failures=\"{failed}\">\n",
        escape(&bench.title)
    );
    for verdict in verdicts {
        let name = escape(&verdict.scenario.name);
        let time: f64 = verdict.runs.iter().map(|run| run.duration).sum();
        let _ = writeln!(
            xml,
            "<testsuite name=\"{name}\" tests=\"{}\" failures=\"{}\" errors=\"0\" skipped=\"0\" time=\"{time:.3}\">",
            verdict.runs.len(),
            verdict.failed()
        );
        for run in &verdict.runs {
            let case = format!(
                "<testcase classname=\"{name}\" name=\"seed {}\" time=\"{:.3}\"",
                run.seed, run.duration
            );
            let (broken, disturbed) = (run.broken.join("; "), run.disturbed.join("\n"));
            let mut inside = String::new();
            if !broken.is_empty() {
                let text = escape(&broken);
                let _ =
                    write!(inside, "<failure type=\"limit\" message=\"{text}\">{text}</failure>");
            }
            if !disturbed.is_empty() {
                let text = escape(&disturbed);
                let _ = write!(inside, "<system-out>disturbed, repeated: {text}</system-out>");
            }
            let _ = writeln!(xml, "{case}>{inside}</testcase>");
        }
        xml.push_str("</testsuite>\n");
    }
    xml.push_str("</testsuites>\n");
    xml
}

/// The page: a table, and each scenario's picture of its first failed, else its first run.
#[must_use]
pub fn page(bench: &Bench, verdicts: &[Verdict<'_>]) -> String {
    use svg_page::{Chart, Mark, Series, card, page, table};
    let rows: Vec<Vec<String>> = verdicts.iter().flat_map(rows).collect();
    let head = ["row", "scenario", "expected", "measure", "limit", "measured", "runs failed"];
    let mut body = card("Verdict", "", &table(&head, &rows));
    for verdict in verdicts {
        let shown = verdict.runs.iter().find(|run| !run.broken.is_empty()).or(verdict.runs.first());
        let Some(run) = shown else { continue };
        let mut note =
            format!("{} Seed {}; the faults begin at 0 s.", verdict.scenario.expected, run.seed);
        if !run.broken.is_empty() {
            note = format!("{note} Broken: {}.", run.broken.join("; "));
        }
        if verdict.repeated() > 0 {
            let tries: Vec<_> = verdict.runs.iter().flat_map(|run| &run.disturbed).collect();
            let text = tries.iter().map(|t| t.as_str()).collect::<Vec<_>>().join("; ");
            note = format!("{note} Disturbed and repeated {} times: {text}.", tries.len());
        }
        let mut chart = Chart::new("time [s]", "speed [m/s], applied a [m/s^2], source 0 to 3");
        let of = |f: &dyn Fn(&super::observe::Point) -> f64| {
            run.points.iter().map(|p| (p.time, f(p))).collect::<Vec<_>>()
        };
        chart.series.push(Series::new("speed", "s0", Mark::Line, of(&|p| p.speed)));
        chart.series.push(Series::new("acceleration", "s1", Mark::Line, of(&|p| p.accel)));
        chart.series.push(Series::new(
            "source: 1 command, 2 plan, 3 stop",
            "s2",
            Mark::Line,
            of(&|p| f64::from(p.source)),
        ));
        let picture = if run.points.is_empty() { String::new() } else { chart.html() };
        body.push_str(&card(&verdict.scenario.name, &note, &picture));
    }
    let failed = verdicts.iter().filter(|v| v.failed() > 0).count();
    let lead = format!("{} scenarios, {failed} failed", verdicts.len());
    page(&bench.title, &lead, &body, "")
}

/// Rows of the verdict's table: one for each expectation.
#[must_use]
pub fn rows(verdict: &Verdict<'_>) -> Vec<Vec<String>> {
    let s = verdict.scenario;
    let row = s.row.map_or(String::new(), |row| row.to_string());
    let mut failed = format!("{} of {}", verdict.failed(), verdict.runs.len());
    if verdict.repeated() > 0 {
        failed = format!("{failed}, {} repeated", verdict.repeated());
    }
    let of = |d: Distribution| {
        let measured = d.text();
        vec![
            row.clone(),
            s.name.clone(),
            s.expected.clone(),
            d.name,
            d.limit,
            measured,
            failed.clone(),
        ]
    };
    verdict.distributions().into_iter().map(of).collect()
}
