//! The car learns to race: whole laps, from the first metre on.

#![allow(clippy::unwrap_used)]

use controller::{Action, Command, Config, LapKind, Preset, Reason};
use lmpc_tests::Drive;
use vehicle_model::{PlantParams, SensorNoise, State};

fn seeded(preset: Preset, seed: u64) -> Config {
    let mut config = Config::preset(preset);
    config.warm_up.seed = seed;
    config
}

/// The L track is 1.1 m wide.
const HALF_WIDTH: f64 = 0.55;

#[test]
fn race_preset_learns_to_race_within_ten_laps() {
    for seed in [11, 12] {
        let mut drive = Drive::new(seeded(Preset::Race, seed));
        let mut unusual = Vec::new();
        while drive.lap_times().len() < 12 {
            let status = drive.step().status;
            if status.reason != Reason::None {
                unusual.push((drive.steps, status.action, status.reason));
            }
            assert!(drive.steps < 2500, "seed {seed}: {:?}", drive.lap_times());
        }
        let times = drive.lap_times();
        assert!(unusual.is_empty(), "seed {seed}: {unusual:?}");
        assert!(drive.laps.iter().all(|lap| lap.valid), "seed {seed}: {:?}", drive.laps);
        assert!(drive.widest <= HALF_WIDTH, "seed {seed}: {} m from the centre", drive.widest);
        assert!(times[9] <= 4.05, "seed {seed}: lap 10 of {times:?}");
        let warm_up = drive.of_kind(LapKind::Warmup).map(|lap| lap.lap_time);
        let warm_up = warm_up.fold(f64::INFINITY, f64::min);
        assert!(times[0] < 0.9 * warm_up, "seed {seed}: {warm_up} s before {times:?}");
    }
}

#[test]
fn paper_preset_drives_faster_lap_after_lap() {
    let mut config = seeded(Preset::Paper, 3);
    config.cost.control_rate = 0.1;
    let mut drive = Drive::new(config);
    drive.until(LapKind::Learning, 10);
    let times = drive.lap_times();
    assert!(drive.widest <= HALF_WIDTH, "{} m from the centre", drive.widest);
    // Falling until the limit comes near, and never far up again.
    for pair in times[..5].windows(2) {
        assert!(pair[1] < pair[0], "{times:?}");
    }
    for pair in times[5..].windows(2) {
        assert!(pair[1] < 1.03 * pair[0], "{times:?}");
    }
    assert!(times[9] < 0.9 * times[0] && times[9] < 5.6, "{times:?}");
}

/// Commands of a run of three learning laps on noisy sensors, with a call between the steps.
fn commands(between: impl Fn(&mut Drive)) -> Vec<Command> {
    let plant = PlantParams {
        noise: SensorNoise::laboratory(),
        seed: 5,
        ..PlantParams::new(lmpc_tests::barc(0.9))
    };
    let mut drive = Drive::of(seeded(Preset::Race, 5), lmpc_tests::barc(1.2), plant);
    let mut commands = Vec::new();
    while drive.lap_times().len() < 3 {
        commands.push(drive.step());
        between(&mut drive);
        assert!(commands.len() < 1500, "{:?}", drive.lap_times());
    }
    commands
}

#[test]
fn two_runs_give_the_same_bits() {
    let bits = |commands: Vec<Command>| -> Vec<_> {
        commands.iter().map(|c| (c.input.a.to_bits(), c.input.delta.to_bits(), c.status)).collect()
    };
    let first = bits(commands(|_| ()));
    assert_eq!(first, bits(commands(|_| ())));
    // Preparing early is a matter of time, not of results; nor does it matter how often.
    let early = bits(commands(|drive| {
        drive.controller.prepare();
        drive.controller.prepare();
    }));
    assert_eq!(first, early);
}

#[test]
fn learned_data_drive_from_standstill() {
    let mut ratios: Vec<f64> = (0..9).map(pupil_over_teacher).collect();
    ratios.sort_by(f64::total_cmp);
    assert!(ratios[4] < 1.0, "{ratios:?}");
    assert!(ratios[8] < 1.06, "{ratios:?}");
}

/// The second lap of a controller that begins with what another learned in five, as a share of that
/// one's last.
fn pupil_over_teacher(seed: u64) -> f64 {
    let mut teacher = Drive::new(seeded(Preset::Race, seed));
    teacher.until(LapKind::Learning, 5);
    let saved = teacher.controller.save();

    let mut pupil = Drive::new(seeded(Preset::Race, 77));
    pupil.controller.load(&saved).unwrap();
    assert_eq!(pupil.controller.save(), saved, "what was loaded is what is saved");
    assert_eq!(pupil.controller.grip(), teacher.controller.grip());
    pupil.plant.reset(State::default());
    let first = pupil.step().status;
    assert_eq!((first.action, first.reason), (Action::Tracking, Reason::Standstill));
    pupil.until(LapKind::Learning, 3);
    assert_eq!(pupil.of_kind(LapKind::Warmup).count(), 0, "it need not learn from slow laps again");
    assert!(pupil.laps.iter().all(|lap| lap.valid), "{:?}", pupil.laps);
    assert!(pupil.widest <= HALF_WIDTH);
    pupil.lap_times()[1] / teacher.lap_times()[4]
}
