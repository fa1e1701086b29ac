//! The words of CSV, JSON and reports for what the controller says in types.

use controller::config::{NominalModel, RegressionMode};
use controller::fhocp::Backend;
use controller::{Action, LapKind, Reason};

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
