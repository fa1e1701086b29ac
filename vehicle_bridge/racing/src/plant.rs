//! What the simulated car has that the controller does not know, as the command line says it.

use vehicle_model::{GripChange, PlantParams};

use hosting::settings::Usage;

/// Names that may be changed, for messages.
const NAMES: &str = "mu, mu_f, mu_r, mass, iz, b_f, c_f, b_r, c_r, drag, delay, lag, noise, disturb, mu_fall, fall_time";
/// When grip falls, unless `fall_time` says otherwise. \[s\]
const FALL_TIME: f64 = 60.0;
/// A time no race reaches. \[s\]
const NEVER: f64 = 1e9;

/// Sensor noise of velocities is this many times that of position and heading: they come from
/// differences of poses over a tenth of a second.
const VELOCITY_NOISE: f64 = 10.0;
/// Disturbance of the yaw rate for one of the velocities [rad/m].
const YAW_DISTURBANCE: f64 = 2.5;

/// Applies changes given as `name=value`, in their order.
///
/// # Errors
/// [`Usage`] for an unknown name, a change that undoes an earlier one, or a value that makes no car.
pub fn change_plant(plant: &mut PlantParams, changes: &[String]) -> Result<(), Usage> {
    for (i, change) in changes.iter().enumerate() {
        let usage = |why: String| Usage(format!("--plant {change}: {why}"));
        let (name, value) =
            change.split_once('=').ok_or_else(|| usage("expected NAME=VALUE".to_owned()))?;
        not_undone(&changes[..i], change)?;
        let value = value.trim();
        let number: f64 =
            value.parse().map_err(|_| usage(format!("found `{value}`, expected a number")))?;
        set(plant, name.trim(), number).map_err(usage)?;
    }
    // After the last change: a mass and an inertia are judged together.
    match plant.validate().first() {
        Some(problem) => Err(Usage(format!("--plant {}: {problem}", changes.join(",")))),
        None => Ok(()),
    }
}

/// Lays changes over others, which they undo.
///
/// # Errors
/// [`Usage`] if one of them undoes another of them.
pub fn overlay_changes(below: &mut Vec<String>, above: &[String]) -> Result<(), Usage> {
    for (i, change) in above.iter().enumerate() {
        not_undone(&above[..i], change)?;
        below.retain(|earlier| !undoes(change, earlier));
        below.push(change.clone());
    }
    Ok(())
}

/// Refuses a change that undoes an earlier one.
fn not_undone(earlier: &[String], change: &str) -> Result<(), Usage> {
    let Some(earlier) = earlier.iter().find(|earlier| undoes(change, earlier)) else {
        return Ok(());
    };
    let why = if name_of(earlier) == name_of(change) {
        "expected each name once"
    } else {
        "mu is that of both axles, expected it before that of one"
    };
    Err(Usage(format!("--plant {change}: found {earlier} before it; {why}")))
}

fn name_of(change: &str) -> &str {
    change.split_once('=').map_or(change, |(name, _)| name).trim()
}

/// Whether nothing of an earlier change is left after another.
fn undoes(change: &str, earlier: &str) -> bool {
    let (name, before) = (name_of(change), name_of(earlier));
    name == before || name == "mu" && ["mu_f", "mu_r"].contains(&before)
}

fn set(plant: &mut PlantParams, name: &str, value: f64) -> Result<(), String> {
    let car = &mut plant.car;
    match name {
        "mu" => {
            car.tyre_front.mu = value;
            car.tyre_rear.mu = value;
        }
        "mu_f" => car.tyre_front.mu = value,
        "mu_r" => car.tyre_rear.mu = value,
        "mass" => car.mass = value,
        "iz" => car.inertia_z = value,
        "b_f" => car.tyre_front.b = value,
        "c_f" => car.tyre_front.c = value,
        "b_r" => car.tyre_rear.b = value,
        "c_r" => car.tyre_rear.c = value,
        "drag" => car.linear_drag = value,
        "delay" => car.actuator_delay = value,
        "lag" => car.actuator_lag = value,
        "noise" => {
            let (pose, velocity) = (value, VELOCITY_NOISE * value);
            let noise = &mut plant.noise;
            (noise.e_psi, noise.s, noise.e_y) = (pose, pose, pose);
            (noise.v_x, noise.v_y, noise.omega_z) = (velocity, velocity, velocity);
        }
        "disturb" => plant.disturbance.process_std = [value, value, YAW_DISTURBANCE * value],
        "mu_fall" => {
            // After what changes the friction from the start on: the fall is relative to that.
            let factor = [value / car.tyre_front.mu, value / car.tyre_rear.mu];
            fall(plant).factor = factor;
        }
        "fall_time" => fall(plant).time_s = Some([value, NEVER]),
        _ => return Err(format!("found `{name}`, expected one of {NAMES}")),
    }
    Ok(())
}

/// The fall of grip in mid-race.
fn fall(plant: &mut PlantParams) -> &mut GripChange {
    let grip = &mut plant.disturbance.grip;
    if grip.is_empty() {
        let time_s = Some([FALL_TIME, NEVER]);
        grip.push(GripChange { factor: [1.0; 2], time_s, s_m: None });
    }
    &mut grip[0]
}

#[cfg(test)]
mod tests {
    use super::*;
    use vehicle_model::CarParams;

    fn changed(changes: &[&str]) -> Result<PlantParams, Usage> {
        let mut plant = PlantParams::new(CarParams::builtin("barc").unwrap());
        let changes: Vec<String> = changes.iter().map(ToString::to_string).collect();
        change_plant(&mut plant, &changes).map(|()| plant)
    }

    #[test]
    fn every_name_in_the_message_is_known() {
        for name in NAMES.split(", ") {
            let value = match name {
                "iz" => 0.05,
                "b_f" | "b_r" => 4.0,
                _ => 0.5,
            };
            let plant = changed(&[&format!("{name}={value}")]).unwrap();
            assert_ne!(plant, changed(&[]).unwrap(), "{name} changes nothing");
        }
    }

    #[test]
    fn a_change_that_undoes_an_earlier_one_is_refused_and_laid_over_it_takes_its_place() {
        for (changes, reason) in [
            (
                ["noise=0.001", "noise=0.002"],
                "found noise=0.001 before it; expected each name once",
            ),
            (["mass=3", " mass = 3"], "expected each name once"),
            (["mu_f=0.6", "mu=0.7"], "found mu_f=0.6 before it; mu is that of both axles"),
        ] {
            let text = changed(&changes).unwrap_err().to_string();
            assert!(text.contains(reason) && text.contains(changes[1]), "{text}");
            let mut laid = vec![changes[0].to_owned()];
            overlay_changes(&mut laid, &[changes[1].to_owned()]).unwrap();
            assert_eq!(laid, [changes[1]]);
        }
        assert!(changed(&["mass=22", "iz=0.27"]).is_ok() && changed(&["iz=2.7"]).is_err());
        let both = changed(&["mu=0.7", "mu_f=0.6"]).unwrap().car;
        assert_eq!((both.tyre_front.mu, both.tyre_rear.mu), (0.6, 0.7));
    }

    #[test]
    fn what_makes_no_car_is_refused_with_the_reason() {
        for (change, reason) in [
            ("mu=-1", "tyre_front.mu"),
            ("mass=0", "mass_kg"),
            ("mass=1e5", "inertia_z_kgm2"),
            ("mu", "NAME=VALUE"),
            ("mu=fast", "`fast`"),
            ("grip=1", "`grip`"),
            ("noise=-1", "noise"),
        ] {
            let text = changed(&[change]).unwrap_err().to_string();
            assert!(text.contains(reason), "{change}: {text}");
        }
    }
}
