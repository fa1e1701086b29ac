//! `lmpc race --seeds`: the same race with several seeds.

use anyhow::Result;
use comfy_table::{Cell, CellAlignment, Table, presets};
use serde_json::json;

use super::race::{given_line, lead, measured, outcome, write};
use super::{Outcome, folders, vehicle};
use command_line::RaceArgs;
use hosting::parallel::{parallel, threads};
use optimum_store::Known;
use racing::record::{is_fallback, median};
use racing::{Race, RaceOptions};
use report::best_lap;
use terminal::{BAD, GOOD, Talk, paint, result};

/// What is kept of each seed.
struct Seed {
    seed: u64,
    learned: usize,
    lap_5: Option<f64>,
    lap_10: Option<f64>,
    lap_20: Option<f64>,
    last: Option<f64>,
    best: Option<f64>,
    failure: Option<String>,
    fallbacks: usize,
    incidents: usize,
    outcome: Outcome,
}

/// Races every seed and sums up.
pub(super) fn run(
    args: &RaceArgs,
    base: &RaceOptions,
    count: u32,
    known: Option<&Known>,
    talk: Talk,
) -> Result<Outcome> {
    let seeds: Vec<u64> = (0..u64::from(count)).map(|i| args.seed + i).collect();
    let raceline = given_line(args)?;
    talk.say(&lead(base));
    folders::results(&args.out)?;
    let mut done: Vec<Seed> = Vec::new();
    let work = |&seed: &u64| -> Result<Seed> {
        let mut options = base.clone();
        options.seed = seed;
        options.config.warm_up.seed = seed;
        let mut race = vehicle::race(args, &options)?;
        race.run(|_| {})?;
        let folder = args.out.join(format!("seed-{seed}"));
        folders::results(&folder)?;
        write(&folder, &race, &options, &lead(&options), (known, raceline.as_ref()))?;
        Ok(sum_up(seed, &race))
    };
    parallel(&seeds, threads(args.jobs), work, |_, seed| -> Result<()> {
        let seed = seed?;
        let end = seed.failure.clone().unwrap_or_else(|| "done".to_owned());
        let best = seed.best.map_or("-".to_owned(), |b| format!("{b:.3} s"));
        talk.say(&format!("seed {}: best {best}, {end}", seed.seed));
        done.push(seed);
        Ok(())
    })?;
    done.sort_by_key(|seed| seed.seed);
    if args.json {
        terminal::json(&as_json(&done, known))?;
    } else {
        result(&table(&done).to_string())?;
        let failed = done.iter().filter(|s| s.failure.is_some()).count();
        let style = if failed == 0 { GOOD } else { BAD };
        result(&paint(style, &format!("{failed} of {} runs failed", done.len())))?;
        let best = done.iter().filter_map(|s| s.best).fold(f64::INFINITY, f64::min);
        if let Some(known) = known.filter(|_| best.is_finite()) {
            result(&measured(best, known))?;
        }
        result(&format!("reports: {}", args.out.join("seed-*/report.html").display()))?;
    }
    let degraded = done.iter().any(|s| s.outcome == Outcome::Degraded);
    Ok(if degraded { Outcome::Degraded } else { Outcome::Done })
}

fn sum_up(seed: u64, race: &Race) -> Seed {
    let learned: Vec<f64> =
        race.laps.iter().filter(|l| l.is_learning()).map(|l| l.result.lap_time).collect();
    Seed {
        seed,
        learned: learned.len(),
        lap_5: learned.get(4).copied(),
        lap_10: learned.get(9).copied(),
        lap_20: learned.get(19).copied(),
        last: learned.last().copied(),
        best: best_lap(&race.laps).map(|lap| lap.result.lap_time),
        failure: race.failure.as_ref().map(ToString::to_string),
        incidents: race.incidents.len(),
        fallbacks: race.steps.iter().filter(|row| is_fallback(&row.status)).count(),
        outcome: outcome(race),
    }
}

fn table(seeds: &[Seed]) -> Table {
    let mut table = Table::new();
    table.load_style(presets::NOTHING);
    table.set_header([
        "seed",
        "laps",
        "lap 5",
        "lap 10",
        "lap 20",
        "last",
        "best",
        "fell back",
        "recovered",
        "failure",
    ]);
    let time = |t: Option<f64>| t.map_or("-".to_owned(), |t| format!("{t:.3}"));
    let right = |text: String| Cell::new(text).set_alignment(CellAlignment::Right);
    for s in seeds {
        let times = [s.lap_5, s.lap_10, s.lap_20, s.last, s.best].map(time);
        let mut row = vec![right(s.seed.to_string()), right(s.learned.to_string())];
        row.extend(times.map(right));
        row.push(right(s.fallbacks.to_string()));
        row.push(right(s.incidents.to_string()));
        row.push(Cell::new(s.failure.clone().unwrap_or_default()));
        table.add_row(row);
    }
    let middle = |of: fn(&Seed) -> Option<f64>| {
        let value = median(&mut seeds.iter().filter_map(of).collect::<Vec<f64>>());
        right(if value.is_nan() { "-".to_owned() } else { format!("{value:.3}") })
    };
    table.add_row([
        right("median".to_owned()),
        right(String::new()),
        middle(|s| s.lap_5),
        middle(|s| s.lap_10),
        middle(|s| s.lap_20),
        middle(|s| s.last),
        middle(|s| s.best),
    ]);
    table
}

fn as_json(seeds: &[Seed], known: Option<&Known>) -> serde_json::Value {
    let rows: Vec<_> = seeds
        .iter()
        .map(|s| {
            json!({
                "seed": s.seed,
                "laps_completed": s.learned,
                "lap_20_s": s.lap_20,
                "last_lap_s": s.last,
                "best_lap_s": s.best,
                "failure": s.failure,
                "fallbacks": s.fallbacks,
                "incidents": s.incidents,
            })
        })
        .collect();
    json!({ "seeds": rows, "optimum_s": known.map(|known| known.lap_time_s) })
}
