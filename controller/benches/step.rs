//! One control step by phase, with few and with many laps stored: `cargo bench -p controller`.
//!
//! Growth is a ratio of medians within one run: absolute times of a busy machine mean little.

#![allow(clippy::expect_used, clippy::print_stdout)] // a program of its own

use std::sync::Arc;
use std::time::Instant;

use controller::{Action, Config, Controller, Measurement, Phase, Pose, Probe};
use vehicle_model::{CarParams, Discretized, Model, ModelKind, State, Track};

const PHASES: [(Phase, &str); 5] = [
    (Phase::Project, "project"),
    (Phase::Linearize, "linearise"),
    (Phase::Regress, "regress"),
    (Phase::SafeSet, "safe set"),
    (Phase::Solve, "QP"),
];
/// Learned steps measured.
const STEPS: usize = 300;
const LAPS: [usize; 2] = [4, 100];

/// Times of each phase, and of the whole step, in microseconds.
#[derive(Default)]
struct Stopwatch {
    begun: Option<Instant>,
    phases: [Vec<f64>; PHASES.len()],
}

impl Probe for Stopwatch {
    fn begin(&mut self, _: Phase) {
        self.begun = Some(Instant::now());
    }

    fn end(&mut self, phase: Phase) {
        let (Some(begun), Some(i)) = (self.begun, PHASES.iter().position(|p| p.0 == phase)) else {
            return;
        };
        self.phases[i].push(begun.elapsed().as_secs_f64() * 1e6);
    }
}

struct Case {
    car: &'static str,
    track: &'static str,
    config: Config,
}

fn cases() -> [Case; 2] {
    let mut barc = Config::default();
    barc.safe_set.neighbors = 16;
    let mut iac = Config::from_toml(Config::of_car("iac").unwrap_or_default()).unwrap_or_default();
    iac.safe_set.neighbors = 32;
    [
        Case { car: "barc", track: "l", config: barc },
        Case { car: "iac", track: "road_course", config: iac },
    ]
}

/// Drives `laps` initial laps, then measures learned steps; medians by phase and of the step.
fn measure(case: &Case, laps: usize) -> [f64; PHASES.len() + 1] {
    let mut config = case.config.clone();
    config.warm_up.laps = laps;
    // All stored laps are searched: the harder case.
    config.regression.laps = 0;
    let car = CarParams::builtin(case.car).expect("built-in car");
    let track = Arc::new(Track::builtin(case.track).expect("built-in track"));
    let dt = config.horizon.period;
    let lagless = CarParams { actuator_lag: 0.0, ..car };
    let plant =
        Discretized { model: Model::new(ModelKind::Dynamic, lagless.clone()), dt, substeps: 10 };
    let mut x = State { v_x: config.warm_up.speed, ..State::default() };
    let mut controller = Controller::new(config, lagless, track.clone()).expect("valid settings");
    let (mut watch, mut steps, mut k) = (Stopwatch::default(), Vec::new(), 0_u32);
    while steps.len() < STEPS {
        let pose = Pose::Frenet(State { s: track.wrap(x.s), ..x });
        let measurement = Measurement { time: f64::from(k) * dt, pose, applied: None };
        let begun = Instant::now();
        let command = controller.step_probed(&measurement, &mut watch);
        let time = begun.elapsed().as_secs_f64() * 1e6;
        if command.status.action == Action::Learned {
            steps.push(time);
        }
        x = plant.next(&x, &command.input, |s| track.kappa(s));
        k += 1;
    }
    let mut medians = [0.0; PHASES.len() + 1];
    for (median, times) in medians.iter_mut().zip(watch.phases) {
        let learned = times.len().saturating_sub(STEPS);
        *median = median_of(times[learned..].to_vec());
    }
    medians[PHASES.len()] = median_of(steps);
    medians
}

fn median_of(mut times: Vec<f64>) -> f64 {
    times.sort_unstable_by(f64::total_cmp);
    times[times.len() / 2]
}

fn main() {
    println!("control step by phase, median of {STEPS} steps in us; growth from {LAPS:?} laps");
    println!("{:<28}{:>10}{:>10}{:>9}", "", "4 laps", "100 laps", "growth");
    for case in cases() {
        let n = case.config.horizon.steps;
        let points = case.config.safe_set.neighbors * case.config.safe_set.laps;
        let [few, many] = LAPS.map(|laps| measure(&case, laps));
        println!("{} (N {n}, {points} points)", case.car);
        let names = PHASES.iter().map(|p| p.1).chain(["whole step"]);
        for ((name, few), many) in names.zip(few).zip(many) {
            println!("  {name:<26}{few:>10.1}{many:>10.1}{:>8.2}x", many / few);
        }
    }
}
