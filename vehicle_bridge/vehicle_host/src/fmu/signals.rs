//! What positions and rates over time say: speed, course, delay, lag.

use actuators::Response;
use vehicle_model::track::wrap_angle;

/// What was driven and measured at an instant.
#[derive(Clone, Copy)]
pub(super) struct Sample {
    pub(super) time: f64,
    pub(super) q: [f64; 6],
}

pub(super) fn way(samples: &[Sample]) -> f64 {
    let step = |p: &[Sample]| (p[1].q[3] - p[0].q[3]).hypot(p[1].q[4] - p[0].q[4]);
    samples.windows(2).map(step).sum()
}

/// Distance of two samples whose difference is a speed or a course: noise has less weight over it.
pub(super) fn stride(samples: &[Sample]) -> usize {
    (samples.len() / 20).max(1)
}

/// Speed by the positions, over time.
pub(super) fn speeds(samples: &[Sample]) -> Vec<(f64, f64)> {
    let n = stride(samples);
    let pairs = samples.iter().zip(&samples[n..]);
    let speed = |(a, b): (&Sample, &Sample)| {
        let (dx, dy) = (b.q[3] - a.q[3], b.q[4] - a.q[4]);
        (0.5 * (a.time + b.time), dx.hypot(dy) / (b.time - a.time))
    };
    pairs.map(speed).collect()
}

/// The last v_x as read.
pub(super) fn speed_read(samples: &[Sample]) -> f64 {
    samples.last().map_or(f64::NAN, |sample| sample.q[0])
}

pub(super) fn speed_at_end(samples: &[Sample]) -> f64 {
    speeds(samples).last().map_or(0.0, |s| s.1)
}

/// Course by the positions, over time, without jumps.
pub(super) fn course(samples: &[Sample]) -> Vec<(f64, f64)> {
    let n = stride(samples);
    let mut all: Vec<(f64, f64)> = Vec::new();
    for (a, b) in samples.iter().zip(&samples[n..]) {
        let (dx, dy) = (b.q[3] - a.q[3], b.q[4] - a.q[4]);
        if dx.hypot(dy) > 0.0 {
            let angle = dy.atan2(dx);
            let angle = all.last().map_or(angle, |last| last.1 + wrap_angle(angle - last.1));
            all.push((0.5 * (a.time + b.time), angle));
        }
    }
    all
}

pub(super) fn derivative(values: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let n = (values.len() / 20).max(1);
    let pairs = values.iter().zip(values.get(n..).unwrap_or_default());
    pairs.map(|(a, b)| (0.5 * (a.0 + b.0), (b.1 - a.1) / (b.0 - a.0))).collect()
}

pub(super) fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut all: Vec<f64> = values.filter(|v| v.is_finite()).collect();
    all.sort_by(f64::total_cmp);
    all.get(all.len() / 2).copied().unwrap_or(f64::NAN)
}

/// Delay and lag of an answer that begins after `from` \[s\], by its tenth and its 63 % \[-\] of the
/// steady value: of a first-order lag T behind a delay d, d + 0.105 T and d + T.
pub(super) fn response(values: &[(f64, f64)], from: f64) -> Response {
    let steady = median(values[values.len() * 2 / 3..].iter().map(|v| v.1));
    let when = |share: f64| {
        let reached = values.iter().find(|v| v.1 / steady >= share);
        reached.map_or(f64::NAN, |v| v.0 - from)
    };
    let (tenth, most) = (when(0.1), when(0.632));
    let lag = ((most - tenth) / 0.895).max(0.0);
    Response { delay: (tenth - 0.105 * lag).max(0.0), lag }
}

/// How often the measurements change.
pub(super) fn period(samples: &[Sample], dt: f64) -> f64 {
    let changes = samples.windows(2).filter(|p| p[0].q != p[1].q).count();
    dt * (samples.len() - 1) as f64 / changes.max(1) as f64
}
