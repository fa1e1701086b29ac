//! `lmpc study`.

use std::fs;
use std::path::PathBuf;

use anyhow::{Context as _, Result};

use super::{Outcome, campaign, study_report, study_tracks};
use command_line::{PaperStudyArgs, Study, StudyArgs};
use hosting::parallel::{parallel, threads};
use studies::{
    Cell, Definition, Ledger, RunRow, StudyCase, StudyName, page, run_one, summarize, text_table,
};
use terminal::progress::bar;
use terminal::{Talk, result};

/// Runs a study.
pub(super) fn run(args: &StudyArgs, talk: Talk) -> Result<Outcome> {
    match &args.study {
        None => campaign::run(&args.campaign, talk),
        Some(Study::Crc(args)) => paper(StudyName::Crc, args, talk),
        Some(Study::Bandwidth(args)) => paper(StudyName::Bandwidth, args, talk),
        Some(Study::Hardware(args)) => paper(StudyName::Hardware, args, talk),
        Some(Study::Tracks(args)) => study_tracks::run(args, talk),
        Some(Study::Merge(args)) => campaign::merge(args),
        Some(Study::Report(args)) => study_report::run(args),
    }
}

/// Runs what is missing of a study of the paper and prints its table.
fn paper(name: StudyName, args: &PaperStudyArgs, talk: Talk) -> Result<Outcome> {
    let study = Definition::of(name)?;
    let cases = StudyCase::of(&study, &args.set, args.seeds, args.laps)?;
    let out =
        args.out.clone().unwrap_or_else(|| PathBuf::from(format!("out/study-{}", name.as_str())));
    let keys: Vec<_> = cases.iter().map(StudyCase::key).collect();
    let mut ledger = Ledger::open(&out, &keys, args.fresh)?;
    let done: Vec<_> = ledger.runs.iter().map(RunRow::key).collect();
    let missing: Vec<&StudyCase> =
        cases.iter().filter(|case| !done.contains(&case.key())).collect();
    talk.say(&format!(
        "{}: {} runs, {} kept from {}{}",
        study.title,
        cases.len(),
        done.len(),
        out.display(),
        others(ledger.other_runs.len())
    ));

    let bar = bar(cases.len() as u64, done.len() as u64, talk);
    let ran = parallel(
        &missing,
        threads(args.jobs),
        |case| run_one(case),
        |_, run| -> Result<()> {
            let (run, laps) = run?;
            bar.set_message(format!(
                "{} {} h {} seed {}: {}",
                run.regression,
                run.control_rate_cost,
                run.bandwidth,
                run.seed,
                run.itf.map_or_else(
                    || run.best_lap_s.map_or(String::new(), |b| format!("{b:.2} s")),
                    |lap| format!("failed in lap {lap}"),
                )
            ));
            ledger.add(run, laps)?;
            bar.inc(1);
            Ok(())
        },
    );
    bar.finish_and_clear();
    ran?;
    ledger.sort(&keys)?;

    let mut cells: Vec<Cell> = cases.iter().map(|case| case.cell.clone()).collect();
    cells.dedup();
    let summaries = summarize(&study, &cells, &ledger.runs);
    let report = out.join("report.html");
    fs::write(&report, page(&study, &summaries, &ledger.runs, &ledger.laps))
        .with_context(|| format!("cannot write {}", report.display()))?;
    if args.json {
        terminal::json(&summaries)?;
    } else {
        result(&study.title)?;
        result(&text_table(&summaries))?;
        result(&format!("runs: {}, report: {}", out.join("runs.csv").display(), report.display()))?;
    }
    // A study in which cars fail has done its work: that is what it measures.
    Ok(Outcome::Done)
}

/// What is said of the runs in a table that are no part of a study.
pub(super) fn others(count: usize) -> String {
    match count {
        0 => String::new(),
        1 => "; 1 run with other settings or of another version stays there".to_owned(),
        _ => format!("; {count} runs with other settings or of another version stay there"),
    }
}
