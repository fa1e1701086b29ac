//! What a campaign records of a run beside the usual columns.

use anyhow::{Result, bail, ensure};
use controller::Action;
use hosting::timing::{PHASES, StepTime, percentile};
use racing::Race;
use racing::columns::{ColumnValue, LAPS, STEPS};
use racing::record::{mean, median};
use serde::Deserialize;

/// A part of `record` as its file has it.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RecordText {
    column: String,
    #[serde(default)]
    take: Vec<TakeText>,
    /// A word whose rows are counted.
    word: Option<String>,
    #[serde(default)]
    of: Which,
}

#[derive(Debug, Clone, Deserialize)]
#[serde(untagged)]
enum TakeText {
    Quantile(f64),
    Word(String),
}

/// Which part of a race counts.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
enum Which {
    /// From the first learned step on.
    #[default]
    Learned,
    /// Before that.
    WarmUp,
    /// All of it.
    All,
}

/// A number of a run.
#[derive(Debug, Clone, PartialEq)]
pub struct CampaignMeasure {
    /// Name of its column.
    pub name: String,
    source: Source,
    take: Take,
    of: Which,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Source {
    /// A column of the steps.
    Step(usize),
    /// A column of the laps.
    Lap(usize),
    /// Time of a phase of the steps, or of whole steps; no two runs have the same.
    Time(Option<usize>),
}

#[derive(Debug, Clone, PartialEq)]
enum Take {
    Min,
    Max,
    Mean,
    Median,
    Sum,
    Quantile(f64),
    Count(String),
}

impl RecordText {
    /// All measures of a file.
    pub(super) fn measures(texts: &[Self]) -> Result<Vec<CampaignMeasure>> {
        let mut all: Vec<CampaignMeasure> = Vec::new();
        for text in texts {
            for measure in text.all()? {
                let new = all.iter().all(|other| other.name != measure.name);
                ensure!(new, "record: `{}` stands there twice", measure.name);
                all.push(measure);
            }
        }
        Ok(all)
    }

    fn all(&self) -> Result<Vec<CampaignMeasure>> {
        let source = source(&self.column)?;
        let of = self.of;
        let prefix = match of {
            Which::Learned => "",
            Which::WarmUp => "warm_up_",
            Which::All => "all_",
        };
        let name = |end: &str| format!("{prefix}{}_{end}", self.column);
        if let Some(word) = &self.word {
            ensure!(self.take.is_empty(), "record `{}`: `word` or `take`", self.column);
            let take = Take::Count(word.clone());
            return Ok(vec![CampaignMeasure { name: name(word), source, take, of }]);
        }
        ensure!(!self.take.is_empty(), "record `{}`: `take` or `word` is missing", self.column);
        let one = |take: &TakeText| -> Result<CampaignMeasure> {
            let (end, take) = match take {
                TakeText::Word(word) => (word.clone(), take_of(&self.column, word)?),
                TakeText::Quantile(q) if (0.0..=1.0).contains(q) => {
                    (format!("q{}", quantile_name(*q)), Take::Quantile(*q))
                }
                TakeText::Quantile(q) => {
                    bail!("record `{}`: found {q}, expected a share from 0 to 1", self.column)
                }
            };
            Ok(CampaignMeasure { name: name(&end), source, take, of })
        };
        self.take.iter().map(one).collect()
    }
}

/// The share of a quantile in percent, without the zeros of its rounding.
fn quantile_name(q: f64) -> String {
    let percent = format!("{:.6}", 100.0 * q);
    percent.trim_end_matches('0').trim_end_matches('.').replace('.', "_")
}

fn take_of(column: &str, word: &str) -> Result<Take> {
    Ok(match word {
        "min" => Take::Min,
        "max" => Take::Max,
        "mean" => Take::Mean,
        "median" => Take::Median,
        "sum" => Take::Sum,
        _ => bail!(
            "record `{column}`: found \"{word}\", expected \"min\", \"max\", \"mean\", \"median\", \
             \"sum\", or a share from 0 to 1"
        ),
    })
}

fn source(column: &str) -> Result<Source> {
    if let Some(i) = STEPS.iter().position(|known| known.name == column) {
        return Ok(Source::Step(i));
    }
    if let Some(i) = LAPS.iter().position(|known| known.name == column) {
        return Ok(Source::Lap(i));
    }
    if column == "step_us" {
        return Ok(Source::Time(None));
    }
    let phase = |(_, name): &(_, &str)| format!("{}_us", name.replace(' ', "_")) == column;
    if let Some(i) = PHASES.iter().position(phase) {
        return Ok(Source::Time(Some(i)));
    }
    bail!(
        "record: unknown column `{column}`, expected one of trajectory.csv, laps.csv or timings.csv"
    )
}

impl CampaignMeasure {
    /// Whether it needs the error of the learned model, which takes time.
    pub(super) fn of_model_error(&self) -> bool {
        match self.source {
            Source::Step(i) => STEPS[i].name.starts_with("model_error"),
            Source::Lap(i) => LAPS[i].name.starts_with("model_error"),
            Source::Time(_) => false,
        }
    }

    /// The number of a race as text; empty where it is missing.
    #[must_use]
    pub fn of_race(&self, race: &Race) -> String {
        let values = self.values(race);
        if let Take::Count(word) = &self.take {
            let same = |value: &&ColumnValue| value.to_string() == *word;
            return values.iter().filter(same).count().to_string();
        }
        let mut numbers: Vec<f64> = values.iter().filter_map(|value| value.number()).collect();
        let number = match self.take {
            Take::Min => numbers.iter().copied().fold(f64::NAN, f64::min),
            Take::Max => numbers.iter().copied().fold(f64::NAN, f64::max),
            Take::Mean => mean(&numbers),
            Take::Median => median(&mut numbers),
            Take::Sum => numbers.iter().sum(),
            Take::Quantile(q) => {
                numbers.sort_by(f64::total_cmp);
                percentile(&numbers, q)
            }
            Take::Count(_) => f64::NAN,
        };
        if number.is_finite() { number.to_string() } else { String::new() }
    }

    fn values(&self, race: &Race) -> Vec<ColumnValue> {
        let first = race.steps.iter().position(|step| step.status.action == Action::Learned);
        let first = first.unwrap_or(race.steps.len());
        let steps = match self.of {
            Which::Learned => first..race.steps.len(),
            Which::WarmUp => 0..first,
            Which::All => 0..race.steps.len(),
        };
        match self.source {
            Source::Step(i) => race.steps[steps].iter().map(STEPS[i].of).collect(),
            Source::Time(phase) => {
                let us = |time: &StepTime| 1e6 * phase.map_or(time.total, |i| time.phases[i]);
                let times = race.times.get(steps).unwrap_or_default();
                times.iter().map(|time| ColumnValue::Number(us(time))).collect()
            }
            Source::Lap(i) => {
                let counts = |lap: &&racing::record::LapRow| match self.of {
                    Which::Learned => lap.is_learning(),
                    Which::WarmUp => !lap.is_learning(),
                    Which::All => true,
                };
                race.laps.iter().filter(counts).map(LAPS[i].of).collect()
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use racing::RaceOptions;
    use std::sync::Arc;
    use vehicle_model::{CarParams, Track};

    fn measures(text: &str) -> Result<Vec<CampaignMeasure>> {
        #[derive(Deserialize)]
        struct Table {
            record: Vec<RecordText>,
        }
        RecordText::measures(&toml::from_str::<Table>(text).unwrap().record)
    }

    #[test]
    fn measures_are_those_of_the_tables_of_the_race() {
        let car = CarParams::builtin("barc").unwrap();
        let track = Arc::new(Track::builtin("l").unwrap());
        let config = controller::Config::derived(controller::Preset::Race, &car, &track);
        let mut race = Race::new(RaceOptions { laps: 2, ..RaceOptions::new(config, car, track) });
        let race = race.as_mut().unwrap();
        race.run(|_| {}).unwrap();
        let found = measures(
            "record = [{column = \"v_x_mps\", take = [\"max\", 0.995, \"mean\"]}, \
             {column = \"lap_time_s\", take = [\"min\"], of = \"warm_up\"}, \
             {column = \"action\", word = \"learned\", of = \"all\"}, \
             {column = \"clipped\", take = [\"sum\"]}, {column = \"step_us\", take = [1.0]}]",
        )
        .unwrap();
        let names: Vec<&str> = found.iter().map(|m| m.name.as_str()).collect();
        let expected = [
            "v_x_mps_max",
            "v_x_mps_q99_5",
            "v_x_mps_mean",
            "warm_up_lap_time_s_min",
            "all_action_learned",
            "clipped_sum",
            "step_us_q100",
        ];
        assert_eq!(names, expected);
        let values: Vec<f64> =
            found.iter().map(|m| m.of_race(race).parse::<f64>().unwrap()).collect();
        let learned: Vec<_> =
            race.steps.iter().skip_while(|s| s.status.action == Action::WarmUp).collect();
        let fastest = learned.iter().map(|s| s.x.v_x).fold(0.0, f64::max);
        assert!(values[0] == fastest && values[1] <= fastest && values[2] < values[1]);
        let warm_up = race.laps.iter().filter(|lap| !lap.is_learning());
        let shortest = warm_up.map(|lap| lap.result.lap_time).fold(f64::INFINITY, f64::min);
        assert_eq!(values[3], shortest);
        assert_eq!(values[4], learned.len() as f64);
        assert_eq!(values[5], learned.iter().filter(|s| s.status.clipped).count() as f64);
        assert!(values[6] > 0.0);
    }

    #[test]
    fn what_cannot_be_recorded_is_refused() {
        for (text, reason) in [
            ("{column = \"speed\", take = [\"max\"]}", "unknown column `speed`"),
            ("{column = \"v_x_mps\"}", "missing"),
            ("{column = \"v_x_mps\", take = [\"most\"]}", "\"most\""),
            ("{column = \"v_x_mps\", take = [95]}", "share"),
            ("{column = \"v_x_mps\", take = [0.5, 0.5]}", "twice"),
        ] {
            let error = format!("{:#}", measures(&format!("record = [{text}]")).unwrap_err());
            assert!(error.contains(reason), "{text}: {error}");
        }
    }
}
