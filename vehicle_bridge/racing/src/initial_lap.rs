//! Whether the laps along the centre line, before learning, keep the body inside the track.
//!
//! On a road that begins to bend the centre of gravity moves out of line by l_f and l_r times the
//! curvature, at any speed: a car does not follow a narrow track by driving more slowly.

use controller::Config;
use vehicle_model::{CarParams, Discretized, Model, ModelKind, Outline, State, Track, Tracker};

/// Longest lap, in laps at the speed of initial laps.
const LONGEST: f64 = 10.0;

/// Why a race cannot begin with laps along the centre line.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error(
    "laps along the centre line take the body {overhang:.3} m beyond the edge at s = {s:.2} m, where \
     the track is {width:.3} m wide; expected a body inside the track: make it at least {needed:.3} m \
     wide there, or begin with laps that somebody drove (`lmpc learn`)"
)]
pub struct LeavesTrack {
    /// By how much the body reaches beyond the edge \[m\].
    overhang: f64,
    /// Where \[m\].
    s: f64,
    /// Distance from edge to edge there \[m\].
    width: f64,
    /// Least distance there with which it would not \[m\].
    needed: f64,
}

/// Drives a lap along the centre line as a controller does before it has learned, without noise.
///
/// # Errors
/// If the body leaves the track.
pub fn initial_lap(config: &Config, car: &CarParams, track: &Track) -> Result<(), LeavesTrack> {
    let (dt, substeps) = (config.horizon.period, config.horizon.substeps);
    let model = Model::new(ModelKind::Dynamic, car.clone());
    let model = Discretized { model, dt, substeps };
    let (tracker, outline) = (Tracker::new(car), Outline::new(car));
    let mut x = State { v_x: config.warm_up.speed, ..State::default() };
    let (mut overhang, mut s, mut driven) = (f64::NEG_INFINITY, 0.0, 0.0);
    let steps = (LONGEST * track.length() / (config.warm_up.speed * dt)).ceil() as u64;
    for _ in 0..steps {
        let found = outline.overhang(track, &x);
        if found > overhang {
            (overhang, s) = (found, x.s);
        }
        let next = model.next(&x, &tracker.track(&x, track, config.warm_up.speed), track.road());
        driven += next.s - x.s;
        x = State { s: track.wrap(next.s), ..next };
        if driven >= track.length() {
            break;
        }
    }
    if overhang <= 0.0 {
        return Ok(());
    }
    let width = track.width_left(s) + track.width_right(s);
    Err(LeavesTrack { overhang, s, width, needed: width + 2.0 * overhang })
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use controller::Preset;
    use vehicle_model::track::{ImportOptions, random};

    use super::*;
    use crate::{Race, RaceOptions};

    /// The L track at a scale, with this half width.
    fn l(scale: f64, half: f64) -> Track {
        let text = include_str!("../../../tracks/l.toml");
        let numbers = text.lines().map(|line| match line.split_once(" = ") {
            Some((key, _)) if key.starts_with("width") => format!("{key} = {half}"),
            Some((key, value)) if key.ends_with("_m") => {
                format!("{key} = {}", value.parse::<f64>().unwrap() * scale)
            }
            _ => line.to_owned(),
        });
        let text: Vec<String> = numbers.collect();
        Track::import("l.toml", &text.join("\n"), &ImportOptions::default()).unwrap().track
    }

    #[test]
    fn a_lane_too_narrow_for_the_way_of_the_car_is_refused_as_the_race_would_fail() {
        let mut ends = [0, 0];
        for (name, scale) in [("barc", 1.0), ("mini", 0.3), ("formula_student", 8.0)] {
            let car = CarParams::builtin(name).unwrap();
            for share in [1.55, 2.0, 4.0, 5.5] {
                let track = l(scale, 0.5 * share * car.width);
                let mut config = Config::derived(Preset::Race, &car, &track);
                (config.warm_up.noise_a, config.warm_up.noise_delta) = (0.0, 0.0);
                let found = initial_lap(&config, &car, &track);
                let track = Arc::new(track);
                let options =
                    RaceOptions { laps: 0, ..RaceOptions::new(config, car.clone(), track) };
                let Ok(mut race) = Race::new(options) else { continue };
                race.run(|_| ()).unwrap();
                assert_eq!(found.is_err(), race.failure.is_some(), "{name} {share}: {found:?}");
                ends[usize::from(found.is_err())] += 1;
            }
        }
        assert!(ends.iter().all(|count| *count > 1), "{ends:?}");
    }

    #[test]
    fn generated_tracks_are_wide_enough() {
        for name in CarParams::builtin_names() {
            let car = CarParams::builtin(name).unwrap();
            for seed in 0..20 {
                let track = random(seed, &car).unwrap();
                let config = Config::derived(Preset::Race, &car, &track);
                assert_eq!(initial_lap(&config, &car, &track), Ok(()), "{name} {seed}");
            }
        }
    }
}
