//! Tracks and cars by name or file.

use std::io::{self, BufWriter, Write as _};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use bounded_file::Limit;
use controller::Learned;
use serde::{Deserialize, Serialize};
use vehicle_model::{CarParams, Track};

use crate::model::Io;
use crate::status::CallError;

/// The car the models start from where nothing else is said.
pub(crate) const CAR: &str = "barc";
/// The track the models start on where nothing else is said.
pub(crate) const TRACK: &str = "l";

/// The centre line a saved state belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct CentreLine {
    fingerprint: u64,
    /// Its length [m].
    length: f64,
}

impl CentreLine {
    pub(crate) fn of(track: &Track) -> Self {
        Self { fingerprint: track.fingerprint(), length: track.length() }
    }

    /// Refuses a state whose centre line is not that of `track`.
    pub(crate) fn require(&self, track: &Track) -> Result<(), CallError> {
        let here = Self::of(track);
        if self.fingerprint == here.fingerprint {
            return Ok(());
        }
        Err(CallError::Refused(format!(
            "the state is of another centre line, {} m long; that of this instance's track '{}' is \
             {} m long",
            self.length,
            track.name(),
            here.length
        )))
    }
}

/// Reads the text of a file: as named, or below the FMU's resources.
pub(crate) fn read(io: &Io<'_>, what: &str, name: &str) -> Result<String, CallError> {
    let mut tried = vec![PathBuf::from(name)];
    tried.extend(io.resources.map(|folder| folder.join(name)));
    let place = tried.iter().find(|path| path.is_file()).ok_or_else(|| {
        let places: Vec<String> = tried.iter().map(|p| p.display().to_string()).collect();
        CallError::Failed(format!("{what} '{name}': no such file; looked at {}", places.join(", ")))
    })?;
    bounded_file::text(place, Limit::SETTINGS)
        .map_err(|e| CallError::Failed(format!("{what}: {e}")))
}

/// A track that ships, or one from a file.
pub(crate) fn track(io: &Io<'_>, name: &str) -> Result<Arc<Track>, CallError> {
    if let Some(track) = Track::builtin(name) {
        return Ok(Arc::new(track));
    }
    if !looks_like_file(name) {
        let known: Vec<&str> = Track::builtin_names().collect();
        return Err(CallError::Failed(format!(
            "param.track = '{name}' is neither a file nor one of {}",
            known.join(", ")
        )));
    }
    let text = read(io, "track", name)?;
    let track = Track::parse(&file_name(name), &text);
    track.map(Arc::new).map_err(|e| CallError::Failed(format!("track {name}: {e}")))
}

/// A car that ships, or one from a file.
pub(crate) fn car(io: &Io<'_>, name: &str) -> Result<CarParams, CallError> {
    let failed = |e: vehicle_model::ModelError| CallError::Failed(format!("car {name}: {e}"));
    if looks_like_file(name) {
        return CarParams::from_toml(&read(io, "car", name)?).map_err(failed);
    }
    CarParams::builtin(name).map_err(failed)
}

/// Writes learned data; the file before stays as `.bak` (see [`atomic_file`]).
pub(crate) fn save(path: &str, learned: &Learned) -> io::Result<()> {
    atomic_file::replace(Path::new(path), |file| {
        let mut buffered = BufWriter::new(file);
        learned.write(|bytes| buffered.write_all(bytes))?;
        buffered.flush()
    })
}

/// A name has neither ending nor folder.
fn looks_like_file(name: &str) -> bool {
    name.contains(['.', '/', '\\'])
}

fn file_name(path: &str) -> String {
    Path::new(path).file_name().map_or_else(|| path.to_owned(), |n| n.to_string_lossy().into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_second_save_keeps_the_first() {
        use controller::{Config, Controller};
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("learned.lmpc");
        let track = Arc::new(Track::builtin("l").unwrap());
        let car = CarParams::builtin("barc").unwrap();
        let controller = Controller::new(Config::default(), car, track).unwrap();
        for _ in 0..2 {
            save(&path.display().to_string(), &controller.learned_data()).unwrap();
        }
        let saved = [path.clone(), atomic_file::backup(&path)].map(|p| std::fs::read(p).unwrap());
        assert_eq!(saved, [controller.save(), controller.save()]);
    }

    #[test]
    fn another_centre_line_is_named_with_both_lengths() {
        let [l, road] = ["l", "road_course"].map(|name| Track::builtin(name).unwrap());
        let saved = CentreLine::of(&l);
        saved.require(&l).unwrap();
        let text = saved.require(&road).unwrap_err().to_string();
        for length in [l.length(), road.length()] {
            assert!(text.contains(&format!("{length} m")), "{text}");
        }
    }
}
