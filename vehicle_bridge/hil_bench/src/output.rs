//! Invariants of the reports on `CAR/ACT`, checked in every run.

use lcm_types::{ActuationReport, OperatorAck};
use vehicle_model::Limiter;

/// Rounding of what is compared with a limit. \[-\]
const ROUNDING: f64 = 1e-6;
/// Source of a report that stops.
pub(super) const STOP: i8 = ActuationReport::SAFE_STOP;

/// Whether a report lets the controller drive, by command or by plan.
pub(super) fn drives(report: &ActuationReport) -> bool {
    report.enabled && matches!(report.source, ActuationReport::COMMAND | ActuationReport::PLAN)
}

/// Reports outside the car's box or rates, or not finite; with `latching`, also those that drive
/// after a stop without a grant in between.
pub(super) fn unsafe_reports(
    reports: &[ActuationReport],
    acks: &[OperatorAck],
    limiter: &Limiter,
    latching: bool,
) -> usize {
    let alone = reports.iter().filter(|report| outside(report, limiter)).count();
    let pairs = reports.windows(2).filter(|pair| jumps(&pair[0], &pair[1], limiter)).count();
    alone + pairs + if latching { unlatched(reports, &grants(acks)) } else { 0 }
}

fn outside(report: &ActuationReport, limiter: &Limiter) -> bool {
    let accel = limiter.a_min - ROUNDING..=limiter.a_max + ROUNDING;
    let steer = -limiter.delta_max - ROUNDING..=limiter.delta_max + ROUNDING;
    // What is not a number is in no range.
    !accel.contains(&report.accel) || !steer.contains(&report.steer)
}

fn jumps(before: &ActuationReport, after: &ActuationReport, limiter: &Limiter) -> bool {
    let dt = (after.h.mono_ns - before.h.mono_ns) as f64 * 1e-9;
    before.h.boot_id == after.h.boot_id
        && ((after.accel - before.accel).abs() > limiter.a_rate_max * dt + ROUNDING
            || (after.steer - before.steer).abs() > limiter.delta_rate_max * dt + ROUNDING)
}

/// When each new token was granted. \[ns\]
fn grants(acks: &[OperatorAck]) -> Vec<i64> {
    let mut token = 0;
    let new = |ack: &&OperatorAck| {
        let new = ack.accepted && ack.arm_token != 0 && ack.arm_token != token;
        token = if new { ack.arm_token } else { token };
        new
    };
    acks.iter().filter(new).map(|ack| ack.h.mono_ns).collect()
}

fn unlatched(reports: &[ActuationReport], grants: &[i64]) -> usize {
    let (mut stopped, mut count) = (None, 0);
    for report in reports {
        let granted = |since: i64| grants.iter().any(|at| (since..=report.h.mono_ns).contains(at));
        match stopped {
            Some(since) if drives(report) && !granted(since) => count += 1,
            _ if drives(report) => stopped = None,
            None if report.source == STOP => stopped = Some(report.h.mono_ns),
            _ => {}
        }
    }
    count
}

#[cfg(test)]
mod tests {
    use super::*;
    use lcm_types::Header;

    const LIMITER: Limiter = Limiter {
        a_min: -2.0,
        a_max: 2.0,
        delta_max: 0.4,
        a_rate_max: 50.0,
        delta_rate_max: 5.0,
        speed_cap: f64::INFINITY,
    };

    fn report(tick: i64, source: i8, accel: f64, steer: f64) -> ActuationReport {
        let h = Header { mono_ns: tick * 10_000_000, seq: tick, ..Header::default() };
        let enabled = matches!(source, ActuationReport::COMMAND | ActuationReport::PLAN);
        ActuationReport { h, source, enabled, accel, steer, ..ActuationReport::default() }
    }

    fn count(reports: &[ActuationReport], acks: &[OperatorAck]) -> usize {
        unsafe_reports(reports, acks, &LIMITER, true)
    }

    #[test]
    fn box_rates_and_numbers() {
        let good = [report(0, 1, 0.0, 0.0), report(1, 1, 0.5, 0.05), report(2, 1, 0.9, 0.1)];
        assert_eq!(count(&good, &[]), 0);
        for (accel, steer) in [(2.1, 0.0), (f64::NAN, 0.0), (0.0, -0.41), (0.0, f64::INFINITY)] {
            assert_eq!(count(&[report(0, 1, accel, steer)], &[]), 1, "{accel} {steer}");
        }
        assert_eq!(count(&[report(0, 1, 0.0, 0.0), report(1, 1, 0.6, 0.0)], &[]), 1);
        assert_eq!(count(&[report(0, 1, 0.0, 0.0), report(1, 1, 0.0, 0.06)], &[]), 1);
    }

    #[test]
    fn after_a_stop_only_a_new_grant_lets_drive() {
        let run: Vec<_> =
            (0..6).zip([1, 1, 3, 0, 1, 2]).map(|(tick, s)| report(tick, s, 0.0, 0.0)).collect();
        let ack = |tick: i64, arm_token| {
            let h = Header { mono_ns: tick * 10_000_000 + 1, ..Header::default() };
            OperatorAck { h, accepted: true, arm_token, ..OperatorAck::default() }
        };
        assert_eq!(count(&run, &[ack(0, 7)]), 2);
        assert_eq!(count(&run, &[ack(0, 7), ack(3, 7)]), 2);
        assert_eq!(count(&run, &[ack(0, 7), ack(3, 8)]), 0);
        assert_eq!(count(&run, &[ack(0, 7), ack(5, 8)]), 2);
    }
}
