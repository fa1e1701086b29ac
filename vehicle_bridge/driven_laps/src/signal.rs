//! Signals of a stretch of a drive: on an even grid, without noise, at any time.

use super::smooth::smooth;

/// Values at equal distances in time.
#[derive(Debug, Clone)]
pub(super) struct Signal {
    start: f64,
    interval: f64,
    values: Vec<f64>,
    /// Standard deviation of the noise that was taken away.
    pub(super) noise: f64,
}

impl Signal {
    /// Of samples at increasing times, smoothed if `smoothing`.
    pub(super) fn new(times: &[f64], samples: &[f64], interval: f64, smoothing: bool) -> Self {
        let (start, end) = (times[0], times[times.len() - 1]);
        let count = |interval: f64| ((end - start) / interval + 1e-6) as usize + 1;
        let is_even = |interval: f64| {
            let at = |i: usize| start + i as f64 * interval;
            let near = |(i, t): (usize, &f64)| (t - at(i)).abs() < 0.02 * interval;
            count(interval) == times.len() && times.iter().enumerate().all(near)
        };
        // An interval of rounded times is off by their rounding, which adds up; their mean is not.
        let mean = (end - start) / (times.len() - 1).max(1) as f64;
        let interval = if !is_even(interval) && is_even(mean) { mean } else { interval };
        let (even, count) = (is_even(interval), count(interval));
        let on_grid = if even {
            samples.to_vec()
        } else {
            (0..count).map(|i| linear(times, samples, start + i as f64 * interval)).collect()
        };
        if !smoothing {
            return Self { start, interval, values: on_grid, noise: 0.0 };
        }
        let smoothed = smooth(&on_grid);
        Self { start, interval, values: smoothed.values, noise: smoothed.noise }
    }

    /// Time of the last value.
    pub(super) fn end(&self) -> f64 {
        self.start + (self.values.len() - 1) as f64 * self.interval
    }

    /// Value at a time, by the cubic through the four nearest samples; itself at a sample.
    pub(super) fn at(&self, time: f64) -> f64 {
        let (i, u) = self.place(time);
        let y = |k: usize| self.values[k];
        if self.values.len() < 4 {
            let next = (i + 1).min(self.values.len() - 1);
            return y(i) + u * (y(next) - y(i));
        }
        let first = i.saturating_sub(1).min(self.values.len() - 4);
        let v = u + (i - first) as f64;
        let weight = |k: usize| {
            let others = (0..4).filter(|&m| m != k);
            others.map(|m| (v - m as f64) / (k as f64 - m as f64)).product::<f64>()
        };
        (0..4).map(|k| weight(k) * y(first + k)).sum()
    }

    /// Derivative at a time, by a central difference over one interval on either side.
    pub(super) fn rate(&self, time: f64) -> f64 {
        let (low, high) = (time - self.interval, time + self.interval);
        let (low, high) = (low.max(self.start), high.min(self.end()));
        if high > low { (self.at(high) - self.at(low)) / (high - low) } else { 0.0 }
    }

    fn place(&self, time: f64) -> (usize, f64) {
        let x = ((time - self.start) / self.interval).clamp(0.0, (self.values.len() - 1) as f64);
        let near = x.round();
        // Rounding of the time is no distance from the sample.
        let x = if (x - near).abs() < 1e-6 { near } else { x };
        let i = (x as usize).min(self.values.len() - 1);
        (i, x - i as f64)
    }
}

fn linear(times: &[f64], samples: &[f64], time: f64) -> f64 {
    let next = times.partition_point(|&t| t < time).clamp(1, times.len() - 1);
    let (t0, t1) = (times[next - 1], times[next]);
    let share = ((time - t0) / (t1 - t0)).clamp(0.0, 1.0);
    samples[next - 1] + share * (samples[next] - samples[next - 1])
}

/// Angles without their jumps by full turns.
pub(super) fn unwrapped(angles: &[f64]) -> Vec<f64> {
    let mut last = angles.first().copied().unwrap_or_default();
    let turn = |angle: &f64| {
        last += vehicle_model::track::wrap_angle(angle - last);
        last
    };
    angles.iter().map(turn).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn between_samples_a_cubic_is_itself() {
        let times: Vec<f64> = (0..20).map(|i| 5.0 + 0.1 * f64::from(i)).collect();
        let cubic = |t: f64| t * t * t - 2.0 * t * t + 7.0;
        let samples: Vec<f64> = times.iter().map(|t| cubic(*t)).collect();
        let signal = Signal::new(&times, &samples, 0.1, false);
        for time in [5.0, 5.03, 5.55, 6.0, 6.81, 6.9] {
            assert!((signal.at(time) - cubic(time)).abs() < 1e-9 * cubic(time));
        }
        assert_eq!(signal.at(times[7]).to_bits(), samples[7].to_bits());
        let slope = (cubic(6.1) - cubic(5.9)) / 0.2;
        assert!((signal.rate(6.0) - slope).abs() < 1e-6);
    }

    #[test]
    fn angles_go_on_through_full_turns() {
        let angles = unwrapped(&[3.0, -3.0, -2.0, 3.1]);
        assert!((angles[1] - (std::f64::consts::TAU - 3.0)).abs() < 1e-12);
        assert!((angles[3] - 3.1).abs() < 1e-12);
    }
}
