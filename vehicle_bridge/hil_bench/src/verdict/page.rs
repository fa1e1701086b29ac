//! The verdict as a page that can be filed: it prints on A4, reads without colour, and neither cuts
//! a text off nor scrolls sideways.

use std::fmt::Write as _;

use svg_page::panels::HATCH;
use svg_page::{card, escape, styled_page};

use super::strip::strip;
use super::times::drawing;
use super::{Distribution, Tested, Verdict, failed_first, number, passed, word};
use crate::bench::Bench;

/// Reasons of a scenario's failure that the table names; the rest are in the JUnit and JSON files.
const REASONS: usize = 5;

/// The page: PASS or FAIL, what was tested, a row for each scenario, failed ones first, and the
/// timeline of each scenario's first failed, else first run.
#[must_use]
pub fn page(bench: &Bench, tested: &Tested, verdicts: &[Verdict<'_>]) -> String {
    let verdicts_sorted = failed_first(verdicts);
    let failed = verdicts.iter().filter(|verdict| verdict.failed() > 0).count();
    let runs: usize = verdicts.iter().map(|verdict| verdict.runs.len()).sum();
    let failed_runs: usize = verdicts.iter().map(Verdict::failed).sum();
    let all = passed(verdicts);
    let summary = format!(
        "{} of {} scenarios passed, {} of {runs} runs.",
        verdicts.len() - failed,
        verdicts.len(),
        runs - failed_runs
    );
    let mut body = format!(
        "{HATCH}<section class=\"opening {}\">\n<p class=\"word\">{}</p>\n<p>{summary}</p>\n{}\
         </section>\n",
        if all { "good" } else { "bad" },
        word(all),
        facts(tested)
    );
    let rows: String = verdicts_sorted.iter().map(|verdict| row(verdict)).collect();
    let table = format!(
        "<table class=\"verdicts\"><thead><tr><th>verdict</th><th>scenario</th>\
         <th>measured against its limit</th></tr></thead>\n<tbody>\n{rows}</tbody></table>\n"
    );
    let note = "Each dot is a run, the bar the median, the thick line the limit; what it refuses is \
                hatched. A limit that was never measured is broken. Beyond is how far the farthest point \
                of the body was beyond the edge of the track, negative inside.";
    body.push_str(&card("Scenarios", note, &table));
    for verdict in &verdicts_sorted {
        body.push_str(&timeline(verdict));
    }
    styled_page(&bench.title, "Verdict of lmpc hil run", include_str!("page.css"), &body, "")
}

/// What was tested, line by line, with room to sign.
fn facts(tested: &Tested) -> String {
    let mut out = "<table class=\"tested\"><tbody>\n".to_owned();
    for (name, value) in tested.lines() {
        let value =
            if value.is_empty() { "<i class=\"blank\"></i>".to_owned() } else { escape(&value) };
        let _ = writeln!(out, "<tr><th>{name}</th><td>{value}</td></tr>");
    }
    out + "<tr><th>signature</th><td><i class=\"blank\"></i></td></tr>\n</tbody></table>\n"
}

/// One row of the table.
fn row(verdict: &Verdict<'_>) -> String {
    let s = verdict.scenario;
    let (passed, failed) = (verdict.failed() == 0, verdict.failed());
    let row = s.row.map_or(String::new(), |row| format!(" <span>row {row}</span>"));
    let reasons = reasons(verdict);
    let limits: String = verdict.distributions().iter().map(limit).collect();
    format!(
        "<tr class=\"{}\"><td><b>{}</b><br>{}</td><td><b>{}</b>{row}<br>{}{reasons}</td><td>\
         <table class=\"limits\"><tbody>{limits}</tbody></table></td></tr>\n",
        if passed { "good" } else { "bad" },
        word(passed),
        escape(&format!("failed {}", verdict.counted(failed))),
        escape(&s.name),
        escape(&s.expected),
    )
}

/// One limit of a row: what, allowed, the runs.
fn limit(d: &Distribution) -> String {
    let unit = if d.unit.is_empty() { String::new() } else { format!(" {}", d.unit) };
    let measured = match (d.values.first(), d.values.last()) {
        (Some(least), Some(most)) if least == most => format!("{}{unit}", number(*most)),
        (Some(least), Some(most)) => {
            let of = |share| d.quantile(share).map(number).unwrap_or_default();
            format!(
                "{} to {}{unit}<br>p50 {}, p99 {}",
                number(*least),
                number(*most),
                of(0.5),
                of(0.99)
            )
        }
        _ => "never happened".to_owned(),
    };
    let broken = match d.broken {
        0 => String::new(),
        n => format!("<br><b>broken in {n}</b>"),
    };
    format!(
        "<tr><td>{}<br>limit {}{unit}</td><td>{}</td><td>{measured}{broken}</td></tr>",
        escape(&d.words),
        escape(&d.limit),
        strip(d)
    )
}

/// Why runs failed, each reason with its seed.
fn reasons(verdict: &Verdict<'_>) -> String {
    let failed: Vec<_> = verdict.runs.iter().filter(|run| !run.broken.is_empty()).collect();
    let mut out = String::new();
    for run in failed.iter().take(REASONS) {
        let broken = escape(&run.broken.join("; "));
        let _ = write!(out, "<li>seed {}: {broken}</li>", run.seed);
    }
    if failed.len() > REASONS {
        let _ = write!(out, "<li>and {} more runs</li>", failed.len() - REASONS);
    }
    if out.is_empty() { out } else { format!("<ul>{out}</ul>") }
}

/// The timeline of the run that is shown.
fn timeline(verdict: &Verdict<'_>) -> String {
    let Some(run) = verdict.shown() else { return String::new() };
    let picture = drawing(verdict, run);
    let mut note = format!("{}: seed {}.", word(run.broken.is_empty()), run.seed);
    if !run.broken.is_empty() {
        note = format!("{note} Broken: {}.", run.broken.join("; "));
    }
    if !run.disturbed.is_empty() {
        note = format!("{note} Disturbed and repeated: {}.", run.disturbed.join("; "));
    }
    if picture.is_empty() && run.broken.is_empty() && run.disturbed.is_empty() {
        return String::new();
    }
    card(&verdict.scenario.name, &note, &picture)
}
