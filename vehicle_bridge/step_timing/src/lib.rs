//! How long a control step takes on this machine: by phase, and the QP alone with each solver.
//!
//! A simulated car drives, so that the problems are those of a race. All ratios are of one run:
//! absolute times of a busy machine mean little. Steps in which the system took the processor away
//! (`ru_nivcsw`) are counted and left out.

mod circuit;
mod compare;
mod qp;
mod samples;
mod step;
mod table;

use controller::fhocp::Fhocp;
use controller::{Config, ConfigError, Preset};
use serde::Serialize;
use vehicle_model::{CarParams, Track};

pub use circuit::Circuit;
pub use compare::{Compared, compare, compared_text};
pub use qp::QpTimes;
pub use samples::Times;
pub use step::StepTimes;
pub use table::text;

/// Why there is nothing to measure.
#[derive(Debug, thiserror::Error)]
pub enum BenchError {
    /// A car or track that does not ship.
    #[error("no {0} of this name ships: '{1}'")]
    Missing(&'static str, String),
    /// A configuration that is refused.
    #[error(transparent)]
    Config(#[from] ConfigError),
}

/// One set-up of the controller.
#[derive(Debug, Clone)]
pub struct TimingCase {
    /// What sets it apart.
    pub name: &'static str,
    /// A shipped car.
    pub car: &'static str,
    /// A shipped track.
    pub track: &'static str,
    /// The configuration.
    pub config: Config,
    /// A lap has so many steps that a thousand learned ones take many minutes: all that are stored
    /// are initial ones.
    pub long: bool,
}

/// What is measured.
#[derive(Debug, Clone)]
pub struct TimingPlan {
    /// Learned steps, and QPs, of each measurement.
    pub steps: usize,
    /// Numbers of stored laps; ratios are to the first.
    pub laps: Vec<usize>,
    /// How many of the laps stored are initial ones, at most; the others were learned, as in a
    /// race. Initial laps alone are the worst case of the regression's search: the first learned
    /// laps are much faster than all there is.
    pub initial: usize,
}

/// Everything measured of one case.
#[derive(Debug, Clone, Serialize)]
pub struct CaseTimes {
    /// The case.
    pub name: &'static str,
    /// Its car.
    pub car: &'static str,
    /// Its track.
    pub track: &'static str,
    /// Horizon N.
    pub horizon: usize,
    /// Safe-set points.
    pub points: usize,
    /// Initial laps among those stored, at most.
    pub initial: usize,
    /// The step, for each number of laps stored.
    pub steps: Vec<StepTimes>,
    /// Feedback part after `prepare`, as a share of the whole step, at the fewest laps.
    pub feedback_share: f64,
    /// Whole step over one whose QP takes as long as tuned Clarabel's, at the fewest laps.
    pub step_to_clarabel: f64,
    /// Whole step at the most laps over that at the fewest.
    pub growth: f64,
    /// The QP alone, each solver on the same problems.
    pub qp: Vec<QpTimes>,
    /// Those problems.
    #[serde(skip)]
    pub problems: Vec<Fhocp>,
}

/// The shipped cases: the paper's size, a longer horizon and a full-size car, searching all laps
/// that are stored, and the first also as it ships.
///
/// # Errors
/// If the shipped configuration is refused.
pub fn cases() -> Result<[TimingCase; 4], ConfigError> {
    let barc = |name, steps, neighbors, searched| {
        let mut config = Config::default();
        config.horizon.steps = steps;
        config.safe_set.neighbors = neighbors;
        config.safe_set.laps = 4;
        config.regression.laps = searched;
        TimingCase { name, car: "barc", track: "l", config, long: false }
    };
    let (car, track) = (CarParams::builtin("iac"), Track::builtin("road_course"));
    let mut iac = match (&car, &track) {
        (Ok(car), Some(track)) => Config::derived(Preset::Race, car, track),
        _ => Config::default(),
    };
    // The largest problem that is measured: six seconds ahead, 96 points.
    iac.horizon.steps = 60;
    iac.safe_set.neighbors = 32;
    iac.regression.laps = 0;
    Ok([
        barc("barc, 4 laps searched", 10, 10, 4),
        barc("barc, all laps searched", 10, 10, 0),
        barc("barc, all laps searched", 20, 16, 0),
        TimingCase {
            name: "iac, all laps searched",
            car: "iac",
            track: "road_course",
            config: iac,
            long: true,
        },
    ])
}

/// Measures a case, saying what it does to `progress`.
///
/// # Errors
/// If car, track and configuration do not fit together.
pub fn measure(
    case: &TimingCase,
    plan: &TimingPlan,
    mut progress: impl FnMut(&str),
) -> Result<CaseTimes, BenchError> {
    let most = plan.laps.iter().copied().max().unwrap_or(0);
    let initial = if case.long { most } else { plan.initial.min(most) };
    let mut drives = Vec::new();
    for laps in &plan.laps {
        progress(&format!("{}: {laps} laps to store", case.name));
        let mut circuit = Circuit::new(case, initial.min(*laps))?;
        circuit.race(*laps);
        drives.push(step::Drive::new(circuit, *laps));
    }
    progress(&format!("{}: {} steps with each number of laps, in turns", case.name, plan.steps));
    // The problems of the fewest laps are the solvers'.
    let mut problems = Vec::new();
    let steps = step::measure(&mut drives, plan.steps, &mut problems);
    progress(&format!("{}: {} QPs with each solver", case.name, problems.len()));
    let qp = qp::measure(case.config.solver.termination(), &problems);
    let median = |of: Option<&StepTimes>, name| of.map_or(f64::NAN, |step| step.median(name));
    let (few, most) = (steps.first(), steps.last());
    let whole = median(few, step::WHOLE);
    let tuned = qp.get(qp::TUNED).map_or(f64::NAN, |qp| qp.times.median_us);
    Ok(CaseTimes {
        name: case.name,
        car: case.car,
        track: case.track,
        horizon: case.config.horizon.steps,
        points: case.config.safe_set.neighbors * case.config.safe_set.laps,
        initial,
        feedback_share: median(few, step::FEEDBACK) / whole,
        step_to_clarabel: whole / (whole - median(few, step::QP) + tuned),
        growth: median(most, step::WHOLE) / whole,
        steps,
        qp,
        problems,
    })
}
