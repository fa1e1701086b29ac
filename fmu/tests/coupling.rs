//! Controller and vehicle FMU as hosts couple them, in both versions of FMI: one after the other, or both
//! at once with the values of the step before; with communication steps in single precision.
#![allow(clippy::unwrap_used, clippy::panic, clippy::print_stdout)]

mod slave;

use fmu_core::{ControllerFmu, VehicleFmu, Version};
use slave::{COMMAND, STATE, Slave, VERSIONS};

const PERIOD: f64 = 0.1;

/// Which values the car gets.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Order {
    /// The controller's new command.
    ControllerFirst,
    /// That of the step before, as the controller gets the state of the step before.
    Parallel,
}

/// A finished lap.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Lap {
    time: f64,
    valid: bool,
    /// Share of its steps that were initial ones.
    initial: f64,
}

/// The first laps, and the delay that was found, 0 for none.
fn race(version: Version, order: Order, step: f64, laps: usize) -> (Vec<Lap>, f64) {
    let controller = Slave::<ControllerFmu>::with(version, &[]);
    let vehicle = Slave::<VehicleFmu>::with(version, &[]);
    let (mut finished, mut initial, mut steps) = (Vec::new(), 0.0, 0.0);
    for k in 0..(150.0 / step) as usize {
        let time = k as f64 * step;
        let (state, old) = (vehicle.all(STATE), controller.all(COMMAND));
        controller.set_all(STATE, state);
        assert!(controller.step(time, step) <= 1, "at {time} s: {:?}", controller.log());
        let new = controller.all(COMMAND);
        vehicle.set_all(COMMAND, if order == Order::Parallel { old } else { new });
        assert_eq!(vehicle.step(time, step), 0, "at {time} s: {:?}", vehicle.log());
        steps += 1.0;
        initial += f64::from(u8::from(controller.get("status.action") == 0.0));
        if controller.get("lap.finished") as usize > finished.len() {
            let [time, valid] = controller.all(["lap.last_time", "lap.last_valid"]);
            finished.push(Lap { time, valid: valid == 1.0, initial: initial / steps });
            (initial, steps) = (0.0, 0.0);
        }
        if finished.len() == laps {
            break;
        }
    }
    // The table of docs/results.md; `--nocapture` shows it.
    let times: Vec<String> = finished.iter().map(|lap| format!("{:.3}", lap.time)).collect();
    println!("{version:?}, {order:?}, every {step} s: {}", times.join(", "));
    assert_eq!(finished.len(), laps, "{finished:?}");
    assert!(finished.iter().all(|lap| lap.valid), "{finished:?}");
    (finished, controller.get("response.delay"))
}

#[test]
fn controller_first_the_fifth_lap_is_learned_whatever_the_step() {
    let (laps, delay) = race(Version::Fmi2, Order::ControllerFirst, PERIOD, 7);
    assert!(laps[..4].iter().all(|lap| lap.initial == 1.0), "{laps:?}");
    // What the laps teach is in force after a few steps.
    assert!(laps[4].initial < 0.1 && laps[4].time < 0.65 * laps[3].time, "{laps:?}");
    assert!(laps[5].time < 8.0 && laps[6].time < 6.0, "{laps:?}");
    assert_eq!(delay, 0.0);
    assert_eq!(race(Version::Fmi3, Order::ControllerFirst, PERIOD, 7).0, laps);
    // Shorter steps of the car round otherwise.
    let (shorter, _) = race(Version::Fmi2, Order::ControllerFirst, 0.01, 7);
    for (lap, shorter) in laps.iter().zip(&shorter) {
        assert!((lap.time - shorter.time).abs() < 1e-3, "{lap:?} {shorter:?}");
    }
}

/// The command comes a communication step late, which the initial laps show. To weigh that delay takes
/// pieces of about as many periods as a fifth initial lap has; learning then begins with it.
#[test]
fn in_parallel_the_delay_of_the_exchange_is_found_and_learning_begins() {
    for version in VERSIONS {
        for step in [0.02, 0.05] {
            let (laps, delay) = race(version, Order::Parallel, step, 8);
            assert!((delay - step).abs() < 1e-3, "{delay} s found for {step} s");
            assert!(laps[..4].iter().all(|lap| lap.initial == 1.0), "{laps:?}");
            assert!(laps[5].initial < 0.3 && laps[5].time < 0.7 * laps[3].time, "{laps:?}");
            assert!(laps[6].time < 8.0 && laps[7].time < 6.5, "{laps:?}");
        }
    }
}

/// With the step that the documents advise, and half of it.
#[test]
fn in_parallel_with_a_tenth_of_the_period_it_learns_too() {
    for version in VERSIONS {
        let (laps, _) = race(version, Order::Parallel, 0.01, 8);
        assert!(laps[5].initial < 0.3 && laps[5].time < 0.7 * laps[3].time, "{laps:?}");
        assert!(laps[6].time < 8.0 && laps[7].time < 6.5, "{laps:?}");
        // So little is not worth an estimate.
        let (laps, delay) = race(version, Order::Parallel, 0.005, 7);
        assert_eq!(delay, 0.0);
        assert!(laps[4].initial < 0.1 && laps[5].time < 8.0 && laps[6].time < 6.0, "{laps:?}");
    }
}

/// `float32(0.1)` is a little more than the period, and so are the times that a host makes of it.
#[test]
fn a_step_in_single_precision_is_the_period() {
    let size = f64::from(0.1_f32);
    assert!(size > PERIOD);
    for version in VERSIONS {
        let controller = Slave::<ControllerFmu>::with(version, &[]);
        let vehicle = Slave::<VehicleFmu>::with(version, &[]);
        for k in 0..500 {
            // In single precision too, as a product; later in double, as a sum of such steps.
            let time = if k < 250 { f64::from(0.1_f32 * k as f32) } else { size * f64::from(k) };
            controller.set_all(STATE, vehicle.all(STATE));
            assert_eq!(controller.step(time, size), 0, "step {k}: {:?}", controller.log());
            assert_eq!(controller.get("status.steps"), f64::from(k + 1));
            vehicle.set_all(COMMAND, controller.all(COMMAND));
            assert_eq!(vehicle.step(time, size), 0, "step {k}: {:?}", vehicle.log());
        }
        // More is too long, less that does not divide the period is taken with one warning.
        let time = size * 500.0;
        assert_eq!(controller.step(time, 0.1001), 2);
        let warned = [0.0, 1.0, 2.0].map(|k| controller.step(time + k * 0.03, 0.03));
        assert_eq!(warned, [1, 0, 0]);
    }
}
