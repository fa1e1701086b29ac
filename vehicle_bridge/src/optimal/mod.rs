//! Time-optimal laps on disk: tables, racelines, pictures, and a store in which races find them.

pub mod files;
pub mod picture;
mod store;

pub use store::{Known, Store};
