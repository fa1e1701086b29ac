//! Time-optimal laps kept between runs: one small file for each car, track and margin.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result};
use bounded_file::Limit;
use optimum::Optimum;
use serde::{Deserialize, Serialize};
use vehicle_model::{CarParams, Track, fingerprint};

/// Where laps of tracks that ship with the product are kept.
const DEFAULT: &str = "out/optimum";
/// Laps of the small car on the L track: with the margin of the presets, and with the one that follows
/// from the car and the track.
const SHIPPED: [&str; 2] =
    [include_str!("../data/optimum_barc_l.toml"), include_str!("../data/optimum_barc_l_race.toml")];

/// A known time-optimal lap.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Known {
    /// Name of the car.
    pub car: String,
    /// Name of the track.
    pub track: String,
    /// Distance kept from the edges.
    pub margin_m: f64,
    /// Fingerprint of car, track and margin, as 16 hexadecimal digits.
    pub fingerprint: String,
    /// Lap time.
    pub lap_time_s: f64,
    /// Largest scaled deviation of the simulated car over an interval.
    pub scaled_defect: f64,
    /// Points [s \[m\], time \[s\], v_x \[m/s\], e_y \[m\]] along the lap; the last one is the
    /// first one lap later.
    pub points: Vec<[f64; 4]>,
}

/// A folder of known laps.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct OptimumStore {
    folder: PathBuf,
}

impl OptimumStore {
    /// The given folder, by default that of the track's file, or `out/optimum` if the track ships
    /// with the product.
    #[must_use]
    pub fn of(track: &str, folder: Option<&Path>) -> Self {
        let beside = || match Path::new(track).parent() {
            Some(parent) if Track::builtin(track).is_none() => parent.to_owned(),
            _ => PathBuf::from(DEFAULT),
        };
        Self { folder: folder.map_or_else(beside, Path::to_owned) }
    }

    /// Keeps a lap and gives the path of its file.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn save(
        &self,
        car: &CarParams,
        track: &Track,
        margin: f64,
        lap: &Optimum,
    ) -> Result<PathBuf> {
        let known = Known::new(car, track, margin, lap);
        let path = self.path(&known.fingerprint);
        let failed = || format!("cannot write {}", path.display());
        fs::create_dir_all(&self.folder).with_context(failed)?;
        let next = path.with_extension("next");
        fs::write(&next, known.text()).with_context(failed)?;
        fs::rename(&next, &path).with_context(failed)?;
        Ok(path)
    }

    /// The lap of this car on this track with this margin \[m\], if one is kept or ships with the
    /// product. A file that cannot be read counts as none.
    #[must_use]
    pub fn find(&self, car: &CarParams, track: &Track, margin: f64) -> Option<Known> {
        let wanted = key(car, track, margin);
        let kept = bounded_file::text(&self.path(&wanted), Limit::SETTINGS).ok();
        let texts = kept.iter().map(String::as_str).chain(SHIPPED);
        texts
            .filter_map(|text| toml::from_str::<Known>(text).ok())
            .find(|known| known.fingerprint == wanted && known.points.len() > 1)
    }

    fn path(&self, key: &str) -> PathBuf {
        self.folder.join(format!("optimum-{key}.toml"))
    }
}

/// Fingerprint of a car on a track with a margin.
fn key(car: &CarParams, track: &Track, margin: f64) -> String {
    // + 0.0 makes the two zeros one.
    let words = [car.fingerprint(), track.fingerprint(), (margin + 0.0).to_bits()];
    format!("{:016x}", fingerprint(&words))
}

impl Known {
    /// What is kept of a lap.
    #[must_use]
    pub fn new(car: &CarParams, track: &Track, margin: f64, lap: &Optimum) -> Self {
        let point = |p: &optimum::LapPoint| [p.x.s, p.time, p.x.v_x, p.x.e_y];
        Self {
            car: car.name.clone(),
            track: track.name().to_owned(),
            margin_m: margin,
            fingerprint: key(car, track, margin),
            lap_time_s: lap.lap_time,
            scaled_defect: lap.quality.scaled_defect,
            points: lap.points.iter().map(point).collect(),
        }
    }

    /// The file's text: one point a line.
    fn text(&self) -> String {
        let mut out = format!(
            "# A time-optimal lap by `lmpc optimum`; points are [s_m, time_s, v_x_mps, e_y_m].\n\
             car = {:?}\ntrack = {:?}\nmargin_m = {:?}\nfingerprint = {:?}\nlap_time_s = {:?}\n\
             scaled_defect = {:?}\npoints = [\n",
            self.car,
            self.track,
            self.margin_m,
            self.fingerprint,
            self.lap_time_s,
            self.scaled_defect
        );
        for [s, time, v_x, e_y] in &self.points {
            out.push_str(&format!("  [{s:.6}, {time:.6}, {v_x:.6}, {e_y:.6}],\n"));
        }
        out.push_str("]\n");
        out
    }

    /// Time since the line when the car is at `s` \[s\].
    #[must_use]
    pub fn time_at(&self, s: f64) -> f64 {
        let i = self.points.partition_point(|p| p[0] <= s).clamp(1, self.points.len() - 1);
        let (before, after) = (&self.points[i - 1], &self.points[i]);
        let part = (s - before[0]) / (after[0] - before[0]);
        before[1] + part * (after[1] - before[1])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use optimum::{Options, solve};
    use std::sync::Arc;

    fn small_car_on_l() -> (CarParams, Track) {
        (CarParams::builtin("barc").unwrap(), Track::builtin("l").unwrap())
    }

    /// The lap that ships is the one the program finds today.
    #[test]
    fn the_shipped_lap_is_up_to_date_and_belongs_to_one_margin_only() {
        let (car, track) = small_car_on_l();
        let nowhere = OptimumStore { folder: PathBuf::from("there/is/no/such/folder") };
        let known = nowhere.find(&car, &track, 0.1).unwrap();
        let lap = solve(&car, &Arc::new(track.clone()), &Options::new(0.1)).unwrap();
        assert!((known.lap_time_s - lap.lap_time).abs() < 1e-3);
        assert!(known.points.windows(2).all(|p| p[0][0] < p[1][0] && p[0][1] < p[1][1]));
        assert_eq!(nowhere.find(&car, &track, 0.2), None);
        assert_eq!(nowhere.find(&car.with_mu(0.8), &track, 0.1), None);
    }

    #[test]
    fn a_kept_lap_is_found_again_with_the_time_at_every_place() {
        let car = CarParams::builtin("mini").unwrap();
        let (_, track) = small_car_on_l();
        let folder = tempfile::tempdir().unwrap();
        let store = OptimumStore::of("l", Some(folder.path()));
        assert_eq!(store.find(&car, &track, 0.1), None);
        let lap = solve(&car, &Arc::new(track.clone()), &Options::new(0.1)).unwrap();
        let path = store.save(&car, &track, 0.1, &lap).unwrap();
        let known = store.find(&car, &track, 0.1).unwrap();
        assert_eq!(known.lap_time_s.to_bits(), lap.lap_time.to_bits());
        for point in &lap.points {
            assert!((known.time_at(point.x.s) - point.time).abs() < 1e-5);
        }
        assert!(known.time_at(0.5 * track.length()) < lap.lap_time);
        fs::write(path, "damaged").unwrap();
        assert_eq!(store.find(&car, &track, 0.1), None);
    }
}
