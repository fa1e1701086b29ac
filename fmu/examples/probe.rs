//! The test model as a shared library, for importers that are not Rust. Never shipped.

#[path = "../tests/probe/mod.rs"]
mod probe;

use probe::Probe;

fmu_core::export_fmu!(Probe);
