//! One run to be done: a car on a track with a plant and a seed.

use std::sync::Arc;

use vehicle_model::Track;

use super::row::TracksKey;
use crate::runs::fingerprint;
use racing::{ModelErrorAt, RaceOptions};

/// One run to be done. What it does depends on nothing else.
#[derive(Debug, Clone)]
pub struct TracksCase {
    /// Its key.
    pub key: TracksKey,
    /// Time of the optimal lap, where it is known \[s\].
    pub optimum: Option<f64>,
    /// Whether the track was generated for the car.
    pub generated: bool,
    /// The race.
    pub options: RaceOptions,
}

impl TracksCase {
    /// Every seed of a cell. `options` hold everything but the seed.
    #[must_use]
    pub fn of_cell(
        names: [&str; 3],
        mut options: RaceOptions,
        seeds: u32,
        optimum: Option<f64>,
        generated: bool,
    ) -> Vec<Self> {
        options.model_error = ModelErrorAt::Never;
        let settings = fingerprint(&options);
        let [car, track, plant] = names.map(str::to_owned);
        (0..u64::from(seeds))
            .map(|seed| {
                let options = options.clone().with_seed(seed);
                let (car, track, plant) = (car.clone(), track.clone(), plant.clone());
                let key = TracksKey { car, track, plant, seed, settings: settings.clone() };
                Self { key, optimum, generated, options }
            })
            .collect()
    }

    /// The track.
    #[must_use]
    pub fn track(&self) -> &Arc<Track> {
        &self.options.track
    }
}
