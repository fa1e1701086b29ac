//! `lmpc study report`.

use std::fs;
use std::path::PathBuf;

use anyhow::{Context as _, Result};

use super::Outcome;
use command_line::{ReportArgs, TemplateName};
use studies::picture::{Figure, RunTable, Template, page, usual};
use terminal::result;

/// Draws a table of runs.
pub(super) fn run(args: &ReportArgs) -> Result<Outcome> {
    let table = RunTable::read(&args.runs)?;
    let figures = match (&args.x, args.template) {
        (Some(x), _) => args.y.iter().map(|y| figure(args, x, y)).collect(),
        (None, Some(TemplateName::Crc)) => Template::Crc.figures(&table)?,
        (None, Some(TemplateName::Bandwidth)) => Template::Bandwidth.figures(&table)?,
        (None, None) => usual(&table),
    };
    let page = page(&table, &figures)?;
    let out = args.out.clone().unwrap_or_else(|| beside(args));
    fs::write(&out, page).with_context(|| format!("cannot write {}", out.display()))?;
    result(&format!("{} figures of {} runs: {}", figures.len(), table.runs(), out.display()))?;
    Ok(Outcome::Done)
}

fn figure(args: &ReportArgs, x: &str, y: &str) -> Figure {
    let [by, across, down] = [&args.by, &args.across, &args.down].map(Clone::clone);
    Figure { by, across, down, ..Figure::new(x, y) }
}

/// `report.html` in the folder of the table.
fn beside(args: &ReportArgs) -> PathBuf {
    if args.runs.is_dir() {
        args.runs.join("report.html")
    } else {
        args.runs.with_file_name("report.html")
    }
}
