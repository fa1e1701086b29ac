//! Memory of running processes.

/// Pages of memory on every system this runs on. \[MB\]
const PAGE_MB: f32 = 4096.0 / 1e6;

/// Resident memory of a process, by its id; 0 where the system does not count it. \[MB\]
#[must_use]
pub fn resident_mb(process: &str) -> f32 {
    let text = std::fs::read_to_string(format!("/proc/{process}/statm")).unwrap_or_default();
    let pages = text.split_whitespace().nth(1).and_then(|pages| pages.parse::<f32>().ok());
    pages.unwrap_or(0.0) * PAGE_MB
}
