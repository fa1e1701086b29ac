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
    #[getter]
    fn action(&self) -> &'static str {
        action_word(self.0.action)
    }

    #[getter]
    fn reason(&self) -> &'static str {
        reason_word(self.0.reason)
    }

    #[getter]
    fn solve(&self) -> &'static str {
        solve_word(self.0.solve)
    }

    #[getter]
    fn solver(&self) -> &'static str {
        solver_word(self.0.solver)
    }

    #[getter]
    fn iterations(&self) -> u32 {
        self.0.iterations
    }

    #[getter]
    fn lap(&self) -> u32 {
        self.0.lap
    }

    #[getter]
    fn state<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        from_state(py, &self.0.state)
    }

    #[getter]
    fn cost(&self) -> f64 {
        self.0.cost
    }

    #[getter]
    fn cost_to_go(&self) -> f64 {
        self.0.cost_to_go
    }

    #[getter]
    fn lane_slack(&self) -> f64 {
        self.0.lane_slack
    }

    #[getter]
    fn front_slip_slack(&self) -> f64 {
        self.0.front_slip_slack
    }

    #[getter]
    fn rear_slip_slack(&self) -> f64 {
        self.0.rear_slip_slack
    }

    #[getter]
    fn speed_slack(&self) -> f64 {
        self.0.speed_slack
    }

    #[getter]
    fn terminal_slack_cost(&self) -> f64 {
        self.0.terminal_slack_cost
    }

    #[getter]
    fn data_support_min(&self) -> f64 {
        self.0.data_support_min
    }

    #[getter]
    fn data_support_mean(&self) -> f64 {
        self.0.data_support_mean
    }

    #[getter]
    fn clipped(&self) -> bool {
        self.0.clipped
    }

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
    #[getter]
    fn lap(&self) -> u32 {
        self.0.lap
    }

    #[getter]
    fn kind(&self) -> &'static str {
        kind_word(self.0.kind)
    }

    #[getter]
    fn lap_time(&self) -> f64 {
        self.0.lap_time
    }

    #[getter]
    fn valid(&self) -> bool {
        self.0.valid
    }

    fn __repr__(&self) -> String {
        let invalid = if self.0.valid { "" } else { ", invalid" };
        format!("LapResult({} lap {}, {:.3} s{invalid})", self.kind(), self.0.lap, self.0.lap_time)
    }
}
