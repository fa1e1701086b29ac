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
        let [min_us, median_us, p99_us] = quantiles(times, [0, 50, 99]);
        Self { min_us, median_us, p99_us }
    }
}

/// The values below which these percentages of `values` lie, which are sorted on the way; NaN of none.
pub(super) fn quantiles<const N: usize>(values: &mut [f64], percents: [usize; N]) -> [f64; N] {
    values.sort_unstable_by(f64::total_cmp);
    let last = values.len().saturating_sub(1);
    percents.map(|percent| values.get(last * percent / 100).copied().unwrap_or(f64::NAN))
}

/// Involuntary context switches of this thread so far; 0 where the system does not count them.
pub(super) fn preemptions() -> i64 {
    getrusage(UsageWho::RUSAGE_THREAD).map_or(0, |usage| usage.involuntary_context_switches())
}
