//! `lmpc learn`: laps that somebody else drove become data to learn from.

use anyhow::{Result, bail};
use controller::Controller;
use driven_laps::{LapAccount, LeftOut, Recording, ResampledDrive};
use hosting::learned;
use serde_json::json;
use vehicle_model::Track;

use super::{Outcome, folders, setup};
use command_line::LearnArgs;
use terminal::{BAD, BEST, SOFT, Talk, paint, result};

/// A drive of which less than this share is inside the track is in another frame.
const LEAST_INSIDE: f64 = 0.5;

/// Learns from the drive in a file.
pub(super) fn run(args: &LearnArgs, talk: Talk) -> Result<Outcome> {
    let options = setup::race(&args.controller, 1, talk)?;
    let (config, car, track) = (options.config, options.nominal, options.track);
    folders::file(&args.out)?;
    folders::other_than(&args.file, &args.out)?;
    let recording = driven_laps::read(&args.file, &args.channel)?;
    let driven = driven_laps::drive(
        &recording,
        args.inputs.into(),
        !args.no_smooth,
        (&config, &car, &track),
    );
    refuse(args, &driven, &track)?;
    let mut controller = Controller::new(config, car, track)?;
    let closed = controller.adopt(&driven.steps);
    let taken = closed.iter().filter(|lap| lap.valid).count();
    if taken == 0 {
        for line in account(&driven) {
            talk.say(&line);
        }
        bail!(
            "{}: {}; expected at least one whole lap from line to line with the body inside the track",
            args.file.display(),
            match driven.laps.len() {
                0 => "no lap goes from line to line".to_owned(),
                n => format!("none of {n} laps can be used"),
            }
        );
    }
    learned::save(&args.out, &controller)?;
    if args.json {
        let summary = summary(args, &recording, &driven, controller.grip());
        terminal::json(&summary)?;
        return Ok(Outcome::Done);
    }
    result(&origin(&recording, &driven))?;
    for line in account(&driven) {
        result(&line)?;
    }
    let [front, rear] = controller.grip();
    result(&format!(
        "grip fitted to them: {front:.2} front, {rear:.2} rear, times the car file's"
    ))?;
    let best = best(&driven).map(|time| format!(", the best in {time:.3} s")).unwrap_or_default();
    let text = format!("{taken} of {} laps taken{best}: {}", closed.len(), args.out.display());
    result(&paint(BEST, &text))?;
    Ok(Outcome::Done)
}

/// Refuses a drive that cannot have been on this track.
fn refuse(args: &LearnArgs, driven: &ResampledDrive, track: &Track) -> Result<()> {
    let (file, name) = (args.file.display(), track.name());
    if driven.steps.is_empty() {
        bail!("{file}: no stretch of states without a gap that is long enough");
    }
    let inside = |step: &&controller::DrivenStep| {
        let x = &step.x;
        x.e_y < track.width_left(x.s) && -x.e_y < track.width_right(x.s)
    };
    let count = driven.steps.len() as f64;
    let share = driven.steps.iter().filter(inside).count() as f64 / count;
    if share < LEAST_INSIDE {
        bail!(
            "{file}: {:.0} % of the drive is outside track \"{name}\"; places of the recording and of \
             the track file must be in the same frame, in metres",
            100.0 * (1.0 - share)
        );
    }
    let backwards = driven.steps.iter().filter(|step| step.x.e_psi.abs() > 2.0).count() as f64;
    if backwards > 0.5 * count {
        bail!(
            "{file}: the car drives against the direction of track \"{name}\"; turn the order of the \
             points in the track file round"
        );
    }
    Ok(())
}

/// What the recording was and what became of it.
fn origin(recording: &Recording, driven: &ResampledDrive) -> String {
    let mut text = format!(
        "{} states every {:.0} ms in {} stretches; inputs {}",
        recording.states.len(),
        1e3 * driven.interval,
        driven.stretches,
        driven.inputs
    );
    let [place, heading, v_x, v_y, omega_z] = driven.noise;
    if driven.noise.iter().any(|noise| *noise > 0.0) {
        text += &format!(
            "; smoothed: noise {place:.3} m, {heading:.3} rad, {v_x:.3} and {v_y:.3} m/s, {omega_z:.3} rad/s"
        );
    }
    if driven.differentiated {
        text += "; velocities are derivatives of the places";
    }
    for (what, left) in [("", &recording.left_out), ("inputs of ", &recording.inputs_left_out)] {
        if left.count() > 0 {
            text += &format!("; left out {what}{} {left}", recording.rows);
        }
    }
    text
}

/// One line for each lap.
fn account(driven: &ResampledDrive) -> Vec<String> {
    let mut lines = Vec::new();
    for (i, lap) in driven.laps.iter().enumerate() {
        let text = format!("lap {:>3}  {:8.3} s", i + 1, lap.lap_time);
        lines.push(match reason(lap) {
            None => format!("{text}  {}", paint(SOFT, "taken")),
            Some(reason) => format!("{text}  {}", paint(BAD, &format!("refused: {reason}"))),
        });
    }
    lines
}

fn reason(lap: &LapAccount) -> Option<String> {
    if lap.overhang > 0.0 {
        return Some(format!(
            "the body left the track by {:.3} m at s = {:.2} m",
            lap.overhang, lap.s
        ));
    }
    lap.stopped.map(|s| format!("the car stood or turned round at s = {s:.2} m"))
}

fn best(driven: &ResampledDrive) -> Option<f64> {
    driven.laps.iter().filter(|lap| lap.fit()).map(|lap| lap.lap_time).min_by(f64::total_cmp)
}

/// Each reason with the first and the last row of its stretches.
fn left_out(left: &LeftOut) -> serde_json::Value {
    left.reasons().map(|(reason, rows)| json!({ "reason": reason, "rows": rows })).collect()
}

fn summary(
    args: &LearnArgs,
    recording: &Recording,
    driven: &ResampledDrive,
    grip: [f64; 2],
) -> serde_json::Value {
    let lap = |lap: &LapAccount| {
        json!({
            "lap_time_s": lap.lap_time,
            "taken": lap.fit(),
            "refused": reason(lap),
            "overhang_max_m": lap.overhang,
        })
    };
    json!({
        "states": recording.states.len(),
        "unusable": recording.left_out.count(),
        "left_out": left_out(&recording.left_out),
        "inputs_left_out": left_out(&recording.inputs_left_out),
        "interval_s": driven.interval,
        "stretches": driven.stretches,
        "inputs": driven.inputs,
        "noise": {
            "position_m": driven.noise[0],
            "psi_rad": driven.noise[1],
            "v_x_mps": driven.noise[2],
            "v_y_mps": driven.noise[3],
            "omega_z_radps": driven.noise[4],
        },
        "laps": driven.laps.iter().map(lap).collect::<Vec<_>>(),
        "best_lap_s": best(driven),
        "grip": grip,
        "out": args.out.display().to_string(),
    })
}
