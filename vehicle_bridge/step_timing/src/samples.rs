//! Times of one quantity, and when the system interfered.

use nix::sys::resource::{UsageWho, getrusage};
use serde::Serialize;

/// Quantiles of measured times \[us\].
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Times {
    /// Least.
    pub min_us: f64,
    /// Median.
    pub median_us: f64,
    /// 99 % are below.
    pub p99_us: f64,
}

impl Times {
    /// Quantiles of `times`, which are sorted on the way; NaN of none.
    #[must_use]
    pub fn of(times: &mut [f64]) -> Self {
        times.sort_unstable_by(f64::total_cmp);
        let at = |percent: usize| {
            times.get(times.len().saturating_sub(1) * percent / 100).copied().unwrap_or(f64::NAN)
        };
        Self { min_us: at(0), median_us: at(50), p99_us: at(99) }
    }
}

/// Involuntary context switches of this thread so far; 0 where the system does not count them.
pub(super) fn preemptions() -> i64 {
    getrusage(UsageWho::RUSAGE_THREAD).map_or(0, |usage| usage.involuntary_context_switches())
}
