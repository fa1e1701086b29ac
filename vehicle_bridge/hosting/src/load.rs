//! Cars and tracks by the name of one that ships with the product, or from a file.

use std::path::Path;
use std::sync::Arc;

use anyhow::{Context as _, Result, bail};
use bounded_file::Limit;
use vehicle_model::track::{Change, ImportOptions};
use vehicle_model::{CarParams, Track};

/// The car of this name or file.
///
/// # Errors
/// If there is neither, or the file is wrong.
pub fn car(name: &str) -> Result<CarParams> {
    if CarParams::builtin_names().contains(&name) {
        return Ok(CarParams::builtin(name)?);
    }
    let text = text_of("car", name, &CarParams::builtin_names())?;
    CarParams::from_toml(&text).with_context(|| hint(name))
}

/// The track of this name or file.
///
/// # Errors
/// If there is neither, or the file is wrong.
pub fn track(name: &str) -> Result<Arc<Track>> {
    Ok(track_and_changes(name)?.0)
}

/// [`track`], with what its import changed of the file.
///
/// # Errors
/// If there is neither, or the file is wrong.
pub fn track_and_changes(name: &str) -> Result<(Arc<Track>, Vec<Change>)> {
    if let Some(track) = Track::builtin(name) {
        return Ok((Arc::new(track), Vec::new()));
    }
    let text = track_text(name)?;
    let imported = match Track::import(name, &text, &ImportOptions::default()) {
        Ok(imported) => imported,
        Err(problems) => {
            let first = problems.into_iter().next().map(|problem| problem.to_string());
            bail!("{}: {}", hint(name), first.unwrap_or_default())
        }
    };
    Ok((Arc::new(imported.track), imported.changes))
}

/// Text of a track file.
///
/// # Errors
/// If there is no such file, or it is no text.
pub fn track_text(name: &str) -> Result<String> {
    let names: Vec<&str> = Track::builtin_names().collect();
    text_of("track", name, &names)
}

fn text_of(what: &str, name: &str, builtin: &[&str]) -> Result<String> {
    let path = Path::new(name);
    if !path.exists() {
        bail!(
            "there is no {what} file `{name}`, and no {what} of that name ships with lmpc; \
             expected a file or one of {}",
            builtin.join(", ")
        );
    }
    Ok(bounded_file::text(path, Limit::SETTINGS)?)
}

fn hint(name: &str) -> String {
    format!("{name} (`lmpc check {name}` lists every problem)")
}
