//! What a computer lacks to drive a car: each finding with its fix.

mod files;
mod network;
mod system;

use std::path::PathBuf;

use serde::Serialize;

/// How good a finding is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Level {
    /// As it should be.
    Ok,
    /// It will run, less well.
    Warn,
    /// It will not run.
    Fail,
}

/// One line of the examination.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Finding {
    /// What was looked at.
    pub subject: &'static str,
    /// How good it is.
    pub level: Level,
    /// What was found.
    pub found: String,
    /// What would put it right; empty where nothing has to be.
    pub fix: String,
}

impl Finding {
    fn ok(subject: &'static str, found: impl Into<String>) -> Self {
        Self { subject, level: Level::Ok, found: found.into(), fix: String::new() }
    }

    fn warn(subject: &'static str, found: impl Into<String>, fix: impl Into<String>) -> Self {
        Self { subject, level: Level::Warn, found: found.into(), fix: fix.into() }
    }

    fn fail(subject: &'static str, found: impl Into<String>, fix: impl Into<String>) -> Self {
        Self { subject, level: Level::Fail, found: found.into(), fix: fix.into() }
    }
}

/// What is to be looked at.
#[derive(Debug, Clone, Default)]
pub struct Subjects {
    /// LCM network.
    pub url: String,
    /// Folder that logs go to.
    pub logs: PathBuf,
    /// Configuration, car, track and bench files.
    pub files: Vec<PathBuf>,
    /// Vehicle FMUs.
    pub fmus: Vec<PathBuf>,
}

/// Looks at everything, in the order in which things have to work.
#[must_use]
pub fn examine(subjects: &Subjects) -> Vec<Finding> {
    let mut findings = vec![network::route(&subjects.url), network::buffer(&subjects.url)];
    findings.extend([
        network::liblcm(),
        system::clock(),
        system::governor(),
        system::priority(),
        system::memory(),
        files::disk(&subjects.logs),
    ]);
    findings.extend(subjects.files.iter().map(|file| files::valid(file)));
    findings.extend(subjects.fmus.iter().map(|file| files::fmu(file)));
    findings
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "code of tests")]

    use super::*;

    #[test]
    fn what_cannot_work_is_named_with_its_fix() {
        let broken = std::env::temp_dir().join(format!("doctor-{}.toml", std::process::id()));
        std::fs::write(&broken, "[horizon]\nsteps = 1\n").unwrap();
        let subjects = Subjects {
            url: "udpm://10.0.0.1:7667".to_owned(),
            logs: PathBuf::from("/no/such/folder"),
            files: vec![broken.clone()],
            fmus: vec![broken.clone()],
        };
        let findings = examine(&subjects);
        std::fs::remove_file(broken).unwrap();
        let failed: Vec<_> =
            findings.iter().filter(|f| f.level == Level::Fail).map(|f| f.subject).collect();
        for subject in ["multicast route", "disk for logs", "file", "FMU"] {
            assert!(failed.contains(&subject), "{subject}: {findings:?}");
        }
        let bare = |f: &&Finding| f.level != Level::Ok && f.fix.is_empty();
        assert_eq!(findings.iter().find(bare), None);
    }
}
