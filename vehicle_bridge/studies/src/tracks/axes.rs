//! What the names on the command line stand for: cars, and tracks from files and folders.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::{Context as _, Result, bail};
use vehicle_model::track::random;
use vehicle_model::{CarParams, Track};

use hosting::load;

/// How the names of track files end.
const TRACK_FILES: [&str; 4] = ["csv", "toml", "ttl", "txt"];

/// A car or a track with the name it has in tables.
#[derive(Debug, Clone)]
pub struct Named<T> {
    /// Name in tables: that of the command line, or of a file without its ending; the whole path
    /// where two files would have one name.
    pub label: String,
    /// As on the command line.
    pub given: String,
    /// The thing itself.
    pub value: T,
}

/// A file of a folder that holds no track that can be driven.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Refused {
    /// The file.
    pub file: String,
    /// What is wrong with it.
    pub reason: String,
}

/// The tracks of the command line.
#[derive(Debug, Clone, Default)]
pub struct Tracks {
    /// Those that can be driven.
    pub tracks: Vec<Named<Arc<Track>>>,
    /// Files in folders that cannot.
    pub refused: Vec<Refused>,
}

/// The cars of these names and files.
///
/// # Errors
/// If one does not exist or is wrong.
pub fn cars(names: &[String]) -> Result<Vec<Named<CarParams>>> {
    let mut cars = Vec::new();
    for name in names {
        let builtin = CarParams::builtin_names().contains(&name.as_str());
        cars.push(named(name, builtin, load::car(name)?));
    }
    distinct(&mut cars);
    Ok(cars)
}

/// The tracks of these names, files and folders; of none, those that ship with the product.
///
/// # Errors
/// If a name or file does not exist or is wrong, or a folder has no track. A wrong file in a
/// folder is no error: it is listed.
pub fn tracks(names: &[String]) -> Result<Tracks> {
    let mut found = Tracks::default();
    for name in names {
        let path = Path::new(name);
        if Track::builtin(name).is_none() && path.is_dir() {
            folder(path, &mut found)?;
        } else {
            let track = load::track(name)?;
            found.tracks.push(named(name, Track::builtin(name).is_some(), track));
        }
    }
    distinct(&mut found.tracks);
    Ok(found)
}

/// Generated tracks at the scale of a car, with the seeds from `first` on.
///
/// # Errors
/// If no track can be drawn for the car.
pub fn generated(car: &CarParams, first: u64, count: u32) -> Result<Vec<Named<Arc<Track>>>> {
    (0..u64::from(count))
        .map(|i| {
            let seed = first.wrapping_add(i);
            let label = format!("random-{seed}");
            let track = random(seed, car)
                .with_context(|| format!("no random track with seed {seed} for {}", car.name))?;
            Ok(Named { given: label.clone(), label, value: Arc::new(track) })
        })
        .collect()
}

fn folder(path: &Path, found: &mut Tracks) -> Result<()> {
    let entries = fs::read_dir(path).with_context(|| format!("cannot read {}", path.display()))?;
    let mut files: Vec<PathBuf> = Vec::new();
    for entry in entries {
        let file = entry.with_context(|| format!("cannot read {}", path.display()))?.path();
        let ending = file.extension().and_then(|e| e.to_str()).map(str::to_lowercase);
        if file.is_file() && ending.is_some_and(|e| TRACK_FILES.contains(&e.as_str())) {
            files.push(file);
        }
    }
    // The order of a folder differs from computer to computer.
    files.sort();
    let before = found.tracks.len();
    for file in files {
        let name = file.display().to_string();
        match load::track(&name) {
            Ok(track) => found.tracks.push(named(&name, false, track)),
            Err(error) => {
                found.refused.push(Refused { file: name, reason: format!("{error:#}") });
            }
        }
    }
    if found.tracks.len() == before {
        bail!(
            "{} holds no track that can be driven; expected files ending in {}",
            path.display(),
            TRACK_FILES.map(|e| format!(".{e}")).join(", ")
        );
    }
    Ok(())
}

fn named<T>(given: &str, builtin: bool, value: T) -> Named<T> {
    let stem = Path::new(given).file_stem().map(|s| s.to_string_lossy().into_owned());
    let label = stem.filter(|_| !builtin).unwrap_or_else(|| given.to_owned());
    Named { label, given: given.to_owned(), value }
}

/// Drops what was given twice, and tells files of one name apart by their paths.
fn distinct<T>(all: &mut Vec<Named<T>>) {
    let mut seen: Vec<String> = Vec::new();
    all.retain(|one| {
        let new = !seen.contains(&one.given);
        seen.push(one.given.clone());
        new
    });
    let labels: Vec<String> = all.iter().map(|one| one.label.clone()).collect();
    for one in all.iter_mut() {
        if labels.iter().filter(|label| **label == one.label).count() > 1 {
            one.label.clone_from(&one.given);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_is_its_track_files_in_order_and_the_wrong_ones_are_listed() {
        let folder = tempfile::tempdir().unwrap();
        let l = include_str!("../../../../tracks/l.toml");
        for (name, text) in [("b.toml", l), ("a.toml", l), ("c.csv", "no track"), ("d.png", "")] {
            fs::write(folder.path().join(name), text).unwrap();
        }
        let path = folder.path().display().to_string();
        let found = tracks(&[path.clone(), "l".to_owned(), "l".to_owned()]).unwrap();
        let labels: Vec<&str> = found.tracks.iter().map(|t| t.label.as_str()).collect();
        assert_eq!(labels, ["a", "b", "l"]);
        assert_eq!(found.refused.len(), 1);
        assert!(found.refused[0].file.ends_with("c.csv") && !found.refused[0].reason.is_empty());
        assert!(tracks(&[format!("{path}/none.csv")]).is_err());
    }

    #[test]
    fn files_of_one_name_are_told_apart() {
        let folder = tempfile::tempdir().unwrap();
        let l = include_str!("../../../../tracks/l.toml");
        let file = folder.path().join("l.toml");
        fs::write(&file, l).unwrap();
        let path = file.display().to_string();
        let found = tracks(&["l".to_owned(), path.clone()]).unwrap();
        let labels: Vec<&str> = found.tracks.iter().map(|t| t.label.as_str()).collect();
        assert_eq!(labels, ["l", path.as_str()]);
    }
}
