//! `lmpc doctor`.

use anyhow::Result;

use super::Outcome;
use command_line::DoctorArgs;
use doctor::{Level, Subjects, examine};
use terminal::{BAD, GOOD, SOFT, WARN, paint, result};

/// Examines this computer and prints what was found.
pub(super) fn run(args: &DoctorArgs) -> Result<Outcome> {
    let findings = examine(&Subjects {
        url: args.network.url(),
        logs: args.logs.clone(),
        files: args.files.clone(),
        fmus: args.fmus.clone(),
    });
    if args.json {
        terminal::json(&findings)?;
    } else {
        for finding in &findings {
            let (style, word) = match finding.level {
                Level::Ok => (GOOD, "ok  "),
                Level::Warn => (WARN, "warn"),
                Level::Fail => (BAD, "fail"),
            };
            result(&format!("{} {:18} {}", paint(style, word), finding.subject, finding.found))?;
            if !finding.fix.is_empty() {
                result(&format!(
                    "     {:18} {}",
                    "",
                    paint(SOFT, &format!("fix: {}", finding.fix))
                ))?;
            }
        }
    }
    let failed = findings.iter().any(|finding| finding.level == Level::Fail);
    Ok(if failed { Outcome::Problems } else { Outcome::Done })
}
