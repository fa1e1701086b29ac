//! What the tests that cross crates share: the reference numbers.

use std::path::PathBuf;

/// The folder of the reference numbers: `LMPC_REFERENCE_DIR`, by default `tests/data/reference`.
#[must_use]
pub fn reference_dir() -> PathBuf {
    std::env::var_os("LMPC_REFERENCE_DIR").map_or_else(
        || PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("data/reference"),
        PathBuf::from,
    )
}
