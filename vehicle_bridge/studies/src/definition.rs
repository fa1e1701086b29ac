//! What a study runs, as data: cells, settings, and what the paper reports of them.

use anyhow::{Context as _, Result};
use controller::Config;
use serde::{Deserialize, Serialize};
use toml::Table;

use hosting::settings::{Layers, SettingOrigin};
use racing::words::model_word;

/// A study as its file describes it.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Definition {
    /// Heading.
    pub title: String,
    /// What is simulated, in a sentence.
    pub lead: String,
    /// Regression modes to compare.
    pub regressions: Vec<String>,
    /// Costs of the control rate.
    pub control_rate_costs: Vec<f64>,
    /// Bandwidths.
    pub bandwidths: Vec<f64>,
    /// Grip of the nominal model.
    pub nominal_mu: f64,
    /// What differs in the plant, as on the command line.
    pub plant: Vec<String>,
    /// Whether the model's error is taken along the whole plan and not at its beginning only.
    #[serde(default)]
    pub model_error_along_plan: bool,
    /// Settings of all cells.
    config: Table,
    /// Settings of some cells.
    #[serde(default, rename = "override")]
    overrides: Vec<Override>,
    /// What the paper reports.
    #[serde(default)]
    paper: Vec<Paper>,
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
struct Override {
    when: Condition,
    config: Table,
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
struct Condition {
    regression: Option<String>,
    control_rate_cost: Option<f64>,
    bandwidth: Option<f64>,
}

/// A cell of a table in the paper.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Paper {
    regression: String,
    control_rate_cost: Option<f64>,
    bandwidth: Option<f64>,
    /// Lap time of iteration 20 \[s\].
    pub lap_time_s: Option<f64>,
    /// Iteration of failure, on average.
    pub failed_in: Option<f64>,
    /// Runs that failed, of ten.
    pub failed_runs: Option<u32>,
}

/// The studies of the paper.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StudyName {
    /// Table I: cost of the control rate.
    Crc,
    /// Bandwidth of the regression's kernel.
    Bandwidth,
    /// Table II: the tenth-scale car, emulated.
    Hardware,
}

impl StudyName {
    /// The name as on the command line.
    #[must_use]
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Crc => "crc",
            Self::Bandwidth => "bandwidth",
            Self::Hardware => "hardware",
        }
    }
}

/// One cell: what its runs have in common apart from the seed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Cell {
    /// Regression mode.
    pub regression: String,
    /// Nominal model.
    pub nominal: String,
    /// Cost of the control rate.
    pub control_rate_cost: f64,
    /// Bandwidth.
    pub bandwidth: f64,
}

impl Definition {
    /// The study of this name.
    ///
    /// # Errors
    /// If its file is wrong, which a test rules out.
    pub fn of(name: StudyName) -> Result<Self> {
        let text = match name {
            StudyName::Crc => include_str!("crc.toml"),
            StudyName::Bandwidth => include_str!("bandwidth.toml"),
            StudyName::Hardware => include_str!("hardware.toml"),
        };
        toml::from_str(text).with_context(|| format!("study {}", name.as_str()))
    }

    /// Every cell with its settings, `set` laid over all of them.
    ///
    /// # Errors
    /// If a setting is not allowed.
    pub fn cells(&self, set: &[String]) -> Result<Vec<(Cell, Config)>> {
        let mut cells = Vec::new();
        for &bandwidth in &self.bandwidths {
            for &cost in &self.control_rate_costs {
                for regression in &self.regressions {
                    cells.push(self.cell(regression, cost, bandwidth, set)?);
                }
            }
        }
        Ok(cells)
    }

    fn cell(
        &self,
        regression: &str,
        control_rate_cost: f64,
        bandwidth: f64,
        set: &[String],
    ) -> Result<(Cell, Config)> {
        let mut layers = Layers::default();
        let origin = || SettingOrigin::File(format!("study {}", self.title));
        layers.text(&toml::to_string(&self.config)?, origin())?;
        for part in &self.overrides {
            if part.when.holds(regression, control_rate_cost, bandwidth) {
                layers.text(&toml::to_string(&part.config)?, origin())?;
            }
        }
        layers.insert("regression", "mode", regression);
        layers.insert("regression", "bandwidth", bandwidth);
        layers.insert("cost", "control_rate", control_rate_cost);
        layers.set_each(set)?;
        let config = layers.build()?;
        let nominal = model_word(config.nominal.model);
        let cell = Cell {
            regression: regression.to_owned(),
            nominal: nominal.to_owned(),
            control_rate_cost,
            bandwidth,
        };
        Ok((cell, config))
    }

    /// What the paper reports of a cell.
    #[must_use]
    pub fn paper(&self, cell: &Cell) -> Option<&Paper> {
        self.paper.iter().find(|paper| {
            Condition {
                regression: Some(paper.regression.clone()),
                control_rate_cost: paper.control_rate_cost,
                bandwidth: paper.bandwidth,
            }
            .holds(&cell.regression, cell.control_rate_cost, cell.bandwidth)
        })
    }
}

impl Condition {
    fn holds(&self, regression: &str, control_rate_cost: f64, bandwidth: f64) -> bool {
        let same = |wanted: Option<f64>, value: f64| {
            wanted.is_none_or(|w| (w - value).abs() <= 1e-12 * value.abs())
        };
        self.regression.as_deref().is_none_or(|r| r == regression)
            && same(self.control_rate_cost, control_rate_cost)
            && same(self.bandwidth, bandwidth)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cells(name: StudyName) -> Vec<(Cell, Config)> {
        Definition::of(name).unwrap().cells(&[]).unwrap()
    }

    #[test]
    fn every_study_has_the_cells_of_the_paper() {
        assert_eq!(cells(StudyName::Crc).len(), 10);
        assert_eq!(cells(StudyName::Bandwidth).len(), 8);
        assert_eq!(cells(StudyName::Hardware).len(), 4);
        assert!(cells(StudyName::Bandwidth).iter().all(|c| c.0.nominal == "kinematic"));
    }

    #[test]
    fn a_cell_gets_what_its_name_says() {
        for (cell, config) in cells(StudyName::Crc) {
            assert!((config.cost.control_rate - cell.control_rate_cost).abs() < 1e-15);
            assert!((config.regression.bandwidth - cell.bandwidth).abs() < 1e-15);
        }
    }

    #[test]
    fn every_number_of_the_paper_belongs_to_one_cell() {
        for name in [StudyName::Crc, StudyName::Hardware] {
            let study = Definition::of(name).unwrap();
            let cells = study.cells(&[]).unwrap();
            let known = cells.iter().filter(|(cell, _)| study.paper(cell).is_some()).count();
            assert_eq!((known, study.paper.len()), (cells.len(), cells.len()));
        }
    }
}
