//! Programs of the shipped benches. Each returns what it measured; `lmpc hil probe` prints that, one
//! `name value` a line.

mod damaged_log;
mod hostile_text;
mod logged_drive;
mod saver;
mod signalled_car;

pub use damaged_log::run as damaged_log;
pub use hostile_text::run as hostile_text;
pub use logged_drive::run as logged_drive;
pub use saver::{kills as saver_kills, save as saver};
pub use signalled_car::run as signalled_car;

/// What a program measured: names and counts.
pub type Measured = Vec<(&'static str, u64)>;
