//! From a car, a track and settings to a race: the same for the command line, the studies and the
//! Python package.

use std::sync::Arc;

use controller::Config;
use hosting::settings::Usage;
use vehicle_model::{CarParams, PlantParams, Track};

use super::{RaceOptions, change_plant};

/// The small car drives with less grip than its controller assumes (the paper's mismatch).
pub const SMALL_CAR: &str = "barc";
const SMALL_CAR_NOMINAL_MU: f64 = 1.2;

/// The car a controller believes in: with the given grip, or by default with the paper's for the
/// small car and its own for any other. `name` is how the car was named, not what its file calls it.
///
/// # Errors
/// [`Usage`] if the grip is no number above 0.
pub fn nominal(name: &str, car: CarParams, mu: Option<f64>) -> Result<CarParams, Usage> {
    let default_mu = (name == SMALL_CAR).then_some(SMALL_CAR_NOMINAL_MU);
    match mu.or(default_mu) {
        Some(mu) if !(mu > 0.0 && mu.is_finite()) => {
            Err(Usage(format!("--nominal-mu {mu}: expected a number above 0")))
        }
        Some(mu) => Ok(car.with_mu(mu)),
        None => Ok(car),
    }
}

/// What a race is made of, beside the settings of its controller.
#[derive(Debug, Clone)]
pub struct Parts<'a> {
    /// How the car was named.
    pub name: &'a str,
    /// The true car.
    pub car: CarParams,
    /// The track.
    pub track: Arc<Track>,
    /// Changes of the simulated car, `NAME=VALUE` each.
    pub plant: &'a [String],
    /// Grip the controller believes in; `None` for the default of [`nominal`].
    pub nominal_mu: Option<f64>,
    /// Learning laps to drive.
    pub laps: u32,
}

impl Parts<'_> {
    /// The race with seed 0; `config` makes the settings for the car that the controller believes in.
    ///
    /// # Errors
    /// [`Usage`] for a change or a grip that makes no car, and those of `config`.
    pub fn assemble<E: From<Usage>>(
        self,
        config: impl FnOnce(&CarParams, &Track) -> Result<Config, E>,
    ) -> Result<RaceOptions, E> {
        let mut plant = PlantParams::new(self.car.clone());
        change_plant(&mut plant, self.plant)?;
        let nominal = nominal(self.name, self.car, self.nominal_mu)?;
        let config = config(&nominal, &self.track)?;
        Ok(RaceOptions { laps: self.laps, plant, ..RaceOptions::new(config, nominal, self.track) })
    }
}

impl RaceOptions {
    /// This race with another seed, of the warm-up laps and of the simulated car.
    #[must_use]
    pub fn with_seed(mut self, seed: u64) -> Self {
        self.seed = seed;
        self.config.warm_up.seed = seed;
        self
    }
}
