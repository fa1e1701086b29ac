//! Values that no sensor can mean.

use controller::{Action, Config, LapKind, Measurement, Reason};
use lmpc_tests::Drive;
use vehicle_model::{Input, State};

use super::{goes_on_learning, racing, step_changed};

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
