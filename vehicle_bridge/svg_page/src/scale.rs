//! Axes: from numbers to pixels, with ticks at round numbers.

/// How an axis is divided.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ScaleKind {
    /// Evenly.
    #[default]
    Linear,
    /// By powers of ten.
    Log,
}

/// An axis over the numbers it has to show.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scale {
    kind: ScaleKind,
    least: f64,
    most: f64,
}

/// Below so many decades an axis needs ticks between them.
const FEW_DECADES: f64 = 2.5;

/// Least number a logarithmic axis shows.
const LOG_FLOOR: f64 = 1e-12;

impl Scale {
    /// The axis that shows all of `values`; numbers that are not finite are left out.
    #[must_use]
    pub fn around(kind: ScaleKind, values: impl Iterator<Item = f64>) -> Self {
        let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
        for value in
            values.filter(|v| v.is_finite() && (kind == ScaleKind::Linear || *v > LOG_FLOOR))
        {
            least = least.min(value);
            most = most.max(value);
        }
        if least > most {
            (least, most) = (0.1, 1.0);
        }
        let (mut least, mut most) = (forward(kind, least), forward(kind, most));
        if most - least < 1e-9 {
            least -= 0.5;
            most += 0.5;
        }
        let room = 0.05 * (most - least);
        Self { kind, least: least - room, most: most + room }
    }

    /// The linear axis from `least` to `most`.
    #[must_use]
    pub fn exactly(least: f64, most: f64) -> Self {
        Self { kind: ScaleKind::Linear, least, most: most.max(least + 1e-9) }
    }

    /// Where a number lies: 0 at the axis's beginning, 1 at its end.
    #[must_use]
    pub fn part(&self, value: f64) -> f64 {
        let value =
            if self.kind == ScaleKind::Log { value.max(10f64.powf(self.least)) } else { value };
        (forward(self.kind, value) - self.least) / (self.most - self.least)
    }

    /// Round numbers along the axis, about `count`, with their labels.
    #[must_use]
    pub fn ticks(&self, count: usize) -> Vec<(f64, String)> {
        if self.kind == ScaleKind::Log && self.most - self.least < FEW_DECADES {
            return self.ticks_within_decades();
        }
        let step = round_step((self.most - self.least) / count.max(1) as f64);
        let step = if self.kind == ScaleKind::Log { step.max(1.0).round() } else { step };
        let first = (self.least / step).ceil() as i64;
        let last = (self.most / step).floor() as i64;
        (first..=last)
            .map(|i| {
                let at = i as f64 * step;
                match self.kind {
                    ScaleKind::Linear => (at, label(at, step)),
                    ScaleKind::Log => (10f64.powf(at), power_label(at)),
                }
            })
            .collect()
    }
}

impl Scale {
    /// 1, 2 and 5 in each decade, where whole decades alone would be too few.
    fn ticks_within_decades(&self) -> Vec<(f64, String)> {
        let decades = self.least.floor() as i32..=self.most.floor() as i32;
        let values = decades.flat_map(|d| [1.0, 2.0, 5.0].map(|digit| (d, digit)));
        values
            .map(|(d, digit)| (d, digit, digit * 10f64.powi(d)))
            .filter(|(_, _, value)| (self.least..=self.most).contains(&value.log10()))
            .map(|(d, digit, value)| {
                let small = (-3..=3).contains(&d);
                let label = match (small, d < 0) {
                    (true, true) => format!("{value:.*}", d.unsigned_abs() as usize),
                    (true, false) => format!("{value:.0}"),
                    _ => format!("{digit:.0}e{d}"),
                };
                (value, label)
            })
            .collect()
    }
}

fn forward(kind: ScaleKind, value: f64) -> f64 {
    match kind {
        ScaleKind::Linear => value,
        ScaleKind::Log => value.max(LOG_FLOOR).log10(),
    }
}

/// The nearest of 1, 2, 2.5, 5 times a power of ten at or above `raw`.
fn round_step(raw: f64) -> f64 {
    let power = 10f64.powf(raw.log10().floor());
    let digit = raw / power;
    let round = [1.0, 2.0, 2.5, 5.0].into_iter().find(|&d| digit <= d + 1e-9).unwrap_or(10.0);
    round * power
}

fn label(at: f64, step: f64) -> String {
    let digits = (0..6).find(|&d| {
        let scaled = step * 10f64.powi(d);
        (scaled - scaled.round()).abs() < 1e-6
    });
    let text = format!("{at:.*}", digits.unwrap_or(6) as usize);
    if text.trim_start_matches('-').trim_matches(['0', '.']).is_empty() { "0".into() } else { text }
}

fn power_label(exponent: f64) -> String {
    if (-3.0..=3.0).contains(&exponent) {
        let value = 10f64.powf(exponent);
        if exponent < 0.0 {
            format!("{value:.*}", -exponent as usize)
        } else {
            format!("{value:.0}")
        }
    } else {
        format!("1e{exponent:.0}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_inside_and_evenly_spaced() {
        let scale = Scale::exactly(0.0, 17.46);
        let ticks = scale.ticks(6);
        let labels: Vec<&str> = ticks.iter().map(|t| t.1.as_str()).collect();
        assert_eq!(labels, ["0", "5", "10", "15"]);
        assert!((scale.part(17.46 / 2.0) - 0.5).abs() < 1e-12);
    }

    #[test]
    fn a_log_axis_puts_equal_ratios_at_equal_distances() {
        let scale = Scale::around(ScaleKind::Log, [0.1, 1000.0].into_iter());
        let steps = [0.1, 1.0, 10.0, 100.0].map(|v| scale.part(v));
        assert!((steps[1] - steps[0] - (steps[3] - steps[2])).abs() < 1e-12);
        assert!(scale.ticks(5).iter().any(|t| t.1 == "0.1"));
        let short = Scale::around(ScaleKind::Log, [0.03, 0.6].into_iter());
        let labels: Vec<String> = short.ticks(5).into_iter().map(|t| t.1).collect();
        assert_eq!(labels, ["0.05", "0.1", "0.2", "0.5"]);
    }

    #[test]
    fn nothing_to_show_still_makes_an_axis() {
        let scale = Scale::around(ScaleKind::Linear, [f64::NAN].into_iter());
        assert!(scale.part(0.5).is_finite());
        let flat = Scale::around(ScaleKind::Linear, [2.0, 2.0].into_iter());
        assert!((flat.part(2.0) - 0.5).abs() < 1e-12);
    }
}
