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
//! | (1) x_{k+1} = f(x_k, u_k) | [`vehicle_model::Discretized::next`] |
//! | dynamic bicycle model | [`vehicle_model::Model`], [`bicycle.rs`](../src/vehicle_model/model/bicycle.rs.html) |
//! | Frenet kinematics (text) | [`pose_rates`](../src/vehicle_model/model.rs.html) |
//! | (2) minimum-lap-time problem, indicator 1_F | not solved itself; the cost-to-go counts periods: [`learning::safe_set`] |
//! | D^j, recorded laps | [`learning::dataset`] |
//! | (3) K nearest points under a metric D | [`learning::safe_set::SafeSet`]; nearest in s, see below |
//! | X^j: P laps, K points each | [`learning::safe_set::SafeSet`], [`config::SafeSetConfig`] |
//! | T^i - k, cost-to-go | [`config::CostToGo::Line`], [`learning::safe_set`] |
//! | Q_N, terminal cost | J' lambda inside the FHOCP: [`fhocp::Fhocp::cost_to_go`] |
//! | (4) FHOCP | [`fhocp`]; filled in [`optimize.rs`](../src/controller/optimize.rs.html), rows in [`layout.rs`](../src/fhocp/layout.rs.html) |
//! | c_u, c_du | [`config::CostConfig`] |
//! | z_bar, the shifted solution | [`Plan`], [`plan.rs`](../src/controller/plan.rs.html) |
//! | A, B, C = nominal + error | [`LearnedModel::sum`] |
//! | (5) x_{k+1} = f + e | [`learn.rs`](../src/controller/learn.rs.html) |
//! | (6) A^e, B^e, C^e | [`ridge.rs`](../src/controller/learning/ridge.rs.html) |
//! | (7) features of each row | [`config::Features`], [`ridge.rs`](../src/controller/learning/ridge.rs.html) |
//! | K(u), h, Epanechnikov kernel | [`learning::regression`] |
//! | (8) Gamma*, weighted ridge regression | [`learning::regression`], solved in [`ridge.rs`](../src/controller/learning/ridge.rs.html) |
//! | M neighbours, Q, eps | [`config::RegressionConfig`] |
//! | D^0, initial laps | [`drive.rs`](../src/controller/drive.rs.html), [`vehicle_model::Tracker`], [`config::WarmUpConfig`] |
//! | iteration of the controller | [`Controller::step`] |
//!
//! # Deviations from the paper
//!
//! | the paper | here | reason |
//! |---|---|---|
//! | nearest points under a metric D (3) | nearest in s | D = diag(0, 0, 0, 0, 1, 0) in the order of the state |
//! | indicator cost 1_F in the stage cost (2) | absent | piecewise constant: it has no gradient, and the cost-to-go J counts the same periods |
//! | terminal equality, hard lane | soft, with penalties | the problem stays feasible for every measured state |
//! | e_y, a distance | signed, positive to the left | the two edges of the lane need a sign |
//! | kernel K of the metric distance | K of the squared metric distance | with it the paper's study of h is reproduced |
//! | rate cost on u_t - u_{t-1} | on the rate per second | as printed, the steering is bang-bang at the paper's weights |
//! | T^i - k, to the line | preset `race`: to the place of the plan's end one lap later ([`config::CostToGo::Round`]) | at the line the set falls back by one lap, and what the laps cost changes at once |
//! | - | preset `race` adds slip guards, tyre dissipation, a speed envelope and grip adaptation ([`config`]) | beyond the tyres' peak the linearised problem steers the wrong way |
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
