//! The car that a controller believes in, where nothing else is asked for.

use hosting::settings::Usage;
use vehicle_model::CarParams;

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
