//! What a figure draws of each run: its place on the axis and its value.

use anyhow::{Result, ensure};

use super::table::{RunTable, number};

/// The axis of the learned laps, which is no column.
pub(super) const LAP: &str = "lap";
/// Share of the runs that failed.
pub(super) const FAILED: &str = "failed";
/// Share of the runs that finished a lap, over [`LAP`].
pub(super) const DRIVING: &str = "driving";
/// Time of a lap, over [`LAP`].
pub(super) const LAP_TIME: &str = "lap_time_s";

/// A run, or one of its laps.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Sample<'a> {
    /// Number of the run.
    pub(super) run: usize,
    /// Place on the axis to the right.
    pub(super) x: std::borrow::Cow<'a, str>,
    /// Value; none if the run failed or has none.
    pub(super) y: Option<f64>,
    /// Whether it failed here.
    pub(super) failed: bool,
}

/// Whether values are shares, 0 or 1 for each run.
pub(super) fn is_share(y: &str) -> bool {
    y == FAILED || y == DRIVING
}

/// The samples of all runs.
pub(super) fn samples<'a>(table: &'a RunTable, x: &str, y: &str) -> Result<Vec<Sample<'a>>> {
    if x == LAP && !table.has(LAP) {
        return over_laps(table, y);
    }
    let (places, failed) = (table.column(x)?, table.failed());
    let values: Vec<Option<f64>> = if y == FAILED {
        failed.iter().map(|failed| Some(f64::from(u8::from(*failed)))).collect()
    } else {
        let fields = table.column(y)?;
        let values: Vec<Option<f64>> = fields.iter().map(|text| number(text)).collect();
        ensure!(values.iter().any(Option::is_some), "column `{y}` has no number to draw");
        values.iter().zip(&failed).map(|(value, failed)| value.filter(|_| !failed)).collect()
    };
    let all = places.into_iter().zip(values).zip(failed).enumerate();
    let sample = |(run, ((x, y), failed)): (usize, ((&'a str, Option<f64>), bool))| Sample {
        run,
        x: x.into(),
        y,
        failed,
    };
    Ok(all.map(sample).collect())
}

/// The learned laps of all runs, also of those that failed later.
fn over_laps<'a>(table: &'a RunTable, y: &str) -> Result<Vec<Sample<'a>>> {
    ensure!(
        y == LAP_TIME || y == DRIVING,
        "over `{LAP}` stand `{LAP_TIME}` and `{DRIVING}`; found `{y}`"
    );
    let (times, failed) = (table.column("lap_times_s")?, table.failed());
    let fail_laps = table.column("fail_lap").unwrap_or_default();
    let most = times.iter().map(|text| text.split(' ').count()).max().unwrap_or(0);
    let mut all = Vec::new();
    for (run, text) in times.iter().enumerate() {
        let laps: Vec<Option<f64>> = text.split_whitespace().map(number).collect();
        let failed = failed.get(run).copied().unwrap_or(false);
        if y == DRIVING {
            // A campaign may drive runs of different lengths: one that did not fail ends with its last.
            let last = if failed { most } else { laps.len() };
            for lap in 1..=last {
                let drives = f64::from(u8::from(lap <= laps.len()));
                all.push(Sample { run, x: lap.to_string().into(), y: Some(drives), failed: false });
            }
            continue;
        }
        for (lap, time) in laps.iter().enumerate() {
            all.push(Sample { run, x: (lap + 1).to_string().into(), y: *time, failed: false });
        }
        if failed {
            let lap = fail_laps.get(run).and_then(|text| number(text));
            let x = lap.map_or(laps.len() + 1, |lap| lap.max(0.0) as usize);
            all.push(Sample { run, x: x.to_string().into(), y: None, failed: true });
        }
    }
    Ok(all)
}

#[cfg(test)]
mod tests {
    use super::*;

    const TABLE: &str = "run,mu,seed,failure,best_lap_s,fail_lap,lap_times_s\n\
                         0,1,0,,4.5,,6 5 4.5\n1,2,0,spin,5,3,6.5 5\n";

    #[test]
    fn failed_runs_have_no_value_and_count_as_failures() {
        let table = RunTable::parse(TABLE).unwrap();
        let found = samples(&table, "mu", "best_lap_s").unwrap();
        assert_eq!((found[0].y, found[1].y, found[1].failed), (Some(4.5), None, true));
        let shares = samples(&table, "mu", FAILED).unwrap();
        assert_eq!((shares[0].y, shares[1].y), (Some(0.0), Some(1.0)));
    }

    #[test]
    fn laps_stand_one_by_one_up_to_the_failure() {
        let table = RunTable::parse(TABLE).unwrap();
        let found = samples(&table, LAP, LAP_TIME).unwrap();
        let of = |run: usize| found.iter().filter(move |s| s.run == run);
        assert_eq!((of(0).count(), of(1).count()), (3, 3));
        assert!(of(1).next_back().is_some_and(|s| s.failed && s.x == "3"));
        let driving = samples(&table, LAP, DRIVING).unwrap();
        let shares: Vec<f64> = driving.iter().filter(|s| s.x == "3").filter_map(|s| s.y).collect();
        assert_eq!(shares, [1.0, 0.0]);
        assert!(samples(&table, LAP, "best_lap_s").is_err());
    }
}
