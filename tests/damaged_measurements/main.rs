//! Damaged measurements while the car drives: each step says what it did and why, the laps they
//! touch are not learned from, and the controller goes on learning afterwards.

#![allow(clippy::unwrap_used)]

mod garbage;
mod places;
mod times;
mod values;

use controller::{Action, Command, Config, LapKind, Measurement, Pose};
use lmpc_tests::Drive;
use vehicle_model::State;

/// A car in its second learned lap, `steps` behind the line.
fn racing(steps: u32) -> Drive {
    racing_with(steps, true)
}

/// The same with or without leave to drive back to the line by itself.
fn racing_with(steps: u32, active: bool) -> Drive {
    let mut config = Config::default();
    config.recovery.active = active;
    let mut drive = Drive::new(config);
    drive.until(LapKind::Learning, 1);
    assert!(drive.laps.iter().all(|lap| lap.valid));
    for _ in 0..steps {
        assert_eq!(drive.step().status.action, Action::Learned);
    }
    drive
}

fn state_of(measurement: &Measurement) -> State {
    match measurement.pose {
        Pose::Frenet(state) => state,
        Pose::Global(_) => unreachable!("the drive measures in the track's frame"),
    }
}

/// One step on a changed state.
fn step_changed(drive: &mut Drive, change: impl Fn(&mut State)) -> Command {
    let mut measurement = drive.measure();
    let mut state = state_of(&measurement);
    change(&mut state);
    measurement.pose = Pose::Frenet(state);
    drive.step_on(&measurement)
}

/// The lap in progress ends invalid; the one after it is learned, valid and raced.
fn goes_on_learning(mut drive: Drive) {
    let learned = drive.of_kind(LapKind::Learning).count();
    drive.until(LapKind::Learning, learned + 2);
    if drive.of_kind(LapKind::Learning).last().is_some_and(|lap| !lap.valid) {
        // A slow way back may take the next lap too.
        drive.until(LapKind::Learning, learned + 3);
    }
    let laps: Vec<_> = drive.of_kind(LapKind::Learning).skip(learned).copied().collect();
    let last = laps[laps.len() - 1];
    assert!(!laps[0].valid, "a lap with a damaged measurement: {laps:?}");
    assert!(last.valid, "the lap after it: {laps:?}");
    assert!(last.lap_time < 7.0, "{laps:?}");
    let stored = drive.controller.laps();
    assert_eq!(stored[stored.len() - 1].result, last, "and it is kept");
    assert_eq!(drive.step().status.action, Action::Learned);
}
