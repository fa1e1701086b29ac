//! `Status` and `LapResult`.

use controller::{LapResult as InnerLap, Status as Inner};
use numpy::PyArray1;
use pyo3::prelude::*;
use racing::words::{action_word, kind_word, reason_word, solve_word, solver_word};

use crate::arrays::from_state;

/// What a step did, why, and how far it can be trusted.
#[pyclass(frozen, module = "racing_lmpc")]
pub(crate) struct Status(pub(crate) Inner);

#[pymethods]
impl Status {
    /// ``warm_up``, ``learned``, ``shifted_plan``, ``tracking``, ``braking`` or
    /// ``recovering``.
    #[getter]
    fn action(&self) -> &'static str {
        action_word(self.0.action)
    }

    /// Why, if not the normal course; else empty.
    #[getter]
    fn reason(&self) -> &'static str {
        reason_word(self.0.reason)
    }

    /// How the solver ended: ``not_run``, ``solved``, ``almost_solved``, ...
    #[getter]
    fn solve(&self) -> &'static str {
        solve_word(self.0.solve)
    }

    /// ``structured`` or ``clarabel``; empty if no problem was solved.
    #[getter]
    fn solver(&self) -> &'static str {
        solver_word(self.0.solver)
    }

    /// Iterations of the solver.
    #[getter]
    fn iterations(&self) -> u32 {
        self.0.iterations
    }

    /// Number of the current lap, from 1.
    #[getter]
    fn lap(&self) -> u32 {
        self.0.lap.get()
    }

    /// State that the step used (6,).
    #[getter]
    fn state<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        from_state(py, &self.0.state)
    }

    /// Optimal cost of the FHOCP [steps].
    #[getter]
    fn cost(&self) -> f64 {
        self.0.cost
    }

    /// Part of it: cost-to-go of the terminal state, J' lambda [steps].
    #[getter]
    fn cost_to_go(&self) -> f64 {
        self.0.cost_to_go
    }

    /// Largest lane slack along the plan [m].
    #[getter]
    fn lane_slack(&self) -> f64 {
        self.0.lane_slack
    }

    /// Largest front slip-guard slack along the plan [rad].
    #[getter]
    fn front_slip_slack(&self) -> f64 {
        self.0.front_slip_slack
    }

    /// Largest rear slip-guard slack along the plan [rad].
    #[getter]
    fn rear_slip_slack(&self) -> f64 {
        self.0.rear_slip_slack
    }

    /// Largest speed-cap slack along the plan [m/s].
    #[getter]
    fn speed_slack(&self) -> f64 {
        self.0.speed_slack
    }

    /// Part of `cost`: penalty of the terminal slack [steps].
    #[getter]
    fn terminal_slack_cost(&self) -> f64 {
        self.0.terminal_slack_cost
    }

    /// Sum of the kernel weights at the worst supported point of the horizon; 0: the nominal
    /// model stands alone there.
    #[getter]
    fn data_support_min(&self) -> f64 {
        self.0.data_support_min
    }

    /// Its mean over the horizon.
    #[getter]
    fn data_support_mean(&self) -> f64 {
        self.0.data_support_mean
    }

    /// Whether the input was cut to the car's limits.
    #[getter]
    fn clipped(&self) -> bool {
        self.0.clipped
    }

    /// The lap that this measurement finished.
    #[getter]
    fn finished(&self) -> Option<LapResult> {
        self.0.finished.map(LapResult)
    }

    fn __repr__(&self) -> String {
        let reason = reason_word(self.0.reason);
        let why = if reason.is_empty() { String::new() } else { format!(", {reason}") };
        format!("Status({}{why}, lap {})", action_word(self.0.action), self.0.lap)
    }
}

/// A finished lap.
#[pyclass(frozen, module = "racing_lmpc")]
pub(crate) struct LapResult(pub(crate) InnerLap);

#[pymethods]
impl LapResult {
    /// Number of the lap, from 1.
    #[getter]
    fn lap(&self) -> u32 {
        self.0.lap.get()
    }

    /// ``warmup``, ``learning`` or ``driven``.
    #[getter]
    fn kind(&self) -> &'static str {
        kind_word(self.0.kind)
    }

    /// Time between the interpolated crossings of the line [s].
    #[getter]
    fn lap_time(&self) -> f64 {
        self.0.lap_time
    }

    /// Whether the whole lap was inside the track, with complete data.
    #[getter]
    fn valid(&self) -> bool {
        self.0.valid
    }

    fn __repr__(&self) -> String {
        let invalid = if self.0.valid { "" } else { ", invalid" };
        format!("LapResult({} lap {}, {:.3} s{invalid})", self.kind(), self.0.lap, self.0.lap_time)
    }
}
