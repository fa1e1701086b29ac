//! `lmpc check`.

use anyhow::Result;

use super::Outcome;
use crate::check::check_file;
use crate::cli::CheckArgs;
use crate::console::{BAD, GOOD, SOFT, paint, result};

/// Checks every file and prints what was found.
pub(super) fn run(args: &CheckArgs) -> Result<Outcome> {
    let checked: Vec<_> = args.files.iter().map(|file| check_file(file)).collect();
    let bad = checked.iter().any(|c| !c.problems.is_empty());
    if args.json {
        result(&serde_json::to_string_pretty(&checked)?)?;
    } else {
        for file in &checked {
            let (name, kind) = (&file.file, file.kind);
            match file.problems.len() {
                0 => result(&format!("{name}: {kind}, {}", paint(GOOD, "no problems")))?,
                1 => result(&format!("{name}: {kind}, {}", paint(BAD, "1 problem")))?,
                n => result(&format!("{name}: {kind}, {}", paint(BAD, &format!("{n} problems"))))?,
            }
            for fact in &file.facts {
                result(&paint(SOFT, &format!("  {fact}")))?;
            }
            for problem in &file.problems {
                result(&format!("  {problem}"))?;
            }
        }
    }
    Ok(if bad { Outcome::Problems } else { Outcome::Done })
}
