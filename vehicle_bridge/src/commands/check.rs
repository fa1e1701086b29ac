//! `lmpc check`.

use std::path::Path;
use std::sync::Arc;

use anyhow::Result;
use bounded_file::Limit;
use serde::Serialize;
use serde_json::Value as Json;
use vehicle_model::{CarParams, Track};

use super::Outcome;
use super::config::{DIGITS, row};
use command_line::CheckArgs;
use file_check::{CheckedFile, FileKind, check_file};
use hosting::load;
use hosting::settings::{Layers, Setting, SettingOrigin};
use terminal::{BAD, GOOD, SOFT, paint, result};

/// Greatest width of a line of settings.
const WIDTH: usize = 96;

/// A checked file with the settings derived from it.
#[derive(Serialize)]
struct CheckReport {
    #[serde(flatten)]
    checked: CheckedFile,
    /// Every setting of the controller; empty for files that set none.
    settings: Vec<Json>,
    /// Those settings as text.
    #[serde(skip)]
    lines: Vec<String>,
}

/// Checks every file and prints what was found.
pub(super) fn run(args: &CheckArgs) -> Result<Outcome> {
    let reports: Vec<CheckReport> =
        args.files.iter().map(|file| report(file, args)).collect::<Result<_>>()?;
    let bad = reports.iter().any(|report| !report.checked.problems.is_empty());
    if args.json {
        terminal::json(&reports)?;
    } else {
        for CheckReport { checked: file, lines, .. } in &reports {
            let (name, kind) = (&file.file, file.kind);
            match file.problems.len() {
                0 => result(&format!("{name}: {kind}, {}", paint(GOOD, "no problems")))?,
                1 => result(&format!("{name}: {kind}, {}", paint(BAD, "1 problem")))?,
                n => result(&format!("{name}: {kind}, {}", paint(BAD, &format!("{n} problems"))))?,
            }
            for fact in file.facts.iter().chain(lines) {
                result(&paint(SOFT, &format!("  {fact}")))?;
            }
            for problem in &file.problems {
                result(&format!("  {problem}"))?;
            }
        }
    }
    Ok(if bad { Outcome::Problems } else { Outcome::Done })
}

fn report(path: &Path, args: &CheckArgs) -> Result<CheckReport> {
    let checked = check_file(path);
    let mut report = CheckReport { checked, settings: Vec::new(), lines: Vec::new() };
    if !report.checked.problems.is_empty() {
        return Ok(report);
    }
    let mut layers = Layers::default();
    let (name, car) = match (report.checked.kind, args.car.as_deref()) {
        (FileKind::Car, _) => {
            let text = bounded_file::text(path, Limit::SETTINGS)?;
            (path.display().to_string(), CarParams::from_toml(&text)?)
        }
        (FileKind::Configuration, name) => {
            layers.file(path)?;
            let name = name.unwrap_or(racing::SMALL_CAR);
            (name.to_owned(), racing::nominal(name, load::car(name)?, None)?)
        }
        _ => return Ok(report),
    };
    let track = match &args.track {
        Some(track) => load::track(track)?,
        None => fitting(&car)?,
    };
    let config = layers.build_for(&car, &track)?;
    let settings = layers.explain(&config);
    report.settings = settings.iter().map(row).collect();
    report.lines.push(format!("settings for {name} on {}:", track.name()));
    report.lines.extend(by_origin(&settings));
    Ok(report)
}

/// The first track that ships with lmpc on which the car fits, or the first of all.
fn fitting(car: &CarParams) -> Result<Arc<Track>> {
    let names: Vec<&str> = Track::builtin_names().collect();
    let fits =
        |name: &&&str| load::track(name).is_ok_and(|track| track.problems_for(car).is_empty());
    load::track(names.iter().find(fits).or(names.first()).copied().unwrap_or_default())
}

/// Settings with their values, in lines for each origin but the preset.
fn by_origin(settings: &[Setting<'_>]) -> Vec<String> {
    let mut groups: Vec<(String, Vec<String>)> = Vec::new();
    let mut preset = 0;
    for Setting { key, value, origin } in settings {
        if matches!(origin, SettingOrigin::Preset(_)) {
            preset += 1;
            continue;
        }
        let unit = if key.unit.is_empty() { String::new() } else { format!(" {}", key.unit) };
        let text = format!("{} {value:.DIGITS$}{unit}", key.dotted());
        let origin = origin.to_string();
        match groups.iter_mut().find(|(of, _)| *of == origin) {
            Some((_, texts)) => texts.push(text),
            None => groups.push((origin, vec![text])),
        }
    }
    let mut lines = Vec::new();
    for (origin, texts) in groups {
        let mut line = format!("  from {origin}:");
        for (i, text) in texts.iter().enumerate() {
            if line.len() + text.len() + 2 > WIDTH {
                lines.push(std::mem::replace(&mut line, "   ".to_owned()));
            }
            let end = if i + 1 == texts.len() { "" } else { "," };
            line += &format!(" {text}{end}");
        }
        lines.push(line);
    }
    lines.push(format!("  from the preset: {preset} more; `lmpc config` prints all"));
    lines
}
