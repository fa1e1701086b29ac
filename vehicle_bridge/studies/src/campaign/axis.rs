//! Axes: what varies from run to run.

use anyhow::{Context as _, Result, bail, ensure};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use serde::Deserialize;
use toml::Value;

use super::key::Key;

/// Most points of an axis.
const MOST_POINTS: u64 = 1_000_000;

/// An axis as its file has it: one key with one of the ways to give its points, or several joined.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct AxisText {
    key: Option<String>,
    values: Option<Vec<Value>>,
    range: Option<Range>,
    log_range: Option<Range>,
    random: Option<Random>,
    join: Option<Vec<AxisText>>,
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
struct Range {
    from: Value,
    to: Value,
    count: Option<u64>,
    step: Option<Value>,
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
struct Random {
    from: f64,
    to: f64,
    count: u64,
    #[serde(default)]
    seed: u64,
    /// Whether the logarithm is drawn evenly.
    #[serde(default)]
    log: bool,
    /// Whether whole numbers are drawn, both ends included.
    #[serde(default)]
    whole: bool,
}

/// An axis: keys that vary together.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Axis {
    /// Its keys.
    pub(super) keys: Vec<String>,
    /// Values of the keys at each point.
    pub(super) points: Vec<Vec<Value>>,
}

impl AxisText {
    pub(super) fn axis(&self) -> Result<Axis> {
        let Some(parts) = &self.join else {
            let key = self.key.as_deref().context("no `key` and no `join`")?;
            let values = self.points(key)?;
            let points = values.into_iter().map(|value| vec![value]).collect();
            return Ok(Axis { keys: vec![key.to_owned()], points });
        };
        let alone = self.key.is_none() && self.given() == 0;
        ensure!(alone, "an axis with `join` has its keys and values in there");
        let mut axis = Axis { keys: Vec::new(), points: Vec::new() };
        for part in parts {
            let key = part.key.as_deref().context("a joined part without `key`")?;
            ensure!(part.join.is_none(), "`join` within `join`");
            let values = part.points(key)?;
            if axis.keys.is_empty() {
                axis.points = vec![Vec::new(); values.len()];
            }
            ensure!(
                values.len() == axis.points.len(),
                "joined keys need as many values each: `{key}` has {}, `{}` has {}",
                values.len(),
                axis.keys.first().map_or("", String::as_str),
                axis.points.len()
            );
            axis.keys.push(key.to_owned());
            for (point, value) in axis.points.iter_mut().zip(values) {
                point.push(value);
            }
        }
        ensure!(!axis.keys.is_empty(), "`join` is empty");
        Ok(axis)
    }

    fn given(&self) -> usize {
        let ways = [
            self.values.is_some(),
            self.range.is_some(),
            self.log_range.is_some(),
            self.random.is_some(),
        ];
        ways.iter().filter(|given| **given).count()
    }

    fn points(&self, key: &str) -> Result<Vec<Value>> {
        Key::parse(key)?;
        let ways = "one of `values`, `range`, `log_range` and `random`";
        ensure!(self.given() == 1, "axis `{key}`: found {}, expected {ways}", self.given());
        let points = if let Some(values) = &self.values {
            values.clone()
        } else if let Some(range) = &self.range {
            range.even().with_context(|| format!("axis `{key}`, range"))?
        } else if let Some(range) = &self.log_range {
            range.logarithmic().with_context(|| format!("axis `{key}`, log_range"))?
        } else if let Some(random) = &self.random {
            random.draw().with_context(|| format!("axis `{key}`, random"))?
        } else {
            Vec::new()
        };
        ensure!(!points.is_empty(), "axis `{key}` has no values");
        Ok(points)
    }
}

fn number(value: &Value, name: &str) -> Result<f64> {
    super::key::number(value)
        .filter(|number| number.is_finite())
        .with_context(|| format!("{name}: found {value}, expected a number"))
}

impl Range {
    fn ends(&self) -> Result<(f64, f64)> {
        Ok((number(&self.from, "from")?, number(&self.to, "to")?))
    }

    fn count(&self) -> Result<u64> {
        let count = self.count.context("`count` is missing")?;
        ensure!(
            (2..=MOST_POINTS).contains(&count),
            "count: found {count}, expected 2 to {MOST_POINTS}"
        );
        Ok(count)
    }

    /// Values at even distances, both ends included; with `step` up to the last that is not beyond
    /// `to`. Whole numbers if all that is given is whole and so are they.
    fn even(&self) -> Result<Vec<Value>> {
        let (from, to) = self.ends()?;
        let at: Vec<f64> = match &self.step {
            Some(step) => {
                ensure!(self.count.is_none(), "`count` and `step`: expected one of them");
                let step = number(step, "step")?;
                let steps = (to - from) / step;
                ensure!(
                    step != 0.0 && steps >= 0.0 && steps < MOST_POINTS as f64,
                    "step {step} does not lead from {from} to {to}"
                );
                // A step that hits the end but for rounding includes it.
                let last = (steps + 1e-9).floor() as u64;
                (0..=last).map(|i| from + i as f64 * step).collect()
            }
            None => {
                let last = (self.count()? - 1) as f64;
                let inner = |i: u64| from + (to - from) * (i as f64 / last);
                (0..self.count()?).map(|i| if i as f64 == last { to } else { inner(i) }).collect()
            }
        };
        let whole = [Some(&self.from), Some(&self.to), self.step.as_ref()];
        let whole = whole.into_iter().flatten().all(Value::is_integer);
        let whole = whole && at.iter().all(|value| value.fract() == 0.0);
        let value = |v: f64| if whole { Value::Integer(v as i64) } else { Value::Float(v) };
        Ok(at.into_iter().map(value).collect())
    }

    /// Values whose quotients are equal, both ends included.
    fn logarithmic(&self) -> Result<Vec<Value>> {
        let (from, to) = self.ends()?;
        ensure!(from > 0.0 && to > 0.0, "found {from} to {to}, expected numbers above 0");
        ensure!(self.step.is_none(), "`step`: expected `count`");
        let last = (self.count()? - 1) as f64;
        let (low, high) = (libm::log(from), libm::log(to));
        let at = |i: u64| match i {
            0 => from,
            i if i as f64 == last => to,
            i => libm::exp(low + (high - low) * (i as f64 / last)),
        };
        Ok((0..self.count()?).map(|i| Value::Float(at(i))).collect())
    }
}

impl Random {
    /// Draws, the same for the same seed on every machine.
    fn draw(&self) -> Result<Vec<Value>> {
        let Self { from, to, count, log, whole, .. } = *self;
        ensure!(
            (1..=MOST_POINTS).contains(&count),
            "count: found {count}, expected 1 to {MOST_POINTS}"
        );
        ensure!(from.is_finite() && to >= from && to.is_finite(), "{from} to {to} is no interval");
        if log && from <= 0.0 {
            bail!("log: found {from} to {to}, expected numbers above 0");
        }
        let mut rng = Pcg64Mcg::seed_from_u64(self.seed);
        let mut one = || {
            let share = rng.random::<f64>();
            let (low, high) = if whole { (from.ceil(), to.floor() + 1.0) } else { (from, to) };
            let value = if log {
                let (low, high) = (libm::log(low), libm::log(high));
                libm::exp(low + (high - low) * share)
            } else {
                low + (high - low) * share
            };
            let value = value.clamp(from, to);
            if whole { Value::Integer(value.floor() as i64) } else { Value::Float(value) }
        };
        Ok((0..count).map(|_| one()).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn axis(text: &str) -> Result<Axis> {
        toml::from_str::<AxisText>(text).unwrap().axis()
    }

    fn numbers(text: &str) -> Vec<f64> {
        let axis = axis(text).unwrap();
        axis.points.iter().map(|point| super::super::key::number(&point[0]).unwrap()).collect()
    }

    #[test]
    fn ranges_have_both_ends_and_whole_numbers_stay_whole() {
        let whole = axis("key = \"config.horizon.steps\"\nrange = {from = 8, to = 13, step = 2}");
        let points: Vec<Vec<Value>> = [8, 10, 12].map(|v| vec![Value::Integer(v)]).to_vec();
        assert_eq!(whole.unwrap().points, points);
        let even = numbers("key = \"plant.mu\"\nrange = {from = 0.1, to = 0.7, step = 0.1}");
        assert_eq!((even.len(), even[0]), (7, 0.1));
        let even = numbers("key = \"plant.mu\"\nrange = {from = 1, to = 2, count = 4}");
        assert!((even[1] - 4.0 / 3.0).abs() < 1e-15 && even[3] == 2.0);
        let log = numbers("key = \"plant.mu\"\nlog_range = {from = 0.01, to = 100, count = 5}");
        for (found, expected) in log.iter().zip([0.01, 0.1, 1.0, 10.0, 100.0]) {
            assert!((found / expected - 1.0).abs() < 1e-12, "{log:?}");
        }
        assert!(log[0] == 0.01 && log[4] == 100.0);
    }

    #[test]
    fn draws_follow_their_seed_and_fill_their_interval() {
        let drawn = |seed: u64, more: &str| {
            let random = format!("from = 2, to = 50, count = 2000, seed = {seed}{more}");
            numbers(&format!("key = \"plant.mass\"\nrandom = {{{random}}}"))
        };
        let (one, two) = (drawn(1, ""), drawn(2, ""));
        assert!(one == drawn(1, "") && one != two);
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
        assert!((mean(&one) - 26.0).abs() < 1.0, "{}", mean(&one));
        let logs: Vec<f64> = drawn(1, ", log = true").iter().map(|v| v.ln()).collect();
        assert!((mean(&logs) - 0.5 * (2.0_f64.ln() + 50.0_f64.ln())).abs() < 0.05);
        let whole = drawn(1, ", whole = true");
        let count = |v: f64| whole.iter().filter(|w| **w == v).count();
        assert!(whole.iter().all(|v| v.fract() == 0.0));
        assert!(count(2.0) > 20 && count(50.0) > 20 && count(51.0) == 0 && count(1.0) == 0);
    }

    #[test]
    fn joined_keys_vary_together() {
        let text = "join = [{key = \"car\", values = [\"barc\", \"kart\"]}, \
                    {key = \"laps\", values = [3, 5]}]";
        let joined = axis(text).unwrap();
        assert_eq!(joined.keys, ["car", "laps"]);
        assert_eq!(joined.points[1], [Value::String("kart".into()), Value::Integer(5)]);
    }

    #[test]
    fn what_is_no_axis_is_refused_with_the_reason() {
        for (text, reason) in [
            ("values = [1]", "no `key`"),
            ("key = \"grip\"\nvalues = [1]", "unknown key `grip`"),
            ("key = \"laps\"", "expected one of"),
            ("key = \"laps\"\nvalues = []", "no values"),
            ("key = \"laps\"\nvalues = [1]\nrange = {from = 1, to = 2, count = 2}", "found 2"),
            ("key = \"laps\"\nrange = {from = 1, to = 2}", "`count` is missing"),
            ("key = \"laps\"\nrange = {from = 1, to = 2, step = -1}", "does not lead"),
            ("key = \"laps\"\nlog_range = {from = 0, to = 2, count = 2}", "above 0"),
            ("key = \"laps\"\nrandom = {from = 3, to = 2, count = 2}", "no interval"),
            ("join = [{key = \"laps\", values = [1]}, {key = \"car\", values = []}]", "no values"),
            (
                "join = [{key = \"laps\", values = [1]}, {key = \"car\", values = [\"a\", \"b\"]}]",
                "as many values",
            ),
        ] {
            let error = format!("{:#}", axis(text).unwrap_err());
            assert!(error.contains(reason), "{text}: {error}");
        }
    }
}
