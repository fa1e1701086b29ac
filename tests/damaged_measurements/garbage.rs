//! Anything at all.

use controller::{Action, Pose, Reason};
use lmpc_tests::l_track;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use vehicle_model::{Input, State};

use super::{racing, state_of};

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
