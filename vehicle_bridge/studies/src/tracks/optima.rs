//! Times of optimal laps from files.

use std::fs;
use std::path::Path;

use anyhow::{Context as _, Result, bail};
use bounded_file::Limit;
use serde::Deserialize;

/// Known times of optimal laps.
#[derive(Debug, Clone, Default)]
pub struct Optima {
    laps: Vec<Lap>,
}

/// One lap; files may have more columns and keys.
#[derive(Debug, Clone, PartialEq, Deserialize)]
struct Lap {
    car: String,
    track: String,
    #[serde(alias = "lap_time_s", alias = "time_s")]
    seconds: f64,
}

/// A TOML file of several laps.
#[derive(Debug, Deserialize)]
struct Laps {
    lap: Vec<Lap>,
}

impl Optima {
    /// Reads a file, or every CSV and TOML file of a folder. A CSV table has the columns `car`,
    /// `track` and `seconds`; a TOML file has those keys, or an array of tables `[[lap]]` of
    /// them. `lap_time_s` may stand for `seconds`.
    ///
    /// # Errors
    /// If a file cannot be read, or has no such table. In a folder, other files are passed over.
    pub fn load(path: &Path) -> Result<Self> {
        let mut laps = Vec::new();
        if path.is_dir() {
            let entries =
                fs::read_dir(path).with_context(|| format!("cannot read {}", path.display()))?;
            let mut files: Vec<_> = entries.filter_map(|e| Some(e.ok()?.path())).collect();
            files.sort();
            for file in files {
                laps.extend(read(&file).unwrap_or_default());
            }
        } else {
            laps = read(path)?;
        }
        if laps.is_empty() {
            bail!(
                "{} holds no optimal lap; expected CSV with the columns car,track,seconds or TOML \
                 with these keys",
                path.display()
            );
        }
        Ok(Self { laps })
    }

    /// The shortest lap known of a car on a track, by any of their names \[s\].
    #[must_use]
    pub fn find(&self, cars: [&str; 2], tracks: [&str; 2]) -> Option<f64> {
        let same =
            |lap: &&Lap| cars.contains(&lap.car.as_str()) && tracks.contains(&lap.track.as_str());
        self.laps.iter().filter(same).map(|lap| lap.seconds).min_by(f64::total_cmp)
    }
}

fn read(path: &Path) -> Result<Vec<Lap>> {
    let text = bounded_file::text(path, Limit::SETTINGS)?;
    let of_file = || format!("{}: expected car, track and seconds", path.display());
    let laps: Vec<Lap> = if path.extension().is_some_and(|e| e == "toml") {
        match toml::from_str::<Laps>(&text) {
            Ok(laps) => laps.lap,
            Err(_) => vec![toml::from_str(&text).with_context(of_file)?],
        }
    } else {
        let mut reader =
            csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(text.as_bytes());
        reader.deserialize().collect::<Result<_, _>>().with_context(of_file)?
    };
    if let Some(lap) = laps.iter().find(|lap| !(lap.seconds > 0.0 && lap.seconds.is_finite())) {
        bail!(
            "{}: {} s for {} on {}; expected a number above 0",
            path.display(),
            lap.seconds,
            lap.car,
            lap.track
        );
    }
    Ok(laps)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_and_single_laps_are_read() {
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str, text: &str| {
            let path = folder.path().join(name);
            fs::write(&path, text).unwrap();
            path
        };
        let table = write("a.csv", "car, track, seconds, note\niac, road_course, 72.95, x\n");
        let single = write(
            "optimum-1.toml",
            "car = \"barc\"\ntrack = \"l\"\nlap_time_s = 3.823\npoints = []",
        );
        write("b.toml", "[[lap]]\ncar = \"kart\"\ntrack = \"k\"\nseconds = 30\n");
        write("trajectory.csv", "s_m,v\n1,2\n");
        let all = Optima::load(folder.path()).unwrap();
        assert_eq!(all.find(["iac", "IAC"], ["road_course", ""]), Some(72.95));
        assert_eq!(all.find(["barc", ""], ["l.toml", "l"]), Some(3.823));
        assert_eq!(all.find(["kart", ""], ["k", ""]), Some(30.0));
        assert_eq!(all.find(["kart", ""], ["l", ""]), None);
        assert!(Optima::load(&table).is_ok() && Optima::load(&single).is_ok());
        let wrong = write("c.csv", "car,track,seconds\niac,l,0\n");
        assert!(Optima::load(&wrong).unwrap_err().to_string().contains("above 0"));
    }
}
