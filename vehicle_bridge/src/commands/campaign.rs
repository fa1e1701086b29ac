//! `lmpc study FILE` and `lmpc study merge`.

use std::env;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result, bail};
use serde_json::json;

use super::Outcome;
use super::study::others;
use command_line::{CampaignArgs, MergeArgs};
use hosting::parallel::{parallel, threads};
use hosting::settings::Usage;
use studies::campaign::{
    Campaign, CampaignCase, CampaignColumns, CampaignRow, Rows, Sheet, by_axis, drive,
    merge as merge_shards, script,
};
use terminal::progress::Progress;
use terminal::{BAD, GOOD, Talk, WARN, paint, result};

/// Runs of a shard, unless the number of shards is asked for.
const RUNS_OF_A_SHARD: usize = 50;
/// Most shards of an array, unless more are asked for.
const MOST_SHARDS: usize = 1000;
/// Missing runs that are named.
const NAMED: usize = 10;

/// Runs what is missing of a campaign, or of a shard of it.
pub(super) fn run(args: &CampaignArgs, talk: Talk) -> Result<Outcome> {
    let file = args.file.as_deref().context("no file of a campaign")?;
    let name = file.display().to_string();
    if !file.exists() && !name.contains(['.', '/', '\\']) {
        let expected = "expected a file, crc, bandwidth, hardware, tracks or merge";
        bail!(Usage(format!("no study `{name}` and no file of that name; {expected}")));
    }
    let campaign = Campaign::load(file)?;
    let stem = file.file_stem().unwrap_or_default().to_string_lossy();
    let root = args.out.clone().unwrap_or_else(|| PathBuf::from(format!("out/study-{stem}")));
    if args.slurm {
        return slurm(args, file, &root, campaign.cases.len());
    }
    let own = |case: &&CampaignCase| args.shard.is_none_or(|shard| shard.has(case.number));
    let cases: Vec<&CampaignCase> = campaign.cases.iter().filter(own).collect();
    if args.list {
        result(campaign.list(&cases)?.trim_end())?;
        return Ok(Outcome::Done);
    }
    let out = args.shard.map_or(root.clone(), |shard| shard.folder(&root));
    let mut rows = Rows::open(&out, &campaign, &cases, args.fresh)?;
    let done = rows.done();
    let missing: Vec<&CampaignCase> =
        cases.iter().copied().filter(|case| !done.contains(&case.number)).collect();
    let part = args.shard.map_or(String::new(), |s| format!(" of shard {}/{}", s.part, s.of));
    talk.say(&format!(
        "{}: {} runs{part}, {} kept from {}{}",
        campaign.title,
        cases.len(),
        done.len(),
        out.display(),
        others(rows.others.len())
    ));
    race(&campaign, &missing, args, &mut rows, talk)?;
    rows.sort()?;
    let columns = rows.columns().clone();
    conclude(&Sheet::of(&campaign), &columns, &rows.rows, &out, &[], args.json)
}

/// Drives the cases; failures are shown as they come.
fn race(
    campaign: &Campaign,
    cases: &[&CampaignCase],
    args: &CampaignArgs,
    rows: &mut Rows,
    talk: Talk,
) -> Result<()> {
    let columns = rows.columns().clone();
    let bad = rows.rows.iter().filter(|row| complaint(&columns, row).is_some()).count();
    let all = cases.len() + rows.rows.len();
    let mut progress = Progress::new((all, rows.rows.len(), bad), talk);
    let ran = parallel(
        cases,
        threads(args.jobs),
        |case| drive(campaign, &columns, case),
        |i, row: CampaignRow| -> Result<()> {
            let complaint = complaint(&columns, &row);
            progress.done(&cases[i].title(&campaign.axes), complaint.as_deref());
            rows.add(row)
        },
    );
    progress.end();
    ran
}

/// What is wrong with a run.
fn complaint(columns: &CampaignColumns, row: &CampaignRow) -> Option<String> {
    let limits = row.get(columns, "limits");
    if !row.get(columns, "failure").is_empty() {
        return Some(row.get(columns, "fail_message").to_owned());
    }
    let value = |name: &str| format!("{name} {}", row.get(columns, name));
    let values: Vec<String> = limits.split_whitespace().map(value).collect();
    (!values.is_empty()).then(|| format!("beyond its limit: {}", values.join(", ")))
}

/// Prints the script of a Slurm array.
fn slurm(args: &CampaignArgs, file: &Path, out: &Path, runs: usize) -> Result<Outcome> {
    let usual = runs.div_ceil(RUNS_OF_A_SHARD).min(MOST_SHARDS);
    let shards = args.shards.map_or(usual, |shards| shards as usize).min(runs);
    let program = env::current_exe().context("cannot tell where lmpc is")?;
    let here = env::current_dir().context("cannot tell which folder this is")?;
    let text = script(&program, &here.join(file), &here.join(out), shards, args.jobs.unwrap_or(1));
    result(text.trim_end())?;
    Ok(Outcome::Done)
}

/// Merges shards.
pub(super) fn merge(args: &MergeArgs) -> Result<Outcome> {
    let merged = merge_shards(&args.folders, &args.out)?;
    conclude(&merged.sheet, &merged.columns, &merged.rows, &args.out, &merged.missing, args.json)
}

/// Says what came of the runs, and how the program ends.
fn conclude(
    sheet: &Sheet,
    columns: &CampaignColumns,
    rows: &[CampaignRow],
    out: &Path,
    missing: &[usize],
    as_json: bool,
) -> Result<Outcome> {
    let count = |name: &str| rows.iter().filter(|row| !row.get(columns, name).is_empty()).count();
    let (failed, beyond) = (count("failure"), count("limits"));
    let table = out.join("runs.csv");
    if as_json {
        let all = json!({
            "title": sheet.title,
            "runs": rows.len(),
            "failed": failed,
            "failed_allowed": sheet.failed_runs,
            "beyond_limits": beyond,
            "missing": missing,
            "table": table.display().to_string(),
        });
        terminal::json(&all)?;
    } else {
        result(&by_axis(&sheet.axes, columns, rows))?;
        let allowed = match sheet.failed_runs {
            0 => String::new(),
            count => format!(" ({count} may)"),
        };
        let text = format!("{failed} of {} runs failed{allowed}", rows.len());
        result(&paint(if failed <= sheet.failed_runs { GOOD } else { BAD }, &text))?;
        if beyond > 0 {
            result(&paint(BAD, &format!("{beyond} runs are beyond a limit")))?;
        }
        if !missing.is_empty() {
            let named: Vec<String> = missing.iter().take(NAMED).map(ToString::to_string).collect();
            let more = if missing.len() > NAMED { ", ..." } else { "" };
            let text = format!(
                "{} of {} runs are missing: {}{more}",
                missing.len(),
                sheet.runs,
                named.join(", ")
            );
            result(&paint(WARN, &text))?;
        }
        result(&format!("runs: {}", table.display()))?;
    }
    Ok(match (missing.is_empty(), failed > sheet.failed_runs || beyond > 0) {
        (_, true) => Outcome::Degraded,
        (false, false) => Outcome::Problems,
        (true, false) => Outcome::Done,
    })
}
