//! Given figures: those of the paper, and what a campaign shows without further wishes.

use anyhow::{Result, bail};

use super::figure::Figure;
use super::groups::MOST;
use super::samples::{DRIVING, FAILED, LAP, LAP_TIME};
use super::table::{RunTable, number};
use crate::definition::{Cell, Definition, StudyName};

/// A set of figures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Template {
    /// Those to table I of the paper: cost of the control rate.
    Crc,
    /// Those over the bandwidth of the regression.
    Bandwidth,
}

/// Names of a column in campaigns and in the studies that ship.
const COST: [&str; 2] = ["config.cost.control_rate", "control_rate_cost"];
const BANDWIDTH: [&str; 2] = ["config.regression.bandwidth", "bandwidth"];
const MODE: [&str; 2] = ["config.regression.mode", "regression"];
/// The last lap; the best one where a study drove too few laps to have the paper's iteration 20.
const LAST_LAP: [&str; 3] = ["last_lap_s", "ilt20_s", "best_lap_s"];
const MODEL_ERROR: [&str; 1] = ["model_error_median_median"];

impl Template {
    /// Its figures of a table; those whose columns the table does not have are left out.
    ///
    /// # Errors
    /// If the table has not the axes of the template.
    pub fn figures(self, table: &RunTable) -> Result<Vec<Figure>> {
        let (names, word) = match self {
            Self::Crc => (COST, "crc"),
            Self::Bandwidth => (BANDWIDTH, "bandwidth"),
        };
        let (Some(x), Some(mode)) = (any(table, &names), any(table, &MODE)) else {
            bail!(
                "the template {word} needs a column {} and a column {}: run the campaign \
                 examples/studies/{word}.toml, or `lmpc study {word}`",
                names.join(" or "),
                MODE.join(" or ")
            );
        };
        let over = |x: &str, y: &str, title: &str| Figure {
            title: title.to_owned(),
            by: Some(mode.to_owned()),
            ..Figure::new(x, y)
        };
        let mut figures = Vec::new();
        if let Some(last) = measured(table, &LAST_LAP) {
            let best = last == "best_lap_s";
            let title = if best { "Best lap" } else { "Lap time of the last iteration" };
            let mut figure = over(x, last, title);
            figure.known = if self == Self::Crc { of_the_paper()? } else { Vec::new() };
            figures.push(figure);
        }
        figures.push(over(x, FAILED, "Runs that failed"));
        if let Some(error) = measured(table, &MODEL_ERROR) {
            figures.push(over(x, error, "Error of the learned model, median of each run"));
        }
        if table.has("lap_times_s") {
            for (y, title) in [(LAP_TIME, "Lap times"), (DRIVING, "Runs still on the track")] {
                let mut figure = over(LAP, y, title);
                figure.by = Some(x.to_owned());
                figure.across = Some(mode.to_owned());
                figures.push(figure);
            }
        }
        Ok(figures)
    }
}

fn any<'a>(table: &RunTable, names: &[&'a str]) -> Option<&'a str> {
    names.iter().copied().find(|name| table.has(name))
}

/// The first of the columns in which a run that did not fail has a number.
fn measured<'a>(table: &RunTable, names: &[&'a str]) -> Option<&'a str> {
    let failed = table.failed();
    let any = |name: &&&str| {
        let column = table.column(name).unwrap_or_default();
        column.iter().zip(&failed).any(|(text, failed)| !failed && number(text).is_some())
    };
    names.iter().find(any).copied()
}

/// The name of a curve and its points.
type Curve = (String, Vec<(f64, f64)>);

/// Table I: lap times of iteration 20 over the cost of the control rate, a line a mode.
fn of_the_paper() -> Result<Vec<Curve>> {
    let study = Definition::of(StudyName::Crc)?;
    let cells: Vec<Cell> = study.cells(&[])?.into_iter().map(|(cell, _)| cell).collect();
    let line = |mode: &String| {
        let own = cells.iter().filter(|cell| cell.regression == *mode);
        let points =
            own.filter_map(|cell| Some((cell.control_rate_cost, study.paper(cell)?.lap_time_s?)));
        (format!("{mode}, paper"), points.collect())
    };
    Ok(study.regressions.iter().map(line).collect())
}

/// The figures of a table without further wishes: the best laps and the failures along each axis that
/// varies, with lines for the next axis of few values; both in small multiples for two or more axes.
#[must_use]
pub fn usual(table: &RunTable) -> Vec<Figure> {
    let measure = measured(table, &["ratio", "best_lap_s", "last_lap_s"]);
    let axes = table.varied();
    let few = |axis: &&&str| table.values(axis).is_ok_and(|values| values.len() <= MOST);
    let mut figures = Vec::new();
    for axis in &axes {
        let by = axes.iter().filter(|other| *other != axis).find(few).map(|by| (*by).to_owned());
        for y in measure.into_iter().chain(measured(table, &["overhang_max_m"])) {
            figures.push(Figure { by: by.clone(), ..Figure::new(axis, y) });
        }
        if table.failed().contains(&true) {
            figures.push(Figure { by, ..Figure::new(axis, FAILED) });
        }
    }
    if let (Some(y), [x, across, rest @ ..]) = (measure, &axes[..]) {
        let (by, down) = (rest.iter().find(few), rest.iter().filter(few).nth(1));
        figures.push(Figure {
            across: Some((*across).to_owned()),
            by: by.map(|axis| (*axis).to_owned()),
            down: down.map(|axis| (*axis).to_owned()),
            ..Figure::new(x, y)
        });
    }
    if table.has("lap_times_s") {
        let by = axes.iter().find(few).map(|axis| (*axis).to_owned());
        figures.push(Figure { by, ..Figure::new(LAP, LAP_TIME) });
    }
    figures
}
