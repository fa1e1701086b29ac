//! What the tests that cross crates share: the reference numbers, and a car that drives.

mod drive;

pub use drive::{Drive, barc, l_track};

use std::path::PathBuf;

use serde::de::DeserializeOwned;

/// The folder of the reference numbers: `LMPC_REFERENCE_DIR`, by default `tests/data/reference`;
/// a relative one counts from the workspace.
#[must_use]
pub fn reference_dir() -> PathBuf {
    let named = std::env::var_os("LMPC_REFERENCE_DIR");
    let named = named.map_or_else(|| PathBuf::from("tests/data/reference"), PathBuf::from);
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("..").join(named)
}

/// Text of a reference file.
///
/// # Panics
/// If the file cannot be read: a test without its numbers must fail.
#[must_use]
#[allow(clippy::panic)]
pub fn reference_text(name: &str) -> String {
    let path = reference_dir().join(name);
    std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// A JSON reference file.
///
/// # Panics
/// If the file cannot be read or has another layout.
#[must_use]
#[allow(clippy::panic)]
pub fn read_reference<T: DeserializeOwned>(name: &str) -> T {
    serde_json::from_str(&reference_text(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
}
