//! The structured solver's first input against Clarabel at 1e-10 on the problems of the
//! controller's own closed loops: tracks, cars, noise, low cost of the control rate. What the
//! structured solver does not solve to tolerance is handed over, so the difference counts that of
//! the solver as it is used.
//!
//! A small number of problems by default; `LMPC_QPS=2000` before `cargo test --release -p controller
//! --test closed_loop_agreement -- --nocapture` takes that many of each of the loops.
#![allow(clippy::unwrap_used, clippy::print_stdout)]

use std::sync::Arc;

use controller::fhocp::{Backend, ClarabelSolver, FhocpSolver, Solution, Termination};
use controller::{Action, Config, Controller, Measurement, Pose, Preset};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;
use vehicle_model::{CarParams, Discretized, Model, ModelKind, State, Track};

struct Loop {
    car: &'static str,
    track: &'static str,
    /// Factor on the cost of control rates.
    control_rate: f64,
    /// Standard deviation of position and heading; ten times that of velocities.
    noise: f64,
}

const LOOPS: [Loop; 6] = [
    Loop { car: "barc", track: "l", control_rate: 1.0, noise: 0.0 },
    Loop { car: "barc", track: "l", control_rate: 1.0, noise: 0.002 },
    Loop { car: "barc", track: "l", control_rate: 0.1, noise: 0.001 },
    Loop { car: "barc", track: "l", control_rate: 10.0, noise: 0.001 },
    Loop { car: "kart", track: "road_course", control_rate: 1.0, noise: 0.001 },
    Loop { car: "iac", track: "road_course", control_rate: 1.0, noise: 0.002 },
];

#[derive(Default)]
struct Tally {
    errors: Vec<f64>,
    handed_over: usize,
    unsolved: usize,
    unknown: usize,
}

/// Compares on `count` problems of a loop.
fn compare(case: &Loop, count: usize, tally: &mut Tally) {
    let car = CarParams { actuator_lag: 0.0, ..CarParams::builtin(case.car).unwrap() };
    let track = Arc::new(Track::builtin(case.track).unwrap());
    let mut config = Config::derived(Preset::Race, &car, &track);
    config.cost.control_rate *= case.control_rate;
    let dt = config.horizon.period;
    let plant =
        Discretized { model: Model::new(ModelKind::Dynamic, car.clone()), dt, substeps: 10 };
    let exact = Termination { tolerance: 1e-10, max_iterations: 200 };
    let (mut reference, mut ours) = (ClarabelSolver::reference(exact), config.solver.solver());
    let start = State { v_x: config.warm_up.speed, ..State::default() };
    let (mut x, mut k, mut compared) = (start, 0_u32, 0);
    let mut rng = Pcg64::seed_from_u64(7);
    let mut noise = |std: f64| -> f64 {
        let sample: f64 = StandardNormal.sample(&mut rng);
        std * sample
    };
    let mut controller = Controller::new(config, car, track.clone()).unwrap();
    while compared < count {
        let measured = State {
            v_x: x.v_x + noise(10.0 * case.noise),
            v_y: x.v_y + noise(10.0 * case.noise),
            omega_z: x.omega_z + noise(10.0 * case.noise),
            e_psi: x.e_psi + noise(case.noise),
            s: track.wrap(x.s + noise(case.noise)),
            e_y: x.e_y + noise(case.noise),
        };
        let measurement =
            Measurement { time: f64::from(k) * dt, pose: Pose::Frenet(measured), applied: None };
        let command = controller.step(&measurement);
        if command.status.solver.is_some() {
            compared += 1;
            let problem = controller.problem();
            let (horizon, hull) = (problem.horizon(), problem.hull.len());
            let (mut solution, mut optimum) =
                (Solution::new(horizon, hull), Solution::new(horizon, hull));
            let report = ours.solve(problem, &mut solution);
            let known = reference.solve(problem, &mut optimum).status.usable();
            tally.handed_over += usize::from(report.backend == Backend::Clarabel);
            match (report.status.usable(), known) {
                (true, true) => tally.errors.push((solution.u[0] - optimum.u[0]).amax()),
                (false, _) => tally.unsolved += 1,
                (true, false) => tally.unknown += 1,
            }
        }
        x = plant.next(&x, &command.input, |s| track.kappa(s));
        k += 1;
        // A car that left the track starts again.
        if command.status.action == Action::Braking || x.e_y.abs() > 50.0 {
            x = State { s: x.s, ..start };
        }
    }
}

#[test]
fn same_first_input_in_closed_loops() {
    let count = std::env::var("LMPC_QPS").ok().and_then(|n| n.parse().ok()).unwrap_or(60);
    let mut all = Tally::default();
    println!(
        "{:<34}{:>7}{:>10}{:>10}{:>10}  handed over, unsolved, no reference",
        "", "QPs", "median", "99.9 %", "max"
    );
    for case in &LOOPS {
        let mut tally = Tally::default();
        compare(case, count, &mut tally);
        let name =
            format!("{} {} rate {} noise {}", case.car, case.track, case.control_rate, case.noise);
        line(&name, count, &mut tally);
        all.errors.append(&mut tally.errors);
        all.handed_over += tally.handed_over;
        all.unsolved += tally.unsolved;
        all.unknown += tally.unknown;
    }
    let total = LOOPS.len() * count;
    let [median, tail, _] = line("all", total, &mut all);
    assert!(median <= 1e-6, "median {median}");
    assert!(tail <= 1e-3, "99.9 % {tail}");
    assert!(all.unsolved + all.unknown <= total / 100, "{} {}", all.unsolved, all.unknown);
}

fn line(name: &str, count: usize, tally: &mut Tally) -> [f64; 3] {
    tally.errors.sort_by(f64::total_cmp);
    let last = tally.errors.len() - 1;
    let quantiles @ [median, tail, most] =
        [0.5, 0.999, 1.0].map(|share| tally.errors[(last as f64 * share) as usize]);
    println!(
        "{name:<34}{count:>7}{median:>10.1e}{tail:>10.1e}{most:>10.1e}  {}, {}, {}",
        tally.handed_over, tally.unsolved, tally.unknown
    );
    quantiles
}
