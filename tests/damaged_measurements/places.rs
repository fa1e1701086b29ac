//! A car that is somewhere else all at once, or where no lap leads.

use controller::{Action, Command, LapKind, Reason};
use lmpc_tests::{Drive, l_track};
use vehicle_model::State;

use super::{goes_on_learning, racing, racing_with, step_changed};

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
