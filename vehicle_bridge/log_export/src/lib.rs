//! Logs of LCM for other tools: tables in CSV, and MCAP for Foxglove.
//!
//! Messages are decoded with types known at run time: the product's own and those of any `.lcm`
//! file. What is damaged is skipped and counted.

pub mod columns;
pub mod csv;
pub mod json;
pub mod log;
pub mod mcap;
pub mod scene;
pub mod schema;
mod types;

pub use log::{Account, Stream};
pub use types::Types;
