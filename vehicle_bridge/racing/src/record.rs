//! What a race leaves behind: one row for each control step, one for each lap.

use std::fmt;

use controller::{Action, LapKind, LapResult, Status};
use hosting::rule::FailureReason;
use vehicle_model::{GlobalState, Input, State, Tyre};

/// One control step.
#[derive(Debug, Clone, Copy)]
pub struct StepRow {
    /// Time since the start \[s\].
    pub time: f64,
    /// The true state, in the track's frame.
    pub x: State,
    /// The true pose, in the global frame.
    pub pose: GlobalState,
    /// The commanded input.
    pub u: Input,
    /// The controller's status.
    pub status: Status,
    /// Front slip angle \[rad\].
    pub alpha_f: f64,
    /// Rear slip angle \[rad\].
    pub alpha_r: f64,
    /// Share of the front axle's largest lateral force in use, 0 to 1.
    pub use_f: f64,
    /// Share of the rear axle's largest lateral force in use, 0 to 1.
    pub use_r: f64,
    /// How far the body reaches beyond an edge; minus the distance to the nearer edge while it is
    /// inside \[m\].
    pub overhang: f64,
    /// Frobenius norm of the learned model's error in A; not a number where it was not asked for.
    pub model_error: ModelErrorNorms,
}

/// Share of an axle's largest lateral force that a slip angle \[rad\] asks for, 0 to 1.
#[must_use]
pub fn tyre_use(tyre: &Tyre, alpha: f64) -> f64 {
    (tyre.c * (tyre.b * alpha.abs()).atan()).sin()
}

/// Frobenius norms |A_learned - A_plant| of one step, over the points asked for.
#[derive(Debug, Clone, Copy)]
pub struct ModelErrorNorms {
    /// Their median.
    pub median: f64,
    /// Their mean.
    pub mean: f64,
}

impl ModelErrorNorms {
    /// Not asked for.
    pub const NONE: Self = Self { median: f64::NAN, mean: f64::NAN };

    /// Median and mean of some norms.
    #[must_use]
    pub fn of(mut norms: Vec<f64>) -> Self {
        Self { mean: mean(&norms), median: median(&mut norms) }
    }
}

/// One finished lap.
#[derive(Debug, Clone)]
pub struct LapRow {
    /// The controller's own account.
    pub result: LapResult,
    /// Number among the learning laps of this run, from 1; none for warm-up laps.
    pub iteration: Option<u32>,
    /// Greatest v_x [m/s].
    pub v_max: f64,
    /// Mean v_x [m/s].
    pub v_mean: f64,
    /// Greatest |e_y| \[m\].
    pub e_y_max: f64,
    /// Greatest overhang of the body beyond an edge; while it stays inside, minus its least
    /// distance to one \[m\].
    pub overhang_max: f64,
    /// Greatest front slip angle \[rad\].
    pub alpha_f_max: f64,
    /// Greatest rear slip angle \[rad\].
    pub alpha_r_max: f64,
    /// Control steps in the lap.
    pub steps: usize,
    /// Steps that neither warmed up nor applied the FHOCP's solution.
    pub fallbacks: usize,
    /// Steps whose input was cut to the car's limits.
    pub clipped: usize,
    /// Least and mean data support over the lap's learned steps.
    pub support_min: f64,
    /// Mean data support over the lap's learned steps.
    pub support_mean: f64,
    /// Median over the lap of the steps' median model errors.
    pub model_error_median: f64,
    /// Mean over the lap of the steps' mean model errors.
    pub model_error_mean: f64,
    /// Mean of the solver's iterations.
    pub iterations_mean: f64,
    /// Most iterations of one solve.
    pub iterations_max: u32,
    /// Front and rear factor on the nominal grip after the lap.
    pub grip: [f64; 2],
}

impl LapRow {
    /// Sums up the steps of a lap.
    #[must_use]
    pub fn new(
        result: LapResult,
        iteration: Option<u32>,
        grip: [f64; 2],
        steps: &[StepRow],
    ) -> Self {
        let all = |f: fn(&StepRow) -> f64| steps.iter().map(f).collect::<Vec<f64>>();
        let learned: Vec<&Status> =
            steps.iter().map(|r| &r.status).filter(|s| s.action == Action::Learned).collect();
        let iterations: Vec<f64> = learned.iter().map(|s| f64::from(s.iterations)).collect();
        let supports: Vec<f64> = learned.iter().map(|s| s.data_support_mean).collect();
        Self {
            result,
            iteration,
            v_max: most(&all(|r| r.x.v_x)),
            v_mean: mean(&all(|r| r.x.v_x)),
            e_y_max: most(&all(|r| r.x.e_y.abs())),
            overhang_max: most(&all(|r| r.overhang)),
            alpha_f_max: most(&all(|r| r.alpha_f.abs())),
            alpha_r_max: most(&all(|r| r.alpha_r.abs())),
            steps: steps.len(),
            fallbacks: steps.iter().filter(|r| is_fallback(&r.status)).count(),
            clipped: steps.iter().filter(|r| r.status.clipped).count(),
            support_min: learned.iter().map(|s| s.data_support_min).fold(f64::NAN, f64::min),
            support_mean: mean(&supports),
            model_error_median: median(&mut all(|r| r.model_error.median)),
            model_error_mean: mean(&finite(&all(|r| r.model_error.mean))),
            iterations_mean: mean(&iterations),
            iterations_max: learned.iter().map(|s| s.iterations).max().unwrap_or(0),
            grip,
        }
    }

    /// Whether the lap counts as a learned one.
    #[must_use]
    pub fn is_learning(&self) -> bool {
        self.result.kind == LapKind::Learning
    }
}

/// Whether the step fell back from learning.
#[must_use]
pub fn is_fallback(status: &Status) -> bool {
    !matches!(status.action, Action::WarmUp | Action::Learned)
}

/// Where and why a run failed.
#[derive(Debug, Clone, Copy)]
pub struct Failure {
    /// Why.
    pub reason: FailureReason,
    /// Learning lap in which it happened, from 1; 0 in a warm-up lap.
    pub iteration: u32,
    /// When \[s\].
    pub time: f64,
    /// The true state then.
    pub x: State,
    /// How far the car was beyond an edge; negative inside \[m\].
    pub beyond: f64,
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.reason {
            FailureReason::OffTrack => {
                write!(f, "the car left the track by {:.3} m", self.beyond)?;
            }
            FailureReason::Spin => write!(f, "the car spun")?,
            FailureReason::WrongWay => write!(f, "the car drove the wrong way")?,
            FailureReason::Standstill => write!(f, "the car stood still")?,
            FailureReason::NoLap => write!(f, "no lap was finished in the time allowed")?,
            FailureReason::NotFinite => write!(f, "the simulated car's state exploded")?,
        }
        match self.iteration {
            0 => write!(f, " in a warm-up lap")?,
            n => write!(f, " in learning lap {n}")?,
        }
        write!(
            f,
            " at s = {:.2} m, e_y = {:.3} m, v_x = {:.2} m/s, after {:.1} s",
            self.x.s, self.x.e_y, self.x.v_x, self.time
        )
    }
}

/// Mean; not a number of nothing.
#[must_use]
pub fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Median of the finite values; not a number of none.
#[must_use]
pub fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    let values: Vec<f64> = finite(values);
    match values.len() {
        0 => f64::NAN,
        n if n % 2 == 1 => values[n / 2],
        n => f64::midpoint(values[n / 2 - 1], values[n / 2]),
    }
}

fn finite(values: &[f64]) -> Vec<f64> {
    values.iter().copied().filter(|v| v.is_finite()).collect()
}

fn most(values: &[f64]) -> f64 {
    values.iter().copied().fold(f64::NAN, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn median_is_the_middle_of_what_is_finite() {
        assert!((median(&mut [3.0, f64::NAN, 1.0, 2.0]) - 2.0).abs() < 1e-15);
        assert!((median(&mut [4.0, 1.0]) - 2.5).abs() < 1e-15);
        assert!(median(&mut []).is_nan());
    }
}
