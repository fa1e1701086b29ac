//! `lmpc track`.

use std::fs;

use anyhow::{Context as _, Result, bail};
use vehicle_model::Track;
use vehicle_model::track::{ImportOptions, Imported, random};

use super::{Outcome, folders};
use command_line::{ConvertArgs, ImportArgs, RandomArgs, ShowArgs, TrackAction, TrackArgs};
use hosting::load;
use terminal::{BAD, paint, result};

/// Shows, converts or makes a track.
pub(super) fn run(args: &TrackArgs) -> Result<Outcome> {
    match &args.action {
        TrackAction::Show(args) => show(args),
        TrackAction::Convert(args) => convert(args),
        TrackAction::Random(args) => write_random(args),
    }
}

/// The track of a file or name with what became of its points.
fn import(name: &str, args: &ImportArgs) -> Result<Imported> {
    if let Some(track) = Track::builtin(name) {
        return Ok(Imported::exact(track));
    }
    let text = load::track_text(name)?;
    let half = args.width.map(|width| 0.5 * width);
    let options = ImportOptions { smooth: args.smooth, half_width: half };
    match Track::import(name, &text, &options) {
        Ok(imported) => Ok(imported),
        Err(problems) => {
            let first = problems.first().map(ToString::to_string).unwrap_or_default();
            match problems.len().saturating_sub(1) {
                0 => bail!("{name}: {first}"),
                more => bail!("{name}: {first}\n  and {more} more; `lmpc check {name}` lists them"),
            }
        }
    }
}

/// Prints the track's numbers and every change.
fn print(imported: &Imported) -> Result<()> {
    let track = &imported.track;
    let radius = 1.0 / track.max_abs_kappa();
    result(&format!(
        "{}: {:.2} m, at least {:.3} m wide, least radius {radius:.3} m",
        track.name(),
        track.length(),
        track.narrowest()
    ))?;
    if imported.changes.is_empty() {
        result("  nothing changed")?;
    }
    for change in &imported.changes {
        result(&format!("  {change}"))?;
    }
    Ok(())
}

fn show(args: &ShowArgs) -> Result<Outcome> {
    args.out.as_deref().map_or(Ok(()), |out| folders::other_than(args.file.as_ref(), out))?;
    let imported = import(&args.file, &args.import)?;
    print(&imported)?;
    let problems = match &args.car {
        Some(car) => imported.track.problems_for(&load::car(car)?),
        None => Vec::new(),
    };
    for problem in &problems {
        result(&paint(BAD, &format!("  {problem}")))?;
    }
    if let Some(out) = &args.out {
        let page = report::import_page(&imported, &args.file);
        fs::write(out, page).with_context(|| format!("cannot write {}", out.display()))?;
    }
    Ok(if problems.is_empty() { Outcome::Done } else { Outcome::Problems })
}

fn convert(args: &ConvertArgs) -> Result<Outcome> {
    folders::other_than(args.file.as_ref(), &args.out)?;
    let imported = import(&args.file, &args.import)?;
    print(&imported)?;
    fs::write(&args.out, imported.to_toml())
        .with_context(|| format!("cannot write {}", args.out.display()))?;
    Ok(Outcome::Done)
}

fn write_random(args: &RandomArgs) -> Result<Outcome> {
    let imported = Imported::exact(random(args.seed, &load::car(&args.car)?)?);
    print(&imported)?;
    fs::write(&args.out, imported.to_toml())
        .with_context(|| format!("cannot write {}", args.out.display()))?;
    Ok(Outcome::Done)
}
