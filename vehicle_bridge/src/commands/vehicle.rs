//! Vehicle FMUs: for `lmpc race --vehicle` and `lmpc vehicle`.

use std::fs;
use std::path::Path;
use std::sync::Arc;

use anyhow::{Context as _, Result, bail};
use bounded_file::Limit;
use vehicle_model::{GRAVITY, State};

use super::Outcome;
use command_line::{ControllerArgs, FmuVehicleArgs, InspectVehicleArgs, RaceArgs, TryVehicleArgs};
use hosting::load;
use hosting::settings::Usage;
use racing::{Race, RaceOptions};
use terminal::result;
use vehicle_host::fmu::map::Map;
use vehicle_host::fmu::trial::trial;
use vehicle_host::fmu::{FmuOptions, FmuVehicle, correct, propose};

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
            let text = bounded_file::text(path, Limit::SETTINGS)?;
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

/// Drives a vehicle FMU in small steps and says what its map has wrong.
pub(super) fn try_out(args: &TryVehicleArgs) -> Result<Outcome> {
    let shown = args.map.display();
    let text = bounded_file::text(&args.map, Limit::SETTINGS)?;
    let map = Map::from_toml(&text)
        .with_context(|| format!("{shown} (`lmpc check {shown}` lists every problem)"))?;
    let (car, track) = (load::car(&args.car)?, load::track(&args.track)?);
    // Where neither rolling wheels nor full grip decide.
    let v_x = 0.6 * (GRAVITY * car.wheelbase()).sqrt();
    let mut vehicle = FmuVehicle::new(FmuOptions {
        file: args.file.clone(),
        map: Some(map),
        preload: args.preload.clone(),
        car: car.clone(),
        car_name: args.car.clone(),
        track,
        track_name: args.track.clone(),
        seed: 0,
        start: State { v_x, ..State::default() },
    })?;
    let found = trial(&mut vehicle, &car, 1e-3 * f64::from(args.period_ms))?;
    for finding in &found.findings {
        let word = match (finding.sure, finding.is_change()) {
            (true, false) => "ok",
            (true, true) => "change",
            (false, _) => "unsure",
        };
        let change = match (finding.is_change(), finding.offset) {
            (false, _) => String::new(),
            (true, 0.0) => format!("; times {:.6}", finding.factor),
            (true, offset) => format!("; times {:.6}, plus {offset:.6}", finding.factor),
        };
        let name = format!("{}.{}", finding.section, finding.quantity);
        result(&format!("{word:<7} {name:<14} {}{change}", finding.note))?;
    }
    let answers = [("throttle", found.throttle), ("steering", found.steering)];
    for (name, answer) in answers {
        let (delay, lag) = (1e3 * answer.delay, 1e3 * answer.lag);
        result(&format!("{name}: delay {delay:.0} ms, lag {lag:.0} ms"))?;
    }
    result(&format!("measurements change every {:.0} ms", 1e3 * found.period))?;
    let (corrected, missing) = correct(&text, &found.findings);
    if let Some(out) = &args.out {
        if !missing.is_empty() {
            bail!("{shown} has no line of its own for {}: change it by hand", missing.join(", "));
        }
        fs::write(out, corrected).with_context(|| format!("cannot write {}", out.display()))?;
        return Ok(Outcome::Done);
    }
    let right = found.findings.iter().all(|finding| !finding.is_change());
    Ok(if right { Outcome::Done } else { Outcome::Problems })
}
