//! The time-optimal lap of a car on a track: what no driver and no controller can beat.
//!
//! The equations of motion of `vehicle_model` are collocated along s (direct transcription), the
//! lap is periodic, the mesh is refined until the plant confirms every interval, and the nonlinear
//! program is solved by an interior-point method with exact second derivatives. The result is a
//! local optimum; several starts are tried and the best is kept.
//!
//! The car's inputs may change at any time here, while a controller holds them over its period.
#![forbid(unsafe_code)]

mod case;
mod check;
mod dynamics;
mod error;
mod interior_point;
mod interval;
mod lap;
mod mesh;
mod options;
mod problem;
mod refine;
mod rules;
mod solve;
mod start;

pub use error::Error;
pub use lap::{LapPoint, Optimum, Quality};
pub use options::{Options, SolveProgress};
pub use solve::{solve, solve_with_progress};
