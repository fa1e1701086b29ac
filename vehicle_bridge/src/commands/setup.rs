//! From the command line to a race.

use std::sync::Arc;

use anyhow::{Result, bail};
use vehicle_model::{CarParams, Track, TrackError};

use command_line::ControllerArgs;
use hosting::load;
use hosting::settings::Layers;
use racing::{Parts, RaceOptions};
use terminal::{SOFT, Talk, WARN, paint};

/// Most changes of a track that are listed before a race.
const MOST_CHANGES: usize = 5;

/// The race the options describe, with seed 0. Says what the import changed of a track file, and
/// which bend the car does not get round.
pub(super) fn race(args: &ControllerArgs, laps: u32, talk: Talk) -> Result<RaceOptions> {
    let car = load::car(&args.car)?;
    let (track, changes) = load::track_and_changes(&args.track)?;
    for change in changes.iter().take(MOST_CHANGES) {
        talk.say(&paint(SOFT, &format!("{}: {change}", args.track)));
    }
    if changes.len() > MOST_CHANGES {
        let more = changes.len() - MOST_CHANGES;
        let see = format!("`lmpc track show {}` lists them", args.track);
        talk.say(&paint(SOFT, &format!("{}: {more} more changes; {see}", args.track)));
    }
    for problem in track.problems_for(&car) {
        if matches!(problem, TrackError::TooNarrow { .. }) {
            bail!("{} does not fit on {}: {problem}", args.car, args.track);
        }
        let text = format!("warning: {} on {}: {problem}", args.car, args.track);
        talk.say(&paint(WARN, &text));
    }
    assemble(args, car, track, laps)
}

/// That race with a car and a track that are loaded already; of both, `args` has the names.
pub(super) fn assemble(
    args: &ControllerArgs,
    car: CarParams,
    track: Arc<Track>,
    laps: u32,
) -> Result<RaceOptions> {
    let (name, plant) = (args.car.as_str(), args.plant.as_slice());
    let parts = Parts { name, car, track, plant, nominal_mu: args.nominal_mu, laps };
    parts.assemble(|car, track| layers(args)?.build_for(car, track))
}

/// What the options set of a configuration.
pub(super) fn layers(args: &ControllerArgs) -> Result<Layers> {
    let mut layers = Layers::default();
    if let Some(path) = &args.config {
        layers.file(path)?;
    }
    if let Some(preset) = args.preset {
        layers.preset(word(preset).as_str());
    }
    // An option of its own is one more assignment: a wrong value is the command line's fault.
    let own = [
        args.regression.map(|mode| format!("regression.mode={}", word(mode))),
        args.nominal.map(|model| format!("nominal.model={}", word(model))),
        args.bandwidth.map(|h| format!("regression.bandwidth={h:?}")),
        args.control_rate_cost.map(|cost| format!("cost.control_rate={cost:?}")),
        args.no_grip_adaptation.then(|| "nominal.adapt_grip=false".to_owned()),
    ];
    let all: Vec<String> = own.into_iter().flatten().chain(args.set.iter().cloned()).collect();
    layers.set_each(&all)?;
    Ok(layers)
}

/// A name as the command line has it, which is also the configuration's.
fn word(value: impl clap::ValueEnum) -> String {
    value.to_possible_value().map(|v| v.get_name().to_owned()).unwrap_or_default()
}
