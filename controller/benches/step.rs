//! One control step by phase, with few and with many laps stored: `cargo bench -p controller`.
//!
//! Growth is a ratio of medians within one run: absolute times of a busy machine mean little.

#![allow(clippy::expect_used, clippy::print_stdout)] // a program of its own

use std::sync::Arc;
use std::time::Instant;

use controller::{Action, Config, Controller, Measurement, Phase, Pose, Probe};
use vehicle_model::{CarParams, Discretized, Model, ModelKind, State, Track};

/// Rows of the table; the last ones are sums of phases.
const ROWS: [&str; 9] = [
    "project",
    "linearise",
    "regress",
    "safe set",
    "QP",
    "none of these",
    "prepare",
    "feedback",
    "whole step",
];
const PHASES: [Phase; 5] =
    [Phase::Project, Phase::Linearize, Phase::Regress, Phase::SafeSet, Phase::Solve];
/// Learned steps measured.
const STEPS: usize = 300;
const LAPS: [usize; 3] = [4, 100, 1000];

/// Times of the phases of one step, in microseconds.
#[derive(Default)]
struct Stopwatch {
    begun: Option<Instant>,
    phases: [f64; PHASES.len()],
}

impl Probe for Stopwatch {
    fn begin(&mut self, _: Phase) {
        self.begun = Some(Instant::now());
    }

    fn end(&mut self, phase: Phase) {
        if let (Some(begun), Some(i)) = (self.begun, PHASES.iter().position(|p| *p == phase)) {
            self.phases[i] += begun.elapsed().as_secs_f64() * 1e6;
        }
    }
}

struct Case {
    name: &'static str,
    car: &'static str,
    track: &'static str,
    config: Config,
}

fn cases() -> [Case; 4] {
    let barc = |name, steps, neighbors, laps| {
        let mut config = Config::default();
        config.horizon.steps = steps;
        config.safe_set.neighbors = neighbors;
        config.safe_set.laps = laps;
        // All stored laps are searched: the harder case.
        config.regression.laps = 0;
        Case { name, car: "barc", track: "l", config }
    };
    let mut iac = Config::from_toml(Config::of_car("iac").unwrap_or_default()).unwrap_or_default();
    iac.regression.laps = 0;
    let mut recent = barc("barc, 4 laps searched (default)", 10, 10, 4);
    recent.config.regression.laps = 4;
    [
        recent,
        barc("barc, all laps searched", 10, 10, 4),
        barc("barc, all laps searched", 20, 16, 4),
        Case { name: "iac, all laps searched", car: "iac", track: "road_course", config: iac },
    ]
}

/// Drives `laps` initial laps, then measures learned steps, one array a step.
fn measure(case: &Case, laps: usize) -> Vec<[f64; ROWS.len()]> {
    let mut config = case.config.clone();
    config.warm_up.laps = laps;
    let car = CarParams::builtin(case.car).expect("built-in car");
    let track = Arc::new(Track::builtin(case.track).expect("built-in track"));
    let dt = config.horizon.period;
    let lagless = CarParams { actuator_lag: 0.0, ..car };
    let plant =
        Discretized { model: Model::new(ModelKind::Dynamic, lagless.clone()), dt, substeps: 10 };
    let mut x = State { v_x: config.warm_up.speed, ..State::default() };
    let mut controller = Controller::new(config, lagless, track.clone()).expect("valid settings");
    let (mut steps, mut k, mut lap_end) = (Vec::new(), 0_u32, true);
    while steps.len() < STEPS {
        let pose = Pose::Frenet(State { s: track.wrap(x.s), ..x });
        let measurement = Measurement { time: f64::from(k) * dt, pose, applied: None };
        let mut before = Stopwatch::default();
        let begun = Instant::now();
        controller.prepare_probed(&mut before);
        let prepared = begun.elapsed().as_secs_f64() * 1e6;
        let mut after = Stopwatch::default();
        let begun = Instant::now();
        let command = controller.step_probed(&measurement, &mut after);
        let fed_back = begun.elapsed().as_secs_f64() * 1e6;
        // Learning at the end of a lap is no part of a step.
        if command.status.action == Action::Learned && !lap_end {
            let mut row = [0.0; ROWS.len()];
            for (sum, (a, b)) in row.iter_mut().zip(before.phases.iter().zip(after.phases)) {
                *sum = a + b;
            }
            let whole = prepared + fed_back;
            row[5] = whole - row[..PHASES.len()].iter().sum::<f64>();
            (row[6], row[7], row[8]) = (prepared, fed_back, whole);
            steps.push(row);
        }
        lap_end = command.status.finished.is_some();
        x = plant.next(&x, &command.input, |s| track.kappa(s));
        k += 1;
    }
    steps
}

fn quantile(steps: &[[f64; ROWS.len()]], row: usize, share: f64) -> f64 {
    let mut times: Vec<f64> = steps.iter().map(|step| step[row]).collect();
    times.sort_unstable_by(f64::total_cmp);
    times[((times.len() - 1) as f64 * share) as usize]
}

fn main() {
    println!("control step by phase, {STEPS} steps in us; growth of medians from {LAPS:?} laps");
    for case in cases() {
        let n = case.config.horizon.steps;
        let points = case.config.safe_set.neighbors * case.config.safe_set.laps;
        println!("\n{} (N {n}, {points} points)", case.name);
        let [head_4, head_100, head_1000] = LAPS.map(|laps| format!("{laps} laps, p99"));
        println!("{:<16}{head_4:>20}{head_100:>20}{head_1000:>20}{:>9}", "", "growth");
        let runs = LAPS.map(|laps| measure(&case, laps));
        for (row, name) in ROWS.iter().enumerate() {
            let [few, many, most] = [0, 1, 2].map(|i| quantile(&runs[i], row, 0.5));
            let [a, b, c] = [0, 1, 2].map(|i| quantile(&runs[i], row, 0.99));
            println!(
                "  {name:<14}{few:>11.1}{a:>9.1}{many:>11.1}{b:>9.1}{most:>11.1}{c:>9.1}{:>8.2}x",
                most / few
            );
        }
        let share = quantile(&runs[0], 7, 0.5) / quantile(&runs[0], 8, 0.5);
        println!("  feedback part {share:.2} of the whole step");
    }
}
