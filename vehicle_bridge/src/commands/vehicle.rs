//! Vehicle FMUs: for `lmpc race --vehicle` and `lmpc vehicle`.

use std::fs;
use std::path::Path;
use std::sync::Arc;

use anyhow::{Context as _, Result, bail};
use vehicle_model::State;

use super::Outcome;
use crate::cli::{ControllerArgs, FmuVehicleArgs, InspectVehicleArgs, RaceArgs};
use crate::console::result;
use hosting::settings::Usage;
use racing::{Race, RaceOptions};
use vehicle_host::fmu::map::Map;
use vehicle_host::fmu::{FmuOptions, FmuVehicle, propose};

/// The race of the options, with the vehicle the command line names.
pub(super) fn race(args: &RaceArgs, options: &RaceOptions) -> Result<Race> {
    let vehicle = &args.vehicle;
    if vehicle == "sim" {
        if args.fmu.map.is_some() || args.fmu.preload.is_some() {
            bail!(Usage("--map and --preload belong to --vehicle fmu:FILE".to_owned()));
        }
        return Ok(Race::new(options.clone())?);
    }
    let Some(file) = vehicle.strip_prefix("fmu:") else {
        bail!(Usage(format!("--vehicle {vehicle}: expected sim or fmu:FILE")));
    };
    let speed = options.config.warm_up.speed;
    let seed = options.seed;
    let car = fmu(Path::new(file), &args.fmu, &args.controller, options, seed, speed)?;
    Ok(Race::with_vehicle(options.clone(), Box::new(car))?)
}

/// A vehicle FMU on the line, as far as its map lets us put it there.
pub(super) fn fmu(
    file: &Path,
    args: &FmuVehicleArgs,
    controller: &ControllerArgs,
    options: &RaceOptions,
    seed: u64,
    speed: f64,
) -> Result<FmuVehicle> {
    if !controller.plant.is_empty() {
        let hint = "set its own variables in the map's [parameters]";
        bail!(Usage(format!("--plant changes the simulated car, not an FMU: {hint}")));
    }
    let map = match &args.map {
        Some(path) => {
            let text = fs::read_to_string(path)
                .with_context(|| format!("cannot read {}", path.display()))?;
            let shown = path.display();
            let map = Map::from_toml(&text);
            Some(
                map.with_context(|| format!("{shown} (`lmpc check {shown}` lists every problem)"))?,
            )
        }
        None => None,
    };
    Ok(FmuVehicle::new(FmuOptions {
        file: file.to_owned(),
        map,
        preload: args.preload.clone(),
        car: options.plant.car.clone(),
        car_name: controller.car.clone(),
        track: Arc::clone(&options.track),
        track_name: controller.track.clone(),
        seed,
        start: State { v_x: speed, ..State::default() },
    })?)
}

/// Prints a proposed map.
pub(super) fn inspect(args: &InspectVehicleArgs) -> Result<Outcome> {
    let inspection = fmu_core::inspect(&args.file)?;
    result(propose(&inspection, &args.file.display().to_string()).trim_end())?;
    Ok(Outcome::Done)
}
