//! What can be wrong in each kind of file.

use std::path::Path;

use controller::{Config, ConfigError};
use vehicle_model::params::ParamProblem;
use vehicle_model::{CarParams, ModelError, Track, TrackError};

use super::source::Source;
use super::{FileKind, FileProblem};
use hil_bench::Bench;
use mapping::MapFile;
use services::map_file;
use vehicle_host::fmu::map::Map;
use vehicle_host::fmu::misfits;

/// What a file is, told from its content: it may be too damaged to be parsed.
pub(super) fn recognise(file: &str, text: &str) -> FileKind {
    let keys = || {
        let lines = text.lines().map(str::trim_start).filter(|line| !line.starts_with('#'));
        lines.map(|line| {
            line.split(['=', ' ', ']', '.']).next().unwrap_or("").trim_matches(['[', '"'])
        })
    };
    let has = |wanted: &[&str]| keys().any(|key| wanted.contains(&key));
    if has(&["scenario"]) {
        FileKind::Bench
    } else if has(&["frame"]) && has(&["input"]) {
        FileKind::VehicleMap
    } else if has(&["source", "command"]) {
        FileKind::Map
    } else if has(&["segment", "width_left_m", "width_right_m"]) {
        FileKind::Track
    } else if has(&["mass_kg", "inertia_z_kgm2", "tyre_front", "tyre_rear"]) {
        FileKind::Car
    } else if is_toml(text) || file.ends_with(".toml") {
        FileKind::Configuration
    } else {
        FileKind::Track
    }
}

/// Problems of a configuration.
pub(super) fn configuration(text: &str) -> Vec<FileProblem> {
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
            findings.push(FileProblem::of(error.to_string()));
            return findings;
        }
        Ok(_) => Vec::new(),
    };
    findings.extend(problems.into_iter().map(|problem| {
        let key = problem.key.split(' ').next().unwrap_or_default();
        let line = source.line_of(key);
        FileProblem { line, column: None, message: format!("{}: {}", problem.key, problem.message) }
    }));
    findings
}

/// Problems of a car file.
pub(super) fn car(text: &str) -> Vec<FileProblem> {
    let mut source = Source::new(text);
    let mut findings = Vec::new();
    let parse = |text: &str| match CarParams::from_toml(text) {
        Err(ModelError::CarSyntax(error)) => Err(error),
        _ => Ok(()),
    };
    if source.read(&mut findings, parse)
        && let Err(ModelError::CarInvalid(problems)) = CarParams::from_toml(source.text())
    {
        // A missing key was reported as such; what stands in its place does not count.
        let real = |p: &ParamProblem| {
            let section = !p.section.is_empty() && source.stands_in_for(p.section);
            let in_its_place = p.line.is_some_and(|line| source.original_line(line).is_none());
            !section && !in_its_place
        };
        findings.extend(problems.into_iter().filter(real).map(|mut problem| {
            let line = problem.line.take().and_then(|line| source.original_line(line));
            FileProblem { line, column: None, message: problem.to_string() }
        }));
    }
    findings
}

/// Problems of a track file.
pub(super) fn track(file: &str, text: &str) -> Vec<FileProblem> {
    let finding = |error: TrackError| match error {
        TrackError::Syntax { line, column, found, expected } => FileProblem {
            line: Some(line),
            column: Some(column),
            message: format!("{found}; expected {expected}"),
        },
        other => FileProblem::of(other.to_string()),
    };
    Track::check(file, text).into_iter().map(finding).collect()
}

/// Problems of a bench file.
pub(super) fn bench(text: &str) -> Vec<FileProblem> {
    let mut source = Source::new(text);
    let mut findings = Vec::new();
    let parse = |text: &str| toml::from_str::<Bench>(text).map(|_| ());
    if source.read(&mut findings, parse)
        && let Ok(bench) = toml::from_str::<Bench>(source.text())
    {
        findings.extend(bench.problems().into_iter().map(FileProblem::of));
    }
    findings
}

/// Problems of a map file, and of the `.lcm` files it names.
pub(super) fn map(file: &str, text: &str) -> Vec<FileProblem> {
    let mut source = Source::new(text);
    let mut findings = Vec::new();
    let parse = |text: &str| toml::from_str::<MapFile>(text).map(|_| ());
    if source.read(&mut findings, parse)
        && let Ok(parsed) = toml::from_str::<MapFile>(source.text())
        && let Err(problems) = map_file::resolve(Path::new(file), &parsed, source.text())
    {
        // What stands in for a missing key was reported as missing.
        findings.extend(problems.into_iter().filter_map(|problem| {
            let line = match problem.line {
                Some(line) => Some(source.original_line(line)?),
                None => None,
            };
            Some(FileProblem { line, column: None, message: problem.message })
        }));
    }
    findings
}

/// Problems of a vehicle FMU's map, and of the two together if it names the FMU.
pub(super) fn vehicle_map(file: &str, text: &str) -> Vec<FileProblem> {
    let mut source = Source::new(text);
    let mut findings = Vec::new();
    let parse = |text: &str| toml::from_str::<Map>(text).map(|_| ());
    if !source.read(&mut findings, parse) {
        return findings;
    }
    let Ok(map) = toml::from_str::<Map>(source.text()) else { return findings };
    let mut problems = map.problems();
    if let Some(fmu) = &map.fmu {
        let beside = Path::new(file).with_file_name(fmu);
        let fmu = if beside.exists() { beside } else { fmu.into() };
        match misfits(&map, &fmu) {
            Ok(found) => problems.extend(found),
            Err(error) => problems.push(("fmu".to_owned(), error.to_string())),
        }
    }
    problems.dedup();
    findings.extend(problems.into_iter().map(|(key, what)| {
        let line = source.line_of(&key);
        FileProblem { line, column: None, message: format!("{key}: {what}") }
    }));
    findings
}

fn is_toml(text: &str) -> bool {
    let mut lines = text.lines().map(str::trim_start);
    lines.any(|line| !line.starts_with('#') && (line.starts_with('[') || line.contains('=')))
}
