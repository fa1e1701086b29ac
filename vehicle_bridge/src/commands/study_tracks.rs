//! `lmpc study tracks`.

use std::fs;
use std::sync::Arc;

use anyhow::{Context as _, Result};
use serde_json::json;
use vehicle_model::{CarParams, Track};

use super::study::others;
use super::{Outcome, setup};
use command_line::{ControllerArgs, TracksStudyArgs};
use hosting::parallel::{parallel, threads};
use studies::tracks::{
    Book, Named, Optima, Run, TracksCase, TracksKey, TracksRow, cars, drive, generated, page,
    summarize, text_table, tracks,
};
use terminal::progress::Progress;
use terminal::{BAD, GOOD, Talk, WARN, paint, result};

/// The plant that is the car as its file has it.
const BARE: &str = "none";

/// Runs what is missing of the matrix, and writes its table and page.
pub(super) fn run(args: &TracksStudyArgs, talk: Talk) -> Result<Outcome> {
    let known = tracks(&args.track_names())?;
    for refused in &known.refused {
        talk.say(&paint(WARN, &format!("passed over {}: {}", refused.file, refused.reason)));
    }
    let cases = cases(args, &known.tracks)?;
    let keys: Vec<TracksKey> = cases.iter().map(|case| case.key.clone()).collect();
    let mut book = Book::open(&args.out, &keys, args.resume)?;
    book.rate(&cases);
    let mut done: Vec<TracksKey> = book.rows.iter().map(TracksRow::key).collect();
    done.sort();
    let missing: Vec<&TracksCase> =
        cases.iter().filter(|case| done.binary_search(&case.key).is_err()).collect();
    let out = args.out.display();
    let lead = format!("{} runs of {} learned laps", cases.len(), args.laps);
    talk.say(&format!("{lead}, {} kept from {out}{}", done.len(), others(book.others.len())));

    race(&missing, args, &mut book, cases.len(), talk)?;
    book.sort(&keys)?;

    let summaries = summarize(&cases, &book.rows);
    let file = args.out.join("matrix.html");
    fs::write(&file, page(&lead, &cases, &book.rows, &summaries, &known.refused))
        .with_context(|| format!("cannot write {}", file.display()))?;
    let failed = book.rows.iter().filter(|row| row.failed()).count();
    if args.json {
        let refused: Vec<_> =
            known.refused.iter().map(|r| json!({ "file": r.file, "reason": r.reason })).collect();
        let all = json!({
            "runs": book.rows.len(), "failed": failed, "cells": summaries, "refused": refused,
        });
        terminal::json(&all)?;
    } else {
        result(&text_table(&summaries))?;
        let text = format!("{failed} of {} runs failed", book.rows.len());
        result(&paint(if failed == 0 { GOOD } else { BAD }, &text))?;
        result(&format!("runs: {out}/runs.csv, page: {}", file.display()))?;
    }
    Ok(if failed == 0 { Outcome::Done } else { Outcome::Degraded })
}

/// Every run of the matrix: car by car, track by track, plant by plant, seed by seed.
fn cases(args: &TracksStudyArgs, tracks: &[Named<Arc<Track>>]) -> Result<Vec<TracksCase>> {
    let optima = args.optimum.as_deref().map(Optima::load).transpose()?.unwrap_or_default();
    let plants = if args.plant.is_empty() { vec![BARE.to_owned()] } else { args.plant.clone() };
    let mut all = Vec::new();
    for car in &cars(&args.car)? {
        let drawn = generated(&car.value, args.random_seed, args.random.unwrap_or(0))?;
        let of_car = tracks.iter().map(|t| (t, false)).chain(drawn.iter().map(|t| (t, true)));
        for (track, generated) in of_car {
            let names = [car.value.name.as_str(), car.label.as_str()];
            let optimum = optima.find(names, [track.value.name(), &track.label]);
            for plant in &plants {
                let label = if plant.trim().is_empty() { BARE } else { plant.trim() };
                let mut options = setup::assemble(
                    &controller(args, car, track, label),
                    car.value.clone(),
                    Arc::clone(&track.value),
                    args.laps,
                )?;
                options.limit = args.limit.limit(&options.config);
                let names = [car.label.as_str(), track.label.as_str(), label];
                all.extend(TracksCase::of_cell(names, options, args.seeds, optimum, generated));
            }
        }
    }
    Ok(all)
}

/// The options of `lmpc race` for one cell.
fn controller(
    args: &TracksStudyArgs,
    car: &Named<CarParams>,
    track: &Named<Arc<Track>>,
    plant: &str,
) -> ControllerArgs {
    let changes = plant.split(',').filter(|_| plant != BARE).map(str::to_owned);
    ControllerArgs {
        config: args.config.clone(),
        preset: args.preset,
        car: car.given.clone(),
        track: track.given.clone(),
        regression: None,
        nominal: None,
        bandwidth: None,
        control_rate_cost: None,
        no_grip_adaptation: false,
        nominal_mu: args.nominal_mu,
        plant: changes.collect(),
        set: args.set.clone(),
    }
}

/// Drives the cases; failures are shown as they come.
fn race(
    cases: &[&TracksCase],
    args: &TracksStudyArgs,
    book: &mut Book,
    all: usize,
    talk: Talk,
) -> Result<()> {
    let failed = book.rows.iter().filter(|row| row.failed()).count();
    let mut progress = Progress::new((all, all - cases.len(), failed), talk);
    let ran = parallel(
        cases,
        threads(args.jobs),
        |case| drive(case),
        |i, run: Run| -> Result<()> {
            let row = &run.row;
            progress.done(&row.title(), row.failed().then_some(row.fail_message.as_str()));
            book.add(run, cases[i])
        },
    );
    progress.end();
    ran
}
