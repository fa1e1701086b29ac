//! The columns of a race's tables, by name: what the files, the studies and the Python package show
//! of a step and of a lap.

use std::fmt;

use super::record::{LapRow, StepRow};
use super::words::{action_word, kind_word, reason_word, solve_word, solver_word};

/// One value of a table.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ColumnValue {
    /// A number.
    Number(f64),
    /// A number that there may be none of: it is not a number then, and empty in a file.
    Maybe(f64),
    /// A count.
    Count(u64),
    /// A count that may be missing.
    MaybeCount(Option<u64>),
    /// A word.
    Word(&'static str),
    /// Yes or no.
    Switch(bool),
}

impl ColumnValue {
    /// The value as a number; a switch is 0 or 1, a word and a missing value are none.
    #[must_use]
    pub fn number(self) -> Option<f64> {
        let number = match self {
            Self::Number(value) | Self::Maybe(value) => value,
            Self::Count(count) | Self::MaybeCount(Some(count)) => count as f64,
            Self::Switch(on) => f64::from(u8::from(on)),
            Self::MaybeCount(None) | Self::Word(_) => return None,
        };
        number.is_finite().then_some(number)
    }
}

/// As in a file: reading a number gives the same bits again.
impl fmt::Display for ColumnValue {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Maybe(value) if value.is_nan() => Ok(()),
            Self::Number(value) | Self::Maybe(value) => write!(f, "{value}"),
            Self::Count(count) | Self::MaybeCount(Some(count)) => write!(f, "{count}"),
            Self::MaybeCount(None) => Ok(()),
            Self::Word(word) => f.write_str(word),
            Self::Switch(on) => write!(f, "{on}"),
        }
    }
}

/// A column of a table whose rows are `T`.
#[derive(Debug, Clone, Copy)]
pub struct Column<T> {
    /// Name, with the unit at its end.
    pub name: &'static str,
    /// The value in a row.
    pub of: fn(&T) -> ColumnValue,
}

macro_rules! columns {
    ($row:ident; $($name:literal $kind:ident($value:expr)),* $(,)?) => {
        &[$(Column { name: $name, of: |$row| ColumnValue::$kind($value) }),*]
    };
}

/// The columns of `laps.csv`.
pub const LAPS: &[Column<LapRow>] = columns! { lap;
    "lap" Count(u64::from(lap.result.lap.get())),
    "kind" Word(kind_word(lap.result.kind)),
    "iteration" MaybeCount(lap.iteration.map(u64::from)),
    "lap_time_s" Number(lap.result.lap_time),
    "valid" Switch(lap.result.valid),
    "v_max_mps" Number(lap.v_max),
    "v_mean_mps" Number(lap.v_mean),
    "e_y_max_m" Number(lap.e_y_max),
    "alpha_f_max_rad" Number(lap.alpha_f_max),
    "alpha_r_max_rad" Number(lap.alpha_r_max),
    "steps" Count(lap.steps as u64),
    "fallbacks" Count(lap.fallbacks as u64),
    "clipped" Count(lap.clipped as u64),
    "data_support_min" Maybe(lap.support_min),
    "data_support_mean" Maybe(lap.support_mean),
    "model_error_median" Maybe(lap.model_error_median),
    "model_error_mean" Maybe(lap.model_error_mean),
    "iterations_mean" Maybe(lap.iterations_mean),
    "iterations_max" Count(u64::from(lap.iterations_max)),
    "grip_f" Number(lap.grip[0]),
    "grip_r" Number(lap.grip[1]),
    "overhang_max_m" Number(lap.overhang_max),
};

/// The columns of `trajectory.csv`.
pub const STEPS: &[Column<StepRow>] = columns! { row;
    "time_s" Number(row.time),
    "lap" Count(u64::from(row.status.lap.get())),
    "v_x_mps" Number(row.x.v_x),
    "v_y_mps" Number(row.x.v_y),
    "omega_z_radps" Number(row.x.omega_z),
    "e_psi_rad" Number(row.x.e_psi),
    "s_m" Number(row.x.s),
    "e_y_m" Number(row.x.e_y),
    "a_mps2" Number(row.u.a),
    "delta_rad" Number(row.u.delta),
    "x_m" Number(row.pose.x),
    "y_m" Number(row.pose.y),
    "psi_rad" Number(row.pose.psi),
    "alpha_f_rad" Number(row.alpha_f),
    "alpha_r_rad" Number(row.alpha_r),
    "tyre_use_f" Number(row.use_f),
    "tyre_use_r" Number(row.use_r),
    "action" Word(action_word(row.status.action)),
    "reason" Word(reason_word(row.status.reason)),
    "solve" Word(solve_word(row.status.solve)),
    "solver" Word(solver_word(row.status.solver)),
    "iterations" Count(u64::from(row.status.iterations)),
    "cost" Number(row.status.cost),
    "lane_slack_m" Number(row.status.lane_slack),
    "front_slip_slack_rad" Number(row.status.front_slip_slack),
    "rear_slip_slack_rad" Number(row.status.rear_slip_slack),
    "speed_slack_mps" Number(row.status.speed_slack),
    "terminal_slack_cost" Number(row.status.terminal_slack_cost),
    "data_support_min" Number(row.status.data_support_min),
    "data_support_mean" Number(row.status.data_support_mean),
    "model_error" Maybe(row.model_error.median),
    "clipped" Switch(row.status.clipped),
    "overhang_m" Number(row.overhang),
};
