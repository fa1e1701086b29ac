//! Damaged measurements while the car drives: each step says what it did and why, the laps they
//! touch are not learned from, and the controller goes on learning afterwards.

#![allow(clippy::unwrap_used)]

use controller::{Action, Command, Config, LapKind, Measurement, Pose, Reason};
use lmpc_tests::{Drive, l_track};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use vehicle_model::{Input, State};

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

#[test]
fn not_a_number() {
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let changes: [fn(&mut State, f64); 6] = [
            |x, bad| x.v_x = bad,
            |x, bad| x.v_y = bad,
            |x, bad| x.omega_z = bad,
            |x, bad| x.e_psi = bad,
            |x, bad| x.s = bad,
            |x, bad| x.e_y = bad,
        ];
        let mut drive = racing(10);
        for change in changes {
            let status = step_changed(&mut drive, |x| change(x, bad)).status;
            assert_eq!((status.action, status.reason), (Action::ShiftedPlan, Reason::NonFinite));
            assert!(status.state.is_finite());
            let status = drive.step().status;
            assert_eq!((status.action, status.reason), (Action::Learned, Reason::TimeGap));
        }
        goes_on_learning(drive);
    }
}

#[test]
fn not_a_number_in_time_or_applied_input() {
    let mut drive = racing(10);
    let good = drive.measure();
    let status = drive.step_on(&Measurement { time: f64::NAN, ..good }).status;
    assert_eq!((status.action, status.reason), (Action::ShiftedPlan, Reason::NonFinite));
    let good = drive.measure();
    let applied = Some(Input { a: f64::INFINITY, delta: 0.0 });
    let status = drive.step_on(&Measurement { applied, ..good }).status;
    assert_eq!((status.action, status.reason), (Action::ShiftedPlan, Reason::NonFinite));
    goes_on_learning(drive);
}

#[test]
fn measurements_that_stay_away() {
    let mut drive = racing(12);
    let mut actions = Vec::new();
    for _ in 0..25 {
        let command = step_changed(&mut drive, |x| x.s = f64::NAN);
        assert_eq!(command.status.reason, Reason::NonFinite);
        actions.push(command.status.action);
    }
    // The plan while it reaches, then the brakes.
    let n = drive.controller.config().horizon.steps;
    assert!(actions[..n - 1].iter().all(|a| *a == Action::ShiftedPlan), "{actions:?}");
    assert!(actions[n - 1..].iter().all(|a| *a == Action::Braking), "{actions:?}");
}

#[test]
fn not_a_number_in_the_initial_laps() {
    let mut drive = Drive::new(Config::default());
    let status = step_changed(&mut drive, |x| x.v_x = f64::NAN).status;
    assert_eq!((status.action, status.reason), (Action::Braking, Reason::NonFinite));
    for _ in 0..50 {
        assert_eq!(drive.step().status.action, Action::WarmUp);
    }
    step_changed(&mut drive, |x| x.e_y = f64::NAN);
    drive.until(LapKind::Learning, 1);
    let laps = drive.laps;
    assert!(!laps[0].valid && laps[1..].iter().all(|lap| lap.valid), "{laps:?}");
    // An initial lap that is not valid is driven again.
    assert_eq!(laps.len(), Config::default().warm_up.laps + 2);
}

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
    assert_eq!(laps[0].lap, 7, "{laps:?}");
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

#[test]
fn a_jump_of_five_metres_back_and_forth() {
    for count in [1, 2] {
        let mut drive = racing(10);
        for _ in 0..count {
            let status = step_changed(&mut drive, |x| x.s += 5.0).status;
            assert_eq!((status.action, status.reason), (Action::ShiftedPlan, Reason::Jump));
        }
        let status = drive.step().status;
        assert_eq!((status.action, status.reason), (Action::Learned, Reason::TimeGap));
        goes_on_learning(drive);
    }
}

#[test]
fn a_jump_that_stays_is_believed_at_the_third_step() {
    let mut drive = racing(10);
    let x = drive.plant.truth();
    // Somebody has carried the car; the clock goes on.
    let offset = drive.time();
    drive.plant.reset(State { s: x.s + 5.0, v_x: 1.5, ..State::default() });
    let mut reasons = Vec::new();
    for _ in 0..4 {
        let good = drive.measure();
        let status = drive.step_on(&good).status;
        reasons.push((status.action, status.reason));
        assert!(drive.time() > offset);
    }
    let refused = (Action::ShiftedPlan, Reason::Jump);
    let believed = [(Action::Learned, Reason::Jump), (Action::Learned, Reason::None)];
    assert_eq!(reasons, [refused, refused, believed[0], believed[1]]);
    goes_on_learning(drive);
}

#[test]
fn a_speed_no_car_can_have() {
    let mut drive = racing(10);
    let changes: [fn(&mut State); 4] =
        [|x| x.v_x = 80.0, |x| x.v_x = 1e300, |x| x.v_y = -30.0, |x| x.omega_z = 1e4];
    for change in changes {
        let status = step_changed(&mut drive, change).status;
        assert_eq!((status.action, status.reason), (Action::ShiftedPlan, Reason::Jump));
        let status = drive.step().status;
        assert_eq!((status.action, status.reason), (Action::Learned, Reason::TimeGap));
    }
    goes_on_learning(drive);
}

/// Puts the car somewhere and lets the controller believe it.
fn carried(drive: &mut Drive, to: State) -> Command {
    drive.plant.reset(to);
    (0..3).map(|_| drive.step()).last().unwrap()
}

#[test]
fn a_car_that_stands_still() {
    let mut drive = racing(10);
    let s = drive.plant.truth().s;
    let status = carried(&mut drive, State { s, ..State::default() }).status;
    assert_eq!((status.action, status.reason), (Action::Recovering, Reason::Standstill));
    assert!(drive.step().input.a > 0.0, "it starts again");
    drive.until_action(Action::Learned);
    drive.until(LapKind::Learning, 4);
    assert!(drive.laps.last().unwrap().valid);
}

#[test]
fn a_car_off_the_track() {
    // On the grass, within reach.
    let x = State { s: 1.0, e_y: 1.2, v_x: 1.0, ..State::default() };
    for active in [true, false] {
        let mut drive = racing_with(10, active);
        let command = carried(&mut drive, x);
        let action = if active { Action::Recovering } else { Action::Tracking };
        assert_eq!(command.status.action, action);
        assert_eq!(command.status.reason, Reason::OffTrack);
        drive.until_action(Action::Learned);
        goes_on_learning(drive);
    }
    // In the next field: hopeless without leave to drive back.
    let mut drive = racing_with(10, false);
    let command = carried(&mut drive, State { e_y: -6.0, ..x });
    assert_eq!(command.status.action, Action::Braking);
    assert_eq!(command.status.reason, Reason::OffTrack);
}

#[test]
fn a_car_that_points_backwards() {
    let mut drive = racing_with(10, false);
    let mut x = State { s: 4.0, e_psi: 3.0, v_x: 1.0, ..State::default() };
    let command = carried(&mut drive, x);
    assert_eq!(command.status.action, Action::Braking);
    assert_eq!(command.status.reason, Reason::WrongWay);
    assert!(command.input.a < 0.0);
    for _ in 0..30 {
        drive.step();
    }
    assert!(drive.plant.truth().v_x < 0.1, "it stands: {:?}", drive.plant.truth());
    // Turned round by hand it drives on. A full turn is no turn.
    x.e_psi = 0.0;
    carried(&mut drive, x);
    let status = step_changed(&mut drive, |x| x.e_psi += std::f64::consts::TAU).status;
    assert_eq!(status.reason, Reason::None);
    goes_on_learning(drive);
}

#[test]
fn backwards_over_the_line() {
    let mut drive = racing(0);
    let length = l_track().length();
    carried(&mut drive, State { s: 0.1, v_x: 1.0, ..State::default() });
    carried(&mut drive, State { s: length - 1.0, v_x: 1.0, ..State::default() });
    drive.until(LapKind::Learning, 5);
    let laps: Vec<_> = drive.of_kind(LapKind::Learning).collect();
    assert!(laps.last().unwrap().valid, "{laps:?}");
    assert!(laps.iter().filter(|lap| lap.valid).all(|lap| lap.lap_time > 3.8), "{laps:?}");
}

/// Something a broken sensor may say.
fn garbage(rng: &mut Pcg64Mcg, good: f64) -> f64 {
    match rng.random_range(0..12) {
        0 => f64::NAN,
        1 => f64::INFINITY,
        2 => 1e300 * rng.random_range(-1.0..1.0),
        3 => 1e-300,
        4 => 0.0,
        5 => -good,
        6 => 100.0 * rng.random_range(-1.0..1.0),
        7 => good * 1e6,
        8 => good + rng.random_range(-1.0..1.0),
        _ => good,
    }
}

#[test]
fn whatever_is_measured_the_command_is_allowed() {
    let mut drive = racing(5);
    let mut rng = Pcg64Mcg::seed_from_u64(8);
    let (mut driven, mut refused, mut hurried) = (0, 0, 0);
    for k in 0..20_000 {
        let mut measurement = drive.measure();
        // Some stretches are sane, so that all states of the controller meet the garbage.
        if rng.random_range(0..100) < if k % 400 < 200 { 80 } else { 4 } {
            let mut x = state_of(&measurement);
            for value in [
                &mut x.v_x,
                &mut x.v_y,
                &mut x.omega_z,
                &mut x.e_psi,
                &mut x.s,
                &mut x.e_y,
                &mut measurement.time,
            ] {
                if rng.random_range(0..3) == 0 {
                    *value = garbage(&mut rng, *value);
                }
            }
            measurement.pose = if rng.random_range(0..3) == 0 {
                Pose::Global(l_track().to_global(&x))
            } else {
                Pose::Frenet(x)
            };
            if rng.random_range(0..5) == 0 {
                let a = garbage(&mut rng, 1.0);
                measurement.applied = Some(Input { a, delta: garbage(&mut rng, 0.1) });
            }
        }
        // Finite and inside the limits: asserted in each step.
        let status = drive.step_on(&measurement).status;
        driven += u32::from(status.action == Action::Learned);
        refused += u32::from(matches!(status.reason, Reason::NonFinite | Reason::Jump));
        let x = drive.plant.truth();
        if !x.is_finite() || x.e_psi.abs() > 1.5 || x.v_x < 0.1 || x.e_y.abs() > 1.0 {
            hurried += 1;
            drive.plant.reset(State { s: x.s, v_x: 1.2, ..State::default() });
        }
    }
    assert!(driven > 1000 && refused > 1000, "{driven} driven, {refused} refused, {hurried}");
    assert!(
        drive.controller.laps().iter().all(|lap| lap.result.lap_time > 3.0 || !lap.result.valid)
    );
    // What it learned is spoiled, but not for good.
    let x = drive.plant.truth();
    drive.plant.reset(State { s: x.s, v_x: 1.2, ..State::default() });
    let before = drive.laps.len();
    while drive.laps.len() < before + 2 || !drive.laps[drive.laps.len() - 1].valid {
        drive.step();
        assert!(drive.laps.len() < before + 20, "{:?}", &drive.laps[before..]);
        assert!(drive.steps < 22_000, "{:?}", &drive.laps[before..]);
    }
}
