//! Learning model predictive control with error dynamics regression for autonomous racing
//! (Xue, Zhu, Dolan, Borrelli 2023).
//!
//! # From the paper to the code
//!
//! Numbers in brackets are the equations of the paper.
//!
//! | in the paper | here |
//! |---|---|
//! | x (v_x, v_y, omega_z, e_psi, s, e_y), u (a, delta) | [`vehicle_model::State`], [`vehicle_model::Input`] |
//! | pose s, e_y, e_psi relative to the path | [`vehicle_model::Track::to_frenet`] |
//! | (1) x_{k+1} = f(x_k, u_k) | [`vehicle_model::Discretized::next`], [`discretized.rs`](../src/vehicle_model/discretized.rs.html) |
//! | dynamic bicycle | [`vehicle_model::Model`], [`bicycle.rs`](../src/vehicle_model/model/bicycle.rs.html) |
//! | Frenet kinematics, in the text | [`pose_rates`](../src/vehicle_model/model.rs.html) |
//! | (2) minimum-lap-time problem, indicator 1_F | not solved itself; the cost-to-go counts periods: [`learning::safe_set`] |
//! | D^j, recorded laps | [`learning::dataset`], [`dataset.rs`](../src/controller/learning/dataset.rs.html) |
//! | (3) K nearest points under a metric D | [`learning::safe_set::SafeSet`], [`safe_set.rs`](../src/controller/learning/safe_set.rs.html); nearest in s |
//! | X^j, P laps, K points each | [`safe_set.rs`](../src/controller/learning/safe_set.rs.html), [`config::SafeSetConfig`] |
//! | T^i - k, cost-to-go | [`safe_set.rs`](../src/controller/learning/safe_set.rs.html), [`config::CostToGo::Line`] |
//! | Q_N, terminal cost | J' lambda inside the FHOCP: [`fhocp::Fhocp::cost_to_go`] |
//! | (4) FHOCP | [`fhocp`], [its page](../src/fhocp/lib.rs.html); filled in [`optimize.rs`](../src/controller/optimize.rs.html), rows in [`layout.rs`](../src/fhocp/layout.rs.html) |
//! | c_u, c_du | [`config::CostConfig`] |
//! | z_bar, the shifted solution | [`Plan`], [`plan.rs`](../src/controller/plan.rs.html) |
//! | A = A^f + A^e, B and C likewise | [`LearnedModel::sum`], [`learned_model.rs`](../src/controller/learned_model.rs.html) |
//! | (5) x_{k+1} = f + e | [`targets.rs`](../src/controller/lap_end/targets.rs.html) |
//! | (6) A^e, B^e, C^e | [`ridge.rs`](../src/controller/learning/ridge.rs.html) |
//! | (7) features of each row | [`config::Features`], [`ridge.rs`](../src/controller/learning/ridge.rs.html) |
//! | K(u), h, Epanechnikov kernel | [`regression.rs`](../src/controller/learning/regression.rs.html) |
//! | (8) Gamma*, weighted ridge regression | [`regression.rs`](../src/controller/learning/regression.rs.html), solved in [`ridge.rs`](../src/controller/learning/ridge.rs.html) |
//! | M neighbours, Q, eps | [`config::RegressionConfig`] |
//! | D^0, initial laps | [`drive.rs`](../src/controller/drive.rs.html), [`vehicle_model::Tracker`], [`config::WarmUpConfig`] |
//! | iteration of the controller | [`Controller::step`] |
//!
//! The module of each row opens with the equation. Where this controller deviates from the paper, and why:
//! `docs/explanation/algorithm.md`, section "Deviations from the paper".
#![forbid(unsafe_code)]
// The same bits on every machine: no function of the platform's mathematical library.
#![cfg_attr(not(test), deny(clippy::disallowed_methods))]

mod actuation;
mod adopt;
pub mod config;
mod controller;
mod derive;
mod drive;
mod error;
mod filter;
mod lane;
mod lap_end;
mod lap_number;
mod learn;
mod learned_model;
pub mod learning;
mod memory;
mod observe;
mod optimize;
mod plan;
mod prediction_error;
mod presets;
mod recovery;
mod replan;
mod road;
mod slip;
mod snapshot;
mod status;
mod store;

pub use actuators::Response;
pub use adopt::DrivenStep;
pub use config::Config;
pub use controller::Controller;
pub use error::{ConfigError, DataError};
pub use fhocp::{self, Affine, SolveStatus};
pub use lap_number::LapNumber;
pub use learned_model::LearnedModel;
pub use plan::Plan;
pub use presets::Preset;
pub use snapshot::ControllerState;
pub use status::{
    Action, Command, LapKind, LapResult, Measurement, Phase, Pose, Probe, Reason, Status,
};
pub use store::Learned;
