//! How old a command's fallback plan is.

/// Step of the fallback plan that is in force `age_ns` \[ns\] after its command arrived: `None` as long as
/// the command's own input is, which is one period, `period_ns` \[ns\], until the next command is due. Its
/// first step begins with the command, each lasts `plan_dt` \[s\], the last of the `steps` until the command
/// is dead.
#[must_use]
pub fn plan_step(age_ns: i64, period_ns: i64, plan_dt: f64, steps: usize) -> Option<usize> {
    if age_ns <= period_ns {
        return None;
    }
    let passed = if plan_dt > 0.0 { age_ns as f64 * 1e-9 / plan_dt } else { 0.0 };
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "above 0")]
    Some((passed as usize).min(steps.saturating_sub(1)))
}
