//! `lmpc race`.

use std::fs;
use std::path::Path;

use anyhow::{Context as _, Result};
use bounded_file::Limit;
use controller::Response;
use serde_json::json;

use super::{Outcome, folders, optimum, seeds, setup, vehicle};
use command_line::{OnFailure, RaceArgs};
use hosting::{learned, problem_file};
use optimum_store::{Known, OptimumStore};
use racing::raceline::{self, Raceline};
use racing::record::{Failure, StepRow, is_fallback};
use racing::words::{action_word, kind_word, mode_word, model_word, reason_word};
use racing::{Race, RaceOptions, files};
use report::{Report, best_lap};
use terminal::lap_table::{LapTable, head};
use terminal::{BAD, BEST, SOFT, Talk, WARN, paint, result};

/// Races once, or over several seeds.
pub(super) fn run(args: &RaceArgs, talk: Talk) -> Result<Outcome> {
    let mut options = setup::race(&args.controller, args.laps, talk)?;
    options.limit = args.limit.limit(&options.config);
    let known = known(args, &options, talk)?;
    let known = known.as_ref();
    let raceline = given_line(args)?;
    options.recover = args.on_failure == OnFailure::Recover;
    if options.recover {
        options.config.recovery.active = true;
    }
    if let Some(count) = args.seeds {
        return seeds::run(args, &options, count, known, talk);
    }
    options.seed = args.seed;
    options.keep_unsolved = args.dump_qp.is_some();
    options.config.warm_up.seed = args.seed;
    folders::results(&args.out)?;
    args.dump_qp.as_deref().map_or(Ok(()), folders::results)?;
    args.save.as_deref().map_or(Ok(()), folders::file)?;
    let lead = lead(&options);
    talk.say(&lead);
    let mut race = vehicle::race(args, &options)?;
    if let Some(path) = &args.load {
        learned::load(path, race.controller_mut())?;
        talk.say(&format!(
            "{} laps loaded from {}",
            race.controller().laps().len(),
            path.display()
        ));
    }
    drive(&mut race, args.json, talk)?;
    write(&args.out, &race, &options, &lead, (known, raceline.as_ref()))?;
    if let Some(folder) = &args.dump_qp {
        dump(folder, &race, talk)?;
    }
    if let Some(path) = &args.save {
        race.controller_mut().finish_learning();
        learned::save(path, race.controller())?;
        talk.say(&format!("learned data saved to {}", path.display()));
    }
    if args.json {
        terminal::json(&summary(&race, &args.out, known))?;
    } else {
        for line in account(&race, known) {
            result(&line)?;
        }
        result(&format!("report: {}", args.out.join("report.html").display()))?;
    }
    Ok(outcome(&race))
}

/// Drives; the table goes to standard output unless that is to hold JSON.
fn drive(race: &mut Race, json: bool, talk: Talk) -> Result<()> {
    let print = |line: &str| -> std::io::Result<()> {
        if json {
            talk.say(line);
            return Ok(());
        }
        result(line)
    };
    print(&head())?;
    let mut table = LapTable::default();
    let mut closed = Ok(());
    race.run(|lap| {
        if closed.is_ok() {
            closed = print(&table.line(lap));
        }
    })?;
    Ok(closed?)
}

/// Writes the problems that were not solved to tolerance.
fn dump(folder: &Path, race: &Race, talk: Talk) -> Result<()> {
    for (step, problem) in &race.unsolved {
        problem_file::write(&folder.join(format!("step{step:06}.json")), problem)?;
    }
    talk.say(&format!("{} problems written to {}", race.unsolved.len(), folder.display()));
    Ok(())
}

/// What was run, in a sentence.
pub(super) fn lead(options: &RaceOptions) -> String {
    let (config, car) = (&options.config, &options.nominal);
    let (plant, track) = (&options.plant.car, &options.track);
    format!(
        "{} on {} ({:.2} m), {} warm-up and {} learning laps, {} regression, {} nominal model, \
         nominal grip {:.2}, true grip {:.2}, seed {}",
        plant.name,
        track.name(),
        track.length(),
        config.warm_up.laps,
        options.laps,
        mode_word(config.regression.mode),
        model_word(config.nominal.model),
        car.tyre_front.mu,
        plant.tyre_front.mu,
        options.seed
    )
}

/// Writes every file of a race.
pub(super) fn write(
    out: &Path,
    race: &Race,
    options: &RaceOptions,
    lead: &str,
    (optimum, raceline): (Option<&Known>, Option<&Raceline>),
) -> Result<()> {
    let at = |name: &str| out.join(name);
    let failed = |name: &str| format!("cannot write {}", at(name).display());
    files::write_laps(&at("laps.csv"), &race.laps).with_context(|| failed("laps.csv"))?;
    files::write_trajectory(&at("trajectory.csv"), &race.steps)
        .with_context(|| failed("trajectory.csv"))?;
    files::write_timings(&at("timings.csv"), &race.steps, &race.times)
        .with_context(|| failed("timings.csv"))?;
    if let Some(text) = learned_line(race, options) {
        fs::write(at("raceline.csv"), text).with_context(|| failed("raceline.csv"))?;
    }
    let report = Report {
        car: &options.plant.car.name,
        track: &options.track,
        config: &options.config,
        lead,
        laps: &race.laps,
        steps: &race.steps,
        times: &race.times,
        optimum,
        raceline,
        failure: race.failure.as_ref(),
    };
    fs::write(at("report.html"), report.html()).with_context(|| failed("report.html"))
}

/// The best learned lap as a raceline.
fn learned_line(race: &Race, options: &RaceOptions) -> Option<String> {
    let best = best_lap(&race.laps)?;
    let steps: Vec<StepRow> =
        race.steps.iter().filter(|row| row.status.lap == best.result.lap).copied().collect();
    let title = format!(
        "{} on {}, learned lap {:.6} s",
        options.plant.car.name,
        options.track.name(),
        best.result.lap_time
    );
    Some(raceline::text(&title, &steps, options.config.horizon.period))
}

/// The raceline that was given to compare with.
pub(super) fn given_line(args: &RaceArgs) -> Result<Option<Raceline>> {
    let Some(path) = &args.raceline else { return Ok(None) };
    let shown = path.display().to_string();
    let text = bounded_file::text(path, Limit::SETTINGS)?;
    let line = raceline::read(&shown, &text);
    Ok(Some(line.with_context(|| format!("{shown} is no raceline"))?))
}

/// The time-optimal lap to measure against: a kept one, or one found now if that is asked for.
fn known(args: &RaceArgs, options: &RaceOptions, talk: Talk) -> Result<Option<Known>> {
    let (car, track) = (&options.plant.car, &options.track);
    let margin = options.config.limits.lane_margin;
    let store = OptimumStore::of(&args.controller.track, args.store.as_deref());
    let kept = store.find(car, track, margin);
    if kept.is_some() || !args.optimum {
        return Ok(kept);
    }
    talk.say(&format!("seeking the time-optimal lap, {margin} m from the edges"));
    let lap = optimum::solve(car, track, &::optimum::Options::new(margin), talk)?;
    store.save(car, track, margin, &lap)?;
    Ok(Some(Known::new(car, track, margin, &lap)))
}

/// How the race went, in words.
fn account(race: &Race, known: Option<&Known>) -> Vec<String> {
    let mut lines = Vec::new();
    if let Some(best) = best_lap(&race.laps) {
        let text = format!("best lap {:.3} s (lap {})", best.result.lap_time, best.result.lap);
        lines.push(paint(BEST, &text));
        if let Some(known) = known {
            lines.push(measured(best.result.lap_time, known));
        }
    }
    if race.controller().response_found() {
        let Response { delay, lag } = race.controller().response();
        let text = format!("delay of {delay:.3} s and lag of {lag:.3} s found");
        lines.push(paint(WARN, &text));
    }
    let share = race.controller().road_grip();
    if share < 1.0 {
        let text = format!("at the end the road had {:.0} % of the fitted grip", 100.0 * share);
        lines.push(paint(WARN, &text));
    }
    for incident in &race.incidents {
        lines.push(paint(WARN, &format!("recovered: {incident}")));
    }
    if let Some(failure) = &race.failure {
        lines.push(paint(BAD, &format!("failed: {failure}")));
    }
    for (reason, count) in fallbacks(&race.steps) {
        lines.push(paint(WARN, &format!("fell back in {count} steps: {reason}")));
    }
    if lines.is_empty() {
        lines.push(paint(SOFT, "no learning lap was finished"));
    }
    lines
}

/// A lap time against the time-optimal one.
pub(super) fn measured(lap_time: f64, known: &Known) -> String {
    let ratio = lap_time / known.lap_time_s;
    format!("{ratio:.3} times the time-optimal {:.3} s", known.lap_time_s)
}

/// Fallbacks by action and reason.
fn fallbacks(steps: &[StepRow]) -> std::collections::BTreeMap<String, usize> {
    let mut counts = std::collections::BTreeMap::new();
    for status in steps.iter().map(|row| &row.status).filter(|s| is_fallback(s)) {
        let name = format!("{} ({})", action_word(status.action), reason_word(status.reason));
        *counts.entry(name).or_default() += 1;
    }
    counts
}

/// Whether the race was degraded.
pub(super) fn outcome(race: &Race) -> Outcome {
    let fell_back = race.steps.iter().any(|row| is_fallback(&row.status));
    if race.failure.is_some() || fell_back { Outcome::Degraded } else { Outcome::Done }
}

fn summary(race: &Race, out: &Path, known: Option<&Known>) -> serde_json::Value {
    let laps: Vec<_> = race
        .laps
        .iter()
        .map(|lap| {
            json!({
                "lap": lap.result.lap,
                "kind": kind_word(lap.result.kind),
                "iteration": lap.iteration,
                "lap_time_s": lap.result.lap_time,
                "valid": lap.result.valid,
                "v_max_mps": lap.v_max,
                "e_y_max_m": lap.e_y_max,
                "overhang_max_m": lap.overhang_max,
                "fallbacks": lap.fallbacks,
                "clipped": lap.clipped,
            })
        })
        .collect();
    let failed = |f: &Failure| {
        json!({
            "reason": f.reason.as_str(),
            "iteration": f.iteration,
            "time_s": f.time,
            "s_m": f.x.s,
            "e_y_m": f.x.e_y,
            "v_x_mps": f.x.v_x,
            "e_psi_rad": f.x.e_psi,
            "beyond_m": f.beyond,
            "message": f.to_string(),
        })
    };
    json!({
        "laps": laps,
        "best_lap_s": best_lap(&race.laps).map(|lap| lap.result.lap_time),
        "optimum_s": known.map(|known| known.lap_time_s),
        "failure": race.failure.as_ref().map(failed),
        "incidents": race.incidents.iter().map(failed).collect::<Vec<_>>(),
        "fallbacks": fallbacks(&race.steps),
        "grip": race.controller().grip(),
        "road_grip": race.controller().road_grip(),
        "delay_s": race.controller().response().delay,
        "lag_s": race.controller().response().lag,
        "out": out.display().to_string(),
    })
}
