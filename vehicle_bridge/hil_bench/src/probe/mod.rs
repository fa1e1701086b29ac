//! Programs of the shipped benches. Each returns what it measured; `lmpc hil probe` prints that, one
//! `name value` a line.

mod damaged_log;
mod saver;

pub use damaged_log::run as damaged_log;
pub use saver::{kills as saver_kills, save as saver};

/// What a program measured: names and counts.
pub type Measured = Vec<(&'static str, u64)>;
