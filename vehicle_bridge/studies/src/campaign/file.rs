//! The file of a campaign.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result, ensure};
use bounded_file::Limit;
use serde::Deserialize;
use toml::{Table, Value};

use super::axis::{Axis, AxisText};
use super::case::CampaignCase;
use super::key::{Key, flatten, same};
use super::limits::Limits;
use super::parts::Workshop;
use super::record::{CampaignMeasure, RecordText};

/// Most runs of a campaign.
const MOST_RUNS: usize = 10_000_000;

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
struct Text {
    title: Option<String>,
    #[serde(default = "barc")]
    car: String,
    #[serde(default = "l")]
    track: String,
    preset: Option<String>,
    config: Option<PathBuf>,
    laps: Option<u32>,
    nominal_mu: Option<f64>,
    body: Option<bool>,
    model_error: Option<ModelErrorText>,
    seeds: Option<Seeds>,
    #[serde(default)]
    set: Table,
    #[serde(default)]
    axis: Vec<AxisText>,
    #[serde(default)]
    when: Vec<WhenText>,
    #[serde(default)]
    record: Vec<RecordText>,
    #[serde(default)]
    limits: Table,
}

fn barc() -> String {
    "barc".to_owned()
}

fn l() -> String {
    "l".to_owned()
}

#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(rename_all = "snake_case")]
enum ModelErrorText {
    Now,
    Plan,
}

#[derive(Debug, Clone, Deserialize)]
#[serde(untagged)]
enum Seeds {
    Count(u64),
    List(Vec<u64>),
}

impl Seeds {
    fn list(&self) -> Result<Vec<u64>> {
        match self {
            Self::Count(count) => {
                ensure!(
                    *count <= MOST_RUNS as u64,
                    "seeds: found {count}, expected at most {MOST_RUNS}"
                );
                Ok((0..*count).collect())
            }
            Self::List(list) => {
                let mut known = BTreeSet::new();
                for seed in list {
                    ensure!(known.insert(seed), "seeds: {seed} stands there twice");
                }
                Ok(list.clone())
            }
        }
    }
}

/// What holds for some runs only.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
struct WhenText {
    /// Values of axes.
    is: Table,
    #[serde(default)]
    set: Table,
    #[serde(default)]
    skip: bool,
}

/// Keys with their values.
pub(super) type Assignments = Vec<(String, Value)>;

struct When {
    is: Assignments,
    set: Assignments,
    skip: bool,
}

/// A campaign.
#[derive(Debug)]
pub struct Campaign {
    /// Heading.
    pub title: String,
    /// Keys of the axes, in the order of the columns.
    pub axes: Vec<String>,
    /// What is recorded beside the usual columns.
    pub measures: Vec<CampaignMeasure>,
    /// What makes it fail.
    pub limits: Limits,
    /// Every run.
    pub cases: Vec<CampaignCase>,
}

impl Campaign {
    /// Reads a file and puts every run together. Cars, tracks and configurations that it names are
    /// looked for beside it first.
    ///
    /// # Errors
    /// If the file is wrong, or a run cannot be put together.
    pub fn load(path: &Path) -> Result<Self> {
        let text = bounded_file::text(path, Limit::SETTINGS)?;
        let stem = path.file_stem().map_or("campaign".into(), |s| s.to_string_lossy().into_owned());
        let folder = path.parent().unwrap_or(Path::new(""));
        Self::parse(&text, &stem, folder).with_context(|| path.display().to_string())
    }

    fn parse(text: &str, stem: &str, folder: &Path) -> Result<Self> {
        let text: Text = toml::from_str(text)?;
        let seeds = text.seeds.as_ref().map_or_else(|| Ok(vec![0]), Seeds::list)?;
        let axes: Vec<Axis> = text.axis.iter().map(AxisText::axis).collect::<Result<_>>()?;
        let keys: Vec<String> = axes.iter().flat_map(|axis| axis.keys.clone()).collect();
        for (i, key) in keys.iter().enumerate() {
            ensure!(!keys[..i].contains(key), "two axes vary `{key}`");
        }
        let when: Vec<When> =
            text.when.iter().map(|when| condition(when, &keys)).collect::<Result<_>>()?;
        let measures = RecordText::measures(&text.record)?;
        let mut workshop = Workshop::new(folder, text.config.as_deref(), text.body)?;
        workshop.model_error = match text.model_error {
            Some(ModelErrorText::Plan) => racing::ModelErrorAt::Plan,
            Some(ModelErrorText::Now) => racing::ModelErrorAt::Now,
            None if measures.iter().any(CampaignMeasure::of_model_error) => {
                racing::ModelErrorAt::Now
            }
            None => racing::ModelErrorAt::Never,
        };
        let cases = cases(&text.base(), &axes, &when, &seeds, &mut workshop)?;
        let title = text.title.unwrap_or_else(|| stem.to_owned());
        let campaign = Self { title, axes: keys, measures, limits: Limits::default(), cases };
        let limits = Limits::parse(&text.limits, &campaign.columns())?;
        // Last: what is wrong in the file may be why.
        ensure!(
            !text.axis.is_empty() || text.seeds.is_some(),
            "nothing varies from run to run: expected an `[[axis]]` with `key` and `values`, or \
             `seeds`; `lmpc race` drives a single run"
        );
        Ok(Self { limits, ..campaign })
    }
}

impl Text {
    /// What holds for every run.
    fn base(&self) -> Assignments {
        let word = |text: &String| Value::String(text.clone());
        let mut all = vec![("car".to_owned(), word(&self.car))];
        all.push(("track".to_owned(), word(&self.track)));
        all.extend(self.preset.iter().map(|preset| ("preset".to_owned(), word(preset))));
        all.extend(self.laps.map(|laps| ("laps".to_owned(), Value::Integer(laps.into()))));
        all.extend(self.nominal_mu.map(|mu| ("nominal_mu".to_owned(), Value::Float(mu))));
        all.extend(flatten(&self.set));
        all
    }
}

fn condition(when: &WhenText, keys: &[String]) -> Result<When> {
    let (is, set) = (flatten(&when.is), flatten(&when.set));
    for (key, _) in &is {
        ensure!(
            keys.contains(key),
            "when: `{key}` is no axis, expected one of {}",
            keys.join(", ")
        );
    }
    ensure!(when.skip == set.is_empty(), "when: expected either `set` or `skip = true`");
    for (key, _) in &set {
        Key::parse(key).context("when, set")?;
    }
    Ok(When { is, set, skip: when.skip })
}

/// Every run: the first axis varies slowest, the seeds fastest.
fn cases(
    base: &Assignments,
    axes: &[Axis],
    when: &[When],
    seeds: &[u64],
    workshop: &mut Workshop,
) -> Result<Vec<CampaignCase>> {
    let cells = axes.iter().try_fold(1_usize, |n, axis| n.checked_mul(axis.points.len()));
    let runs = cells.and_then(|cells| cells.checked_mul(seeds.len()));
    let runs = runs.filter(|runs| *runs <= MOST_RUNS);
    let runs = runs.with_context(|| format!("more than {MOST_RUNS} runs"))?;
    ensure!(runs > 0, "no runs: `seeds` is 0 or empty");
    let mut all = Vec::new();
    for cell in 0..runs / seeds.len() {
        let varied = point(axes, cell);
        let holds = |when: &&When| {
            let value = |key: &String| varied.iter().find(|(name, _)| name == key).map(|(_, v)| v);
            when.is.iter().all(|(key, is)| value(key).is_some_and(|value| same(value, is)))
        };
        let holding: Vec<&When> = when.iter().filter(holds).collect();
        if holding.iter().any(|when| when.skip) {
            continue;
        }
        let mut given = base.clone();
        given.extend(varied.iter().cloned());
        given.extend(holding.iter().flat_map(|when| when.set.clone()));
        let options = workshop.build(&given).with_context(|| {
            let texts: Vec<String> = varied.iter().map(|(k, v)| format!("{k} = {v}")).collect();
            format!("run {} ({})", all.len(), texts.join(", "))
        })?;
        CampaignCase::of_cell(&mut all, &varied, &options, seeds);
    }
    ensure!(!all.is_empty(), "no runs: all are skipped");
    Ok(all)
}

/// The values of the axes in a cell.
fn point(axes: &[Axis], mut cell: usize) -> Assignments {
    let mut parts = Vec::new();
    for axis in axes.iter().rev() {
        let values = &axis.points[cell % axis.points.len()];
        cell /= axis.points.len();
        parts.push(axis.keys.iter().cloned().zip(values.iter().cloned()));
    }
    parts.into_iter().rev().flatten().collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Definition, StudyCase, StudyName};

    fn load(name: &str) -> Campaign {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/studies");
        Campaign::load(&folder.join(format!("{name}.toml"))).unwrap()
    }

    #[test]
    fn the_papers_studies_as_files_are_the_same_runs() {
        for name in [StudyName::Crc, StudyName::Bandwidth, StudyName::Hardware] {
            let study = Definition::of(name).unwrap();
            let built_in = StudyCase::of(&study, &[], 10, 20).unwrap();
            let campaign = load(name.as_str());
            assert_eq!((&campaign.title, campaign.cases.len()), (&study.title, built_in.len()));
            for (plan, case) in built_in.iter().zip(&campaign.cases) {
                // The fingerprint is of everything that a run depends on.
                let place = case.title(&campaign.axes);
                assert_eq!((plan.seed, &plan.settings), (case.seed, &case.settings), "{place}");
            }
        }
    }

    #[test]
    fn a_file_without_axes_and_seeds_is_refused_and_one_with_seeds_is_not() {
        let parse = |text: &str| Campaign::parse(text, "s", Path::new(""));
        for text in ["", "# nothing\n", "title = \"a\"\nlaps = 3\n"] {
            let error = parse(text).unwrap_err().to_string();
            assert!(error.contains("`[[axis]]`") && error.contains("`seeds`"), "{error}");
        }
        assert_eq!(parse("seeds = 4\n").unwrap().cases.len(), 4);
        for (seeds, expected) in [
            ("99999999999", "found 99999999999, expected at most 10000000"),
            ("[1, 2, 1]", "1 stands"),
        ] {
            let error = parse(&format!("seeds = {seeds}\n")).unwrap_err().to_string();
            assert!(error.contains(expected), "{error}");
        }
        let axis = "[[axis]]\nkey = \"config.horizon.steps\"\nvalues = [10, 12]\n";
        assert_eq!(parse(axis).unwrap().cases.len(), 2);
    }

    #[test]
    fn random_draws_are_joined_row_by_row() {
        let campaign = load("monte_carlo");
        assert_eq!((campaign.cases.len(), campaign.axes.len()), (200, 3));
        let masses: Vec<f64> =
            campaign.cases.iter().map(|case| case.options.plant.car.mass).collect();
        for (mass, case) in masses.iter().zip(&campaign.cases) {
            assert_eq!(mass.to_string(), case.axes[1]);
        }
    }
}
