//! What a solver is asked for, and what it answers.

use serde::{Deserialize, Serialize};

use super::{Fhocp, Solution};

/// When a solver ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Termination {
    /// Tolerance of gap and feasibility.
    pub tolerance: f64,
    /// Most iterations of one solve.
    pub max_iterations: u32,
}

/// How the solver ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum SolveStatus {
    /// No problem was given to the solver in this step.
    #[default]
    NotRun,
    /// Solved to tolerance.
    Solved,
    /// Solved to a reduced tolerance; the solution is used.
    AlmostSolved,
    /// Iteration limit.
    MaxIterations,
    /// Reported infeasible. The FHOCP is feasible by construction: its prediction exploded.
    Infeasible,
    /// Numerical failure or a value that is not finite.
    Numerical,
}

impl SolveStatus {
    /// Number of the status in FMU outputs: its place in the list above, from 0.
    #[must_use]
    pub const fn code(self) -> u8 {
        self as u8
    }

    /// Whether the solution may be applied.
    #[must_use]
    pub fn usable(self) -> bool {
        matches!(self, Self::Solved | Self::AlmostSolved)
    }
}

/// Which solver a solution is from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Backend {
    /// The structured interior-point method, [`crate::RiccatiSolver`].
    Structured,
    /// Clarabel, [`crate::ClarabelSolver`].
    Clarabel,
}

/// How a solve ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SolveReport {
    /// Outcome; the solution may be used only if [`SolveStatus::usable`].
    pub status: SolveStatus,
    /// Iterations.
    pub iterations: u32,
    /// Which solver it was.
    pub backend: Backend,
}

/// A solver of the FHOCP. Its result depends on the problem alone, not on earlier solves.
pub trait FhocpSolver {
    /// Does the part of the next solve that does not depend on x_0 and u_prev. Only those two may
    /// change before `solve`; the result is the same as without `prepare`.
    fn prepare(&mut self, _problem: &Fhocp) {}

    /// Forgets what is prepared: the problem has changed.
    fn forget(&mut self) {}

    /// Solves `problem` into `solution`, which has the problem's size.
    fn solve(&mut self, problem: &Fhocp, solution: &mut Solution) -> SolveReport;
}
