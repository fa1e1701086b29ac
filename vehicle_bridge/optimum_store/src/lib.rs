//! Time-optimal laps on disk: tables, racelines, and a store in which races find them.

pub mod files;
mod store;

pub use store::{Known, OptimumStore};
