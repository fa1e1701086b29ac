//! Time that stands still, leaps or goes back.

use controller::{Action, LapKind, LapNumber, Measurement, Reason};
use lmpc_tests::l_track;

use super::{goes_on_learning, racing};

#[test]
fn time_that_stands_still_repeats_the_command() {
    let mut drive = racing(10);
    let good = drive.measure();
    let first = drive.controller.step(&good);
    for _ in 0..5 {
        let again = drive.controller.step(&good);
        assert_eq!(again.input, first.input);
        assert_eq!(again.status.reason, Reason::TimeNotAdvancing);
    }
    // No period passed: the lap is as good as any.
    drive.plant.apply(first.input, 0.1);
    drive.steps += 1;
    drive.until(LapKind::Learning, 3);
    assert!(drive.laps.iter().all(|lap| lap.valid), "{:?}", drive.laps);
}

#[test]
fn a_measurement_from_the_past() {
    let mut drive = racing(10);
    let late = drive.measure();
    let before = drive.step();
    let again = drive.controller.step(&Measurement { time: late.time - 0.3, ..late });
    assert_eq!((again.input, again.status.reason), (before.input, Reason::TimeNotAdvancing));
    let status = drive.step().status;
    assert_eq!((status.action, status.reason), (Action::Learned, Reason::None));
}

#[test]
fn a_clock_that_was_set_back() {
    let mut drive = racing(10);
    let offset = drive.time() - 0.5;
    let mut reasons = Vec::new();
    for _ in 0..4 {
        let good = drive.measure();
        let status = drive.step_on(&Measurement { time: good.time - offset, ..good }).status;
        reasons.push(status.reason);
    }
    let refused = Reason::TimeNotAdvancing;
    assert_eq!(reasons, [refused, refused, Reason::TimeGap, Reason::None]);
    let mut laps = Vec::new();
    while laps.len() < 2 {
        let good = drive.measure();
        let command = drive.step_on(&Measurement { time: good.time - offset, ..good });
        laps.extend(command.status.finished);
        assert!(drive.steps < 1500, "{laps:?}");
    }
    // The lap in which the clock was set has no time.
    assert!(laps.iter().all(|lap| lap.valid && lap.lap_time > 3.0 && lap.lap_time < 7.0));
    assert_eq!(laps[0].lap, LapNumber::new(7), "{laps:?}");
}

#[test]
fn a_time_gap() {
    let mut drive = racing(10);
    // One measurement is lost: the car drives on with its last command.
    let last = drive.step();
    drive.plant.apply(last.input, 0.1);
    drive.steps += 1;
    let status = drive.step().status;
    assert_eq!((status.action, status.reason), (Action::Learned, Reason::TimeGap));
    goes_on_learning(drive);
}

#[test]
fn a_lap_that_begins_in_a_time_gap_has_no_valid_time() {
    let mut drive = racing(10);
    let learned = drive.of_kind(LapKind::Learning).count();
    while l_track().length() - drive.plant.truth().s > 0.4 {
        drive.step();
    }
    for _ in 0..3 {
        let last = drive.controller.plan().u[0];
        drive.plant.apply(last, 0.1);
        drive.steps += 1;
    }
    assert!(drive.plant.truth().s < 3.0, "the line lies in the gap");
    let status = drive.step().status;
    assert_eq!(status.reason, Reason::TimeGap);
    assert!(status.finished.is_some_and(|lap| !lap.valid));
    drive.until(LapKind::Learning, learned + 3);
    let laps: Vec<_> = drive.of_kind(LapKind::Learning).skip(learned).map(|l| l.valid).collect();
    assert_eq!(laps, [false, false, true]);
}
