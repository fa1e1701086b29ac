//! What can be wrong in each kind of file.

use controller::{Config, ConfigError};
use vehicle_model::params::ParamProblem;
use vehicle_model::{CarParams, ModelError, Track, TrackError};

use super::source::{Fault, Source};
use super::{Finding, Kind};

/// What a file is, told from its content: it may be too damaged to be parsed.
pub(super) fn recognise(file: &str, text: &str) -> Kind {
    let keys = || {
        let lines = text.lines().map(str::trim_start).filter(|line| !line.starts_with('#'));
        lines.map(|line| {
            line.split(['=', ' ', ']', '.']).next().unwrap_or("").trim_matches(['[', '"'])
        })
    };
    let has = |wanted: &[&str]| keys().any(|key| wanted.contains(&key));
    if has(&["segment", "width_left_m", "width_right_m"]) {
        Kind::Track
    } else if has(&["mass_kg", "inertia_z_kgm2", "tyre_front", "tyre_rear"]) {
        Kind::Car
    } else if is_toml(text) || file.ends_with(".toml") {
        Kind::Configuration
    } else {
        Kind::Track
    }
}

/// Problems of a configuration.
pub(super) fn configuration(text: &str) -> Vec<Finding> {
    let mut source = Source::new(text);
    let parse = |text: &str| toml::from_str::<Config>(text).map(|_| ());
    let mut findings = Vec::new();
    if !source.read(&mut findings, parse) {
        return findings;
    }
    // What is left is well-formed: now the ranges, over the preset it names.
    let problems = match Config::from_toml(source.text()) {
        Err(ConfigError::Values(problems)) => problems,
        Err(error) => {
            findings.push(Finding::of(error.to_string()));
            return findings;
        }
        Ok(_) => Vec::new(),
    };
    findings.extend(problems.into_iter().map(|problem| {
        let key = problem.key.split(' ').next().unwrap_or_default();
        let line = source.line_of(key);
        Finding { line, column: None, message: format!("{}: {}", problem.key, problem.message) }
    }));
    findings
}

/// Problems of a car file.
pub(super) fn car(text: &str) -> Vec<Finding> {
    let mut source = Source::new(text);
    let mut findings = Vec::new();
    let parse = |text: &str| match CarParams::from_toml(text) {
        Err(ModelError::CarSyntax(error)) => Err(error),
        _ => Ok(()),
    };
    if source.read(&mut findings, parse)
        && let Err(ModelError::CarInvalid(problems)) = CarParams::from_toml(source.text())
    {
        findings.extend(problems.into_iter().filter_map(|mut problem: ParamProblem| {
            // A missing key was reported as such; the number put in its place does not count.
            let line = problem.line.take().map(|line| source.original_line(line));
            let line = match line {
                Some(None) => return None,
                Some(line) => line,
                None => None,
            };
            Some(Finding { line, column: None, message: problem.to_string() })
        }));
    }
    findings
}

/// Problems of a track file.
pub(super) fn track(file: &str, text: &str) -> Vec<Finding> {
    let mut source = Source::new(text);
    let mut findings = Vec::new();
    if is_toml(text) {
        // Unreadable entries come one at a time; geometry comes last and all at once.
        let parse = |text: &str| match Track::check(file, text).first() {
            Some(TrackError::Syntax { line, column, found, expected })
                if expected == WHOLE_TRACK =>
            {
                Err(Fault { span: span_of(text, *line, *column), message: found.clone() })
            }
            _ => Ok(()),
        };
        if !source.read(&mut findings, parse) {
            return findings;
        }
    }
    let readable = findings.is_empty();
    for error in Track::check(file, source.text()) {
        match error {
            TrackError::Syntax { line, column, found, expected } if readable => {
                let message = format!("{found}; expected {expected}");
                findings.push(Finding { line: Some(line), column: Some(column), message });
            }
            // Where an entry is missing the path cannot close: only the numbers count.
            TrackError::Value { .. } => findings.push(Finding::of(error.to_string())),
            _ if readable => findings.push(Finding::of(error.to_string())),
            _ => {}
        }
    }
    findings
}

/// What the reader of segments says it expected when it cannot read the text at all.
const WHOLE_TRACK: &str = "a track of segments";

/// From a place to the end of its line.
fn span_of(text: &str, line: usize, column: usize) -> Option<std::ops::Range<usize>> {
    let start: usize = text.split_inclusive('\n').take(line - 1).map(str::len).sum();
    let rest = text[start..].lines().next()?;
    let skip: usize = rest.chars().take(column - 1).map(char::len_utf8).sum();
    Some(start + skip..start + rest.trim_end().len().max(skip))
}

fn is_toml(text: &str) -> bool {
    let mut lines = text.lines().map(str::trim_start);
    lines.any(|line| !line.starts_with('#') && (line.starts_with('[') || line.contains('=')))
}
