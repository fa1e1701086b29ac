//! What all programs around a controller share: cars and tracks by name, layers of configuration,
//! learned data and optimal control problems on disk, times of a step, the rule of a failed run, threads, signals, real-time
//! priority.
//!
//! Nothing in here knows of networks, of races or of a command line.

pub mod learned;
pub mod load;
pub mod memory;
pub mod parallel;
pub mod problem_file;
pub mod realtime;
pub mod rule;
pub mod settings;
pub mod shutdown;
pub mod timing;
pub mod worker;
