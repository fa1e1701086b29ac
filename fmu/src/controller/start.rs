//! From parameters to a controller.

use std::sync::Arc;

use controller::config::RegressionMode;
use controller::{Config, Controller, Preset};
use vehicle_model::{CarParams, Track};

use super::{ControllerFmu, Laps, slots};
use crate::checksum::fnv1a;
use crate::files;
use crate::model::Io;
use crate::schedule::Schedule;
use crate::status::Fault;
use crate::values::Values;

pub(super) fn failed(e: impl std::fmt::Display) -> Fault {
    Fault::Failed(e.to_string())
}

/// The configuration: preset or file, then the fixed numbers that were changed.
///
/// Never inlined: reading a file takes much stack, which must be free again for what follows.
#[inline(never)]
fn config(io: &Io<'_>) -> Result<Config, Fault> {
    let (slots, values) = (slots(), &*io.values);
    let mut config = match (values.text(slots.config), values.text(slots.preset)) {
        ("", "race") => match Config::of_car(values.text(slots.car)) {
            Some(shipped) => Config::from_toml(shipped).map_err(failed)?,
            None => Config::preset(Preset::Race),
        },
        ("", "paper") => Config::preset(Preset::Paper),
        ("", other) => {
            return Err(Fault::Failed(format!("param.preset = '{other}'; known: race, paper")));
        }
        (file, _) => Config::from_toml(&files::read(io, "configuration", file)?)
            .map_err(|e| Fault::Failed(format!("configuration {file}: {e}")))?,
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

/// A controller on the heap; never inlined, so that its way there costs no stack afterwards.
#[inline(never)]
pub(super) fn boxed(
    config: Config,
    car: CarParams,
    track: Arc<Track>,
) -> Result<Box<Controller>, Fault> {
    Controller::new(config, car, track).map(Box::new).map_err(failed)
}

/// The car and the hash of it and the configuration.
#[inline(never)]
fn car(io: &Io<'_>, config: &Config) -> Result<(CarParams, u64), Fault> {
    let slots = slots();
    let mut car = files::car(io, io.values.text(slots.car))?;
    let mu = io.values.real(slots.nominal_mu);
    if mu > 0.0 {
        car = car.with_mu(mu);
    }
    let mut identity = postcard::to_allocvec(config).map_err(failed)?;
    identity.extend(car.fingerprint().to_le_bytes());
    Ok((car, fnv1a(&identity)))
}

pub(super) fn build(io: &mut Io<'_>) -> Result<ControllerFmu, Fault> {
    let slots = slots();
    let mut base = Box::new(config(io)?);
    let (car, identity) = car(io, &base)?;
    let track = files::track(io, io.values.text(slots.track))?;
    let period = base.horizon.period;
    let schedule = Schedule::new(period).ok_or_else(|| failed(format!("period {period} s")))?;
    slots.settings.apply_tunable(io.values, &mut base);
    let tuned = slots.settings.tuned_in(&base);
    let mut controller = boxed(Config::clone(&base), car, track)?;
    let path = io.values.text(slots.load);
    if !path.is_empty() {
        let named =
            |e: &dyn std::fmt::Display| failed(format!("param.learned_load = '{path}': {e}"));
        let bytes = std::fs::read(path).map_err(|e| named(&e))?;
        controller.load(&bytes).map_err(|e| named(&e))?;
        io.log.event(format!("{} laps of learned data from {path}", controller.laps().len()));
    }
    let (laps, warned) = (Laps::default(), false);
    Ok(ControllerFmu { controller, base, tuned, period, schedule, warned, identity, laps })
}

/// What is in force beside the settings: grip and regression.
pub(super) fn publish(controller: &Controller, values: &mut Values) {
    let slots = slots();
    let (front, rear) = (controller.car().tyre_front.mu, controller.car().tyre_rear.mu);
    // One number cannot stand for two: then it stays 0, the car's own.
    if front == rear {
        values.set_real(slots.nominal_mu, front);
    }
    let mode = match controller.config().regression.mode {
        RegressionMode::Error => 1,
        RegressionMode::Full => 2,
        RegressionMode::Nominal => 3,
    };
    values.set_integer(slots.regression_mode, mode);
}
