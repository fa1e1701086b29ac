//! From parameters to a controller.

use bounded_file::Limit;
use controller::config::RegressionMode;
use controller::{Config, Controller, Preset};
use vehicle_model::{CarParams, Track};

use super::{ControllerFmu, Laps, slots};
use crate::checksum::fnv1a;
use crate::files;
use crate::model::Io;
use crate::schedule::TickSchedule;
use crate::status::CallError;
use crate::values::VariableValues;

pub(super) fn failed(e: impl std::fmt::Display) -> CallError {
    CallError::Failed(e.to_string())
}

/// The configuration: preset or file, then the numbers that were changed.
fn config(io: &Io<'_>, car: &CarParams, track: &Track) -> Result<Config, CallError> {
    let (slots, values) = (slots(), &*io.values);
    let mut config = match (values.text(slots.config), values.text(slots.preset)) {
        ("", "race") => Config::derived(Preset::Race, car, track),
        ("", "paper") => Config::preset(Preset::Paper),
        ("", other) => {
            return Err(CallError::Failed(format!("param.preset = '{other}'; known: race, paper")));
        }
        (file, _) => Config::from_toml_for(&files::read(io, "configuration", file)?, car, track)
            .map_err(|e| CallError::Failed(format!("configuration {file}: {e}")))?,
    };
    slots.settings.apply(values, &mut config);
    match values.integer(slots.regression_mode) {
        1 => config.regression.mode = RegressionMode::Error,
        2 => config.regression.mode = RegressionMode::Full,
        3 => config.regression.mode = RegressionMode::Nominal,
        _ => {}
    }
    Ok(config)
}

pub(super) fn build(io: &mut Io<'_>) -> Result<ControllerFmu, CallError> {
    let slots = slots();
    let mut car = files::car(io, io.values.text(slots.car))?;
    let mu = io.values.real(slots.nominal_mu);
    if mu > 0.0 {
        car = car.with_mu(mu);
    }
    let track = files::track(io, io.values.text(slots.track))?;
    let mut config = config(io, &car, &track)?;
    let identity = postcard::to_allocvec(&config).map_err(failed)?;
    let period = config.horizon.period;
    let schedule = TickSchedule::new(period).ok_or_else(|| failed(format!("period {period} s")))?;
    let (base, tuned) = (config.clone(), slots.settings.start(io.values, &config));
    slots.settings.tune(&tuned, &mut config);
    let mut controller = Box::new(Controller::new(config, car, track).map_err(failed)?);
    let path = io.values.text(slots.load);
    if !path.is_empty() {
        let named =
            |e: &dyn std::fmt::Display| failed(format!("param.learned_load = '{path}': {e}"));
        let bytes = bounded_file::bytes(path.as_ref(), Limit::RECORDING).map_err(|e| named(&e))?;
        controller.load(&bytes).map_err(|e| named(&e))?;
        io.log.event(format!("{} laps of learned data from {path}", controller.laps().len()));
    }
    let (identity, laps) = (fnv1a(&identity), Laps::default());
    let warned = false;
    Ok(ControllerFmu { controller, base, tuned, period, schedule, identity, laps, warned })
}

/// Writes the settings in force into the parameters.
pub(super) fn read_back(controller: &Controller, values: &mut VariableValues) {
    let (slots, config) = (slots(), controller.config());
    slots.settings.write(config, values);
    let mode = match config.regression.mode {
        RegressionMode::Error => 1,
        RegressionMode::Full => 2,
        RegressionMode::Nominal => 3,
    };
    values.set_integer(slots.regression_mode, mode);
    // Where the axles differ there is no one number, and 0 says so.
    let [front, rear] = [controller.car().tyre_front.mu, controller.car().tyre_rear.mu];
    if front.to_bits() == rear.to_bits() {
        values.set_real(slots.nominal_mu, front);
    }
}
