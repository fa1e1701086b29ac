//! `lmpc optimum`.

use std::fs;
use std::sync::Arc;

use anyhow::{Context as _, Result};
use optimum::{Optimum, Options, SolveProgress};
use serde_json::json;
use vehicle_model::{CarParams, Track};

use super::{Outcome, folders};
use command_line::OptimumArgs;
use hosting::load;
use hosting::settings::{Layers, Usage};
use optimum_store::{OptimumStore, files};
use report::picture;
use terminal::{BEST, SOFT, Talk, paint, result};

/// Finds the time-optimal lap and writes it.
pub(super) fn run(args: &OptimumArgs, talk: Talk) -> Result<Outcome> {
    let car = load::car(&args.car)?;
    let track = load::track(&args.track)?;
    let margin = margin(args, &car, &track)?;
    let options = Options { starts: usize::from(args.starts), ..Options::new(margin) };
    talk.say(&format!(
        "time-optimal lap of {} on {} ({:.2} m), {margin} m from the edges",
        car.name,
        track.name(),
        track.length()
    ));
    folders::results(&args.out)?;
    let lap = solve(&car, &track, &options, talk)?;
    let at = |name: &str| args.out.join(name);
    let write = |name: &str, text: String| {
        fs::write(at(name), text).with_context(|| format!("cannot write {}", at(name).display()))
    };
    write("optimum.csv", files::trajectory(&track, &lap))?;
    write("raceline.csv", files::raceline(&car, &track, &lap))?;
    write("optimum.html", picture::page(&car, &track, margin, &lap))?;
    let store = OptimumStore::of(&args.track, args.store.as_deref());
    let kept = store.save(&car, &track, margin, &lap)?;
    talk.say(&format!("kept as {}", kept.display()));
    if args.json {
        terminal::json(&summary(&car, &track, margin, &lap))?;
        return Ok(Outcome::Done);
    }
    let quality = &lap.quality;
    result(&paint(BEST, &format!("time-optimal lap {:.3} s", lap.lap_time)))?;
    result(&format!(
        "driven by the simulated car it deviates by {:.1e} (scaled) over {} intervals; {} of {} \
         starts converged, the slowest at {:.3} s",
        quality.scaled_defect,
        quality.intervals,
        quality.converged,
        quality.starts,
        quality.slowest_start
    ))?;
    result(&format!("picture: {}", at("optimum.html").display()))?;
    Ok(Outcome::Done)
}

/// The lap, with a line for each part of the work that is done.
pub(super) fn solve(
    car: &CarParams,
    track: &Arc<Track>,
    options: &Options,
    talk: Talk,
) -> Result<Optimum> {
    let found = optimum::solve_with_progress(car, track, options, |progress| match progress {
        SolveProgress::Start { index, steps, lap_time } => {
            let time = lap_time.map_or("did not converge".to_owned(), |t| format!("{t:.3} s"));
            talk.say(&paint(SOFT, &format!("start {}: {time}, {steps} steps", index + 1)));
        }
        SolveProgress::Refined { intervals, steps, lap_time, defect } => {
            let text = format!(
                "{intervals} intervals: {lap_time:.4} s, {steps} steps, largest defect {defect:.1e}"
            );
            talk.say(&paint(SOFT, &text));
        }
    });
    found.with_context(|| format!("no time-optimal lap of {} on {}", car.name, track.name()))
}

/// The margin asked for, or the one the controller keeps.
fn margin(args: &OptimumArgs, car: &CarParams, track: &Track) -> Result<f64> {
    if let Some(margin) = args.margin {
        if !(margin >= 0.0 && margin.is_finite()) {
            let text = format!("--margin {margin}: expected a distance of 0 or above");
            return Err(Usage(text).into());
        }
        return Ok(margin);
    }
    let mut layers = Layers::default();
    if let Some(path) = &args.config {
        layers.file(path)?;
    }
    // The margin of a race follows from the car that its controller believes in.
    let nominal = racing::nominal(&args.car, car.clone(), None)?;
    Ok(layers.build_for(&nominal, track)?.limits.lane_margin)
}

fn summary(car: &CarParams, track: &Track, margin: f64, lap: &Optimum) -> serde_json::Value {
    let quality = &lap.quality;
    json!({
        "car": car.name,
        "track": track.name(),
        "margin_m": margin,
        "lap_time_s": lap.lap_time,
        "scaled_defect": quality.scaled_defect,
        "optimality": quality.optimality,
        "intervals": quality.intervals,
        "starts": quality.starts,
        "starts_converged": quality.converged,
        "slowest_start_s": quality.slowest_start,
    })
}
