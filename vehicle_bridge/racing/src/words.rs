//! Words of the controller's enums in CSV, JSON and reports.

use controller::config::{NominalModel, RegressionMode};
use controller::fhocp::Backend;
use controller::{Action, LapKind, Reason, SolveStatus};

/// The word of an action in CSV and JSON.
#[must_use]
pub fn action_word(action: Action) -> &'static str {
    match action {
        Action::WarmUp => "warm_up",
        Action::Learned => "learned",
        Action::ShiftedPlan => "shifted_plan",
        Action::Tracking => "tracking",
        Action::Braking => "braking",
        Action::Recovering => "recovering",
    }
}

/// The word of a reason in CSV and JSON; empty for none.
#[must_use]
pub fn reason_word(reason: Reason) -> &'static str {
    match reason {
        Reason::None => "",
        Reason::SolverFailed => "solver_failed",
        Reason::NonFinite => "non_finite",
        Reason::TimeNotAdvancing => "time_not_advancing",
        Reason::TimeGap => "time_gap",
        Reason::Jump => "jump",
        Reason::OffTrack => "off_track",
        Reason::WrongWay => "wrong_way",
        Reason::Standstill => "standstill",
        Reason::NoSafeSet => "no_safe_set",
        Reason::Spin => "spin",
        Reason::Askew => "askew",
    }
}

/// The word of how the solver ended, in CSV and JSON.
#[must_use]
pub fn solve_word(solve: SolveStatus) -> &'static str {
    match solve {
        SolveStatus::NotRun => "not_run",
        SolveStatus::Solved => "solved",
        SolveStatus::AlmostSolved => "almost_solved",
        SolveStatus::MaxIterations => "max_iterations",
        SolveStatus::Infeasible => "infeasible",
        SolveStatus::Numerical => "numerical",
    }
}

/// The word of a solver in CSV and JSON; empty for none.
#[must_use]
pub fn solver_word(solver: Option<Backend>) -> &'static str {
    match solver {
        None => "",
        Some(Backend::Structured) => "structured",
        Some(Backend::Clarabel) => "clarabel",
    }
}

/// The word of a lap's kind.
#[must_use]
pub fn kind_word(kind: LapKind) -> &'static str {
    match kind {
        LapKind::Warmup => "warmup",
        LapKind::Learning => "learning",
        LapKind::Driven => "driven",
    }
}

/// The word of a regression mode, as in the configuration.
#[must_use]
pub fn mode_word(mode: RegressionMode) -> &'static str {
    match mode {
        RegressionMode::Error => "error",
        RegressionMode::Full => "full",
        RegressionMode::Nominal => "nominal",
    }
}

/// The word of a nominal model, as in the configuration.
#[must_use]
pub fn model_word(model: NominalModel) -> &'static str {
    match model {
        NominalModel::Dynamic => "dynamic",
        NominalModel::Kinematic => "kinematic",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_words_of_a_row_are_written_in_one_way() {
        let solves = [
            SolveStatus::NotRun,
            SolveStatus::Solved,
            SolveStatus::AlmostSolved,
            SolveStatus::MaxIterations,
            SolveStatus::Infeasible,
            SolveStatus::Numerical,
        ];
        let actions = [Action::WarmUp, Action::Learned, Action::ShiftedPlan, Action::Braking];
        let backends = [Some(Backend::Structured), Some(Backend::Clarabel), None];
        let words = solves.map(solve_word).into_iter().chain(actions.map(action_word));
        let mut count = 0;
        for word in words.chain(backends.map(solver_word)) {
            let plain = word.chars().all(|c| c.is_ascii_lowercase() || c == '_');
            assert!(plain, "`{word}`: lower case with underscores");
            count += 1;
        }
        assert_eq!(count, 13);
    }
}
