//! The tables a race writes: names carry the unit, numbers are printed so that reading them
//! gives the same bits again.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;

use super::columns::{Column, LAPS, STEPS};
use super::record::{LapRow, StepRow};
use hosting::timing::StepTime;

const TIMINGS: &str = "time_s,lap,project_us,linearize_us,regress_us,safe_set_us,solve_us,step_us";

/// Writes `laps.csv`.
///
/// # Errors
/// If the file cannot be written.
pub fn write_laps(path: &Path, laps: &[LapRow]) -> io::Result<()> {
    write_table(path, LAPS, laps)
}

/// Writes `trajectory.csv`.
///
/// # Errors
/// If the file cannot be written.
pub fn write_trajectory(path: &Path, steps: &[StepRow]) -> io::Result<()> {
    write_table(path, STEPS, steps)
}

fn write_table<T>(path: &Path, columns: &[Column<T>], rows: &[T]) -> io::Result<()> {
    let names: Vec<&str> = columns.iter().map(|column| column.name).collect();
    let mut out = create(path, &names.join(","))?;
    for row in rows {
        for (i, column) in columns.iter().enumerate() {
            let comma = if i == 0 { "" } else { "," };
            write!(out, "{comma}{}", (column.of)(row))?;
        }
        writeln!(out)?;
    }
    out.flush()
}

/// Writes `timings.csv`: apart from the others because no two runs have the same times.
///
/// # Errors
/// If the file cannot be written.
pub fn write_timings(path: &Path, steps: &[StepRow], times: &[StepTime]) -> io::Result<()> {
    let mut out = create(path, TIMINGS)?;
    for (row, time) in steps.iter().zip(times) {
        write!(out, "{},{}", row.time, row.status.lap)?;
        for phase in time.phases {
            write!(out, ",{:.1}", phase * 1e6)?;
        }
        writeln!(out, ",{:.1}", time.total * 1e6)?;
    }
    out.flush()
}

fn create(path: &Path, header: &str) -> io::Result<BufWriter<File>> {
    let mut out = BufWriter::new(File::create(path)?);
    writeln!(out, "{header}")?;
    Ok(out)
}
