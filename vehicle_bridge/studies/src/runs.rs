//! The runs of a study: every cell with every seed.

use std::sync::Arc;

use anyhow::Result;
use controller::Config;
use vehicle_model::{CarParams, PlantParams, Track};

use super::definition::{Cell, Definition};
use super::ledger::{RunRow, StudyLap};
use hosting::rule::TrackLimit;
use racing::record::{LapRow, is_fallback};
use racing::words::kind_word;
use racing::{ModelErrorAt, Race, RaceError, RaceOptions, change_plant};

/// The iteration whose lap time the paper reports.
const REPORTED_ITERATION: u32 = 20;

/// One run to be done.
#[derive(Debug, Clone)]
pub struct StudyCase {
    /// Its cell.
    pub cell: Cell,
    /// Its seed.
    pub seed: u64,
    /// Fingerprint of its settings.
    pub settings: String,
    options: RaceOptions,
}

impl StudyCase {
    /// Every run of a study, in the order of its tables.
    ///
    /// # Errors
    /// If a setting is not allowed.
    pub fn of(study: &Definition, set: &[String], seeds: u32, laps: u32) -> Result<Vec<Self>> {
        let track = Arc::new(builtin_track()?);
        let car = CarParams::builtin("barc")?;
        let mut plant = PlantParams::new(car.clone());
        change_plant(&mut plant, &study.plant)?;
        let nominal = car.with_mu(study.nominal_mu);
        let mut cases = Vec::new();
        for (cell, config) in study.cells(set)? {
            let model_error =
                if study.model_error_along_plan { ModelErrorAt::Plan } else { ModelErrorAt::Now };
            let options = RaceOptions {
                plant: plant.clone(),
                laps,
                model_error,
                limit: TrackLimit::CentreOfGravity,
                ..RaceOptions::new(config, nominal.clone(), Arc::clone(&track))
            };
            let settings = fingerprint(&options);
            for seed in 0..u64::from(seeds) {
                let (cell, settings) = (cell.clone(), settings.clone());
                let options = options.clone().with_seed(seed);
                cases.push(Self { cell, seed, settings, options });
            }
        }
        Ok(cases)
    }

    /// Key of the run.
    #[must_use]
    pub fn key(&self) -> (String, String, String, String, u64, String) {
        self.row().key()
    }

    /// The row of this run before it has begun.
    fn row(&self) -> RunRow {
        RunRow {
            regression: self.cell.regression.clone(),
            nominal: self.cell.nominal.clone(),
            control_rate_cost: self.cell.control_rate_cost,
            bandwidth: self.cell.bandwidth,
            seed: self.seed,
            laps_completed: 0,
            itf: None,
            ilt20_s: None,
            best_lap_s: None,
            failure: String::new(),
            fallbacks: 0,
            settings: self.settings.clone(),
        }
    }
}

fn builtin_track() -> Result<Track> {
    Track::builtin("l").ok_or_else(|| anyhow::anyhow!("the L track does not ship with this build"))
}

/// FNV-1a over everything that is set but the seed, and the version.
pub(super) fn fingerprint(options: &RaceOptions) -> String {
    let mut config: Config = options.config.clone();
    config.warm_up.seed = 0;
    let text = format!(
        "{} {config:?} {:?} {:?} {:016x} {} {:?} {:?}",
        env!("CARGO_PKG_VERSION"),
        options.nominal,
        options.plant,
        options.track.fingerprint(),
        options.laps,
        options.model_error,
        options.limit
    );
    let hash = text.bytes().fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3)
    });
    format!("{hash:016x}")
}

/// Drives one run.
///
/// # Errors
/// If the settings do not fit together, or what computes the vehicle fails.
pub fn run_one(case: &StudyCase) -> Result<(RunRow, Vec<StudyLap>), RaceError> {
    let mut race = Race::new(case.options.clone())?;
    race.run(|_| {})?;
    let learned: Vec<&LapRow> = race.laps.iter().filter(|lap| lap.is_learning()).collect();
    let times = || learned.iter().map(|lap| lap.result.lap_time);
    let reported = learned.iter().find(|lap| lap.iteration == Some(REPORTED_ITERATION));
    let run = RunRow {
        laps_completed: learned.len() as u32,
        itf: race.failure.as_ref().map(|f| f.iteration),
        ilt20_s: reported.map(|lap| lap.result.lap_time),
        best_lap_s: times().min_by(f64::total_cmp),
        failure: race.failure.as_ref().map_or(String::new(), |f| f.reason.as_str().to_owned()),
        fallbacks: race.steps.iter().filter(|row| is_fallback(&row.status)).count() as u64,
        ..case.row()
    };
    // The lap of the failure shows what the model was like in it.
    let failed = race.failed_lap();
    let laps = race.laps.iter().chain(&failed).map(|lap| study_lap(case, lap)).collect();
    Ok((run, laps))
}

fn study_lap(case: &StudyCase, lap: &LapRow) -> StudyLap {
    let finite = |value: f64| value.is_finite().then_some(value);
    StudyLap {
        regression: case.cell.regression.clone(),
        nominal: case.cell.nominal.clone(),
        control_rate_cost: case.cell.control_rate_cost,
        bandwidth: case.cell.bandwidth,
        seed: case.seed,
        lap: lap.result.lap,
        kind: kind_word(lap.result.kind).to_owned(),
        iteration: lap.iteration,
        lap_time_s: finite(lap.result.lap_time),
        valid: lap.result.valid,
        v_max_mps: lap.v_max,
        e_y_max_m: lap.e_y_max,
        fallbacks: lap.fallbacks as u64,
        model_error_median: finite(lap.model_error_median),
        model_error_mean: finite(lap.model_error_mean),
        settings: case.settings.clone(),
    }
}
