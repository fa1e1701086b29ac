//! A measure over the runs of a scenario.

use crate::measure::Expectation;
use crate::run::RunOutcome;

/// A measure over the runs.
#[derive(Debug, Clone, PartialEq)]
pub struct Distribution {
    /// What is measured, as in bench files.
    pub name: String,
    /// The same as people read it.
    pub words: String,
    /// Its unit, empty for a count.
    pub unit: &'static str,
    /// The limit in words.
    pub limit: String,
    /// Smallest value allowed.
    pub least: Option<f64>,
    /// Largest value allowed.
    pub most: Option<f64>,
    /// The values of the runs that measured it, in rising order.
    pub values: Vec<f64>,
    /// Runs that broke the limit, those that did not measure it among them. \[-\]
    pub broken: usize,
}

impl Distribution {
    /// Of a limit over runs.
    #[must_use]
    pub fn new(expectation: &Expectation, runs: &[RunOutcome]) -> Self {
        let measure = &expectation.measure;
        let mut values: Vec<f64> =
            runs.iter().filter_map(|run| run.values.get(measure)).filter(|v| !v.is_nan()).collect();
        values.sort_by(f64::total_cmp);
        let (words, unit) = measure.words();
        Self {
            name: measure.text(),
            words,
            unit,
            limit: expectation.limit(),
            least: expectation.least,
            most: expectation.most,
            values,
            broken: runs.iter().filter(|run| expectation.broken(&run.values).is_some()).count(),
        }
    }

    /// The value that this share of the runs does not exceed: the smallest with at least this share
    /// at or below it; none if no run measured it.
    #[must_use]
    pub fn quantile(&self, share: f64) -> Option<f64> {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "an index")]
        let index = (share * self.values.len() as f64).ceil() as usize;
        self.values.get(index.saturating_sub(1)).copied()
    }

    /// In a cell of a table.
    #[must_use]
    pub fn text(&self) -> String {
        let of = |share| self.quantile(share).map(number).unwrap_or_default();
        match (self.values.first(), self.values.last()) {
            (Some(least), Some(most)) if least == most => number(*most),
            (Some(_), Some(_)) => {
                format!("{} to {}, p50 {}, p99 {}", of(0.0), of(1.0), of(0.5), of(0.99))
            }
            _ => "never happened".to_owned(),
        }
    }
}

/// A number with three digits that count, whole numbers whole.
#[must_use]
pub fn number(value: f64) -> String {
    if value.fract() == 0.0 {
        return format!("{value}");
    }
    let magnitude = value.abs().log10().floor().clamp(-4.0, 2.0);
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to 6")]
    let decimals = (2.0 - magnitude) as usize;
    format!("{value:.decimals$}")
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "code of tests")]
    use super::*;
    use crate::measure::{Measure, MeasuredValues};

    fn run(value: Option<f64>) -> RunOutcome {
        let mut values = MeasuredValues::default();
        if let Some(value) = value {
            values.insert(Measure::LossToStopMs, value);
        }
        RunOutcome { values, ..RunOutcome::default() }
    }

    #[test]
    fn a_limit_counts_the_runs_that_broke_it_and_those_without_a_value() {
        let measure = Measure::LossToStopMs.into();
        let limit = Expectation { measure, most: Some(110.0), least: None };
        let mut runs: Vec<_> = (1..=100).map(|i| run(Some(f64::from(i)))).collect();
        let d = Distribution::new(&limit, &runs);
        assert_eq!((d.broken, d.quantile(0.5), d.quantile(0.99)), (0, Some(50.0), Some(99.0)));
        assert_eq!(d.text(), "1 to 100, p50 50, p99 99");
        assert_eq!((d.words.as_str(), d.unit), ("loss to stop", "ms"));
        runs.extend([run(Some(111.0)), run(None), run(Some(f64::NAN))]);
        let d = Distribution::new(&limit, &runs);
        assert_eq!((d.broken, d.values.len(), d.quantile(1.0).unwrap()), (3, 101, 111.0));
    }

    #[test]
    fn numbers_keep_three_digits() {
        let texts = [31.0, 1234.56, 31.26, 0.034_56, -0.1234, 0.000_001, 1e9].map(number);
        assert_eq!(texts, ["31", "1235", "31.3", "0.0346", "-0.123", "0.000001", "1000000000"]);
    }
}
