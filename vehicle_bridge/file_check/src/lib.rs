//! Finds every problem of a configuration, car, track or map file, not only the first.

mod car;
mod kinds;
mod source;

use std::fmt;
use std::path::Path;

use bounded_file::Limit;
use serde::Serialize;
use vehicle_model::CarParams;

pub use car::facts;

/// Kind of a file, recognised from its content.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum FileKind {
    /// Configuration of the controller.
    Configuration,
    /// Parameters of a car.
    Car,
    /// A track.
    Track,
    /// Scenarios of a bench.
    Bench,
    /// The map between a car's messages and ours.
    Map,
    /// Map of a vehicle FMU.
    VehicleMap,
    /// Not known: it could not be read.
    Unknown,
}

impl fmt::Display for FileKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Configuration => "configuration",
            Self::Car => "car",
            Self::Track => "track",
            Self::Bench => "bench",
            Self::Map => "map",
            Self::VehicleMap => "vehicle map",
            Self::Unknown => "file",
        })
    }
}

/// One problem.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct FileProblem {
    /// Line, from 1, where it is known.
    pub line: Option<usize>,
    /// Column, from 1, where it is known.
    pub column: Option<usize>,
    /// What was found and what is allowed.
    pub message: String,
}

impl FileProblem {
    /// A problem whose place is not known, or stands in the message.
    fn of(message: String) -> Self {
        Self { line: None, column: None, message }
    }
}

impl fmt::Display for FileProblem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.line, self.column) {
            (Some(line), Some(column)) => write!(f, "line {line}, column {column}: ")?,
            (Some(line), None) => write!(f, "line {line}: ")?,
            _ => {}
        }
        f.write_str(&self.message)
    }
}

/// What was found in a file.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct CheckedFile {
    /// The file.
    pub file: String,
    /// What it is.
    pub kind: FileKind,
    /// What it was read as, in words; empty while there are problems.
    pub facts: Vec<String>,
    /// Its problems, by line.
    pub problems: Vec<FileProblem>,
}

/// Checks a file.
#[must_use]
pub fn check_file(path: &Path) -> CheckedFile {
    let file = path.display().to_string();
    let unreadable = |message: String| CheckedFile {
        file: file.clone(),
        kind: FileKind::Unknown,
        facts: Vec::new(),
        problems: vec![FileProblem { line: None, column: None, message }],
    };
    match bounded_file::text(path, Limit::SETTINGS) {
        Ok(text) => check_text(&file, &text),
        Err(error) => unreadable(error.to_string()),
    }
}

/// Checks the text of a file of this name.
#[must_use]
pub fn check_text(file: &str, text: &str) -> CheckedFile {
    let kind = kinds::recognise(file, text);
    let mut problems = match kind {
        FileKind::Configuration | FileKind::Unknown => kinds::configuration(text),
        FileKind::Car => kinds::car(text),
        FileKind::Track => kinds::track(file, text),
        FileKind::Bench => kinds::bench(text),
        FileKind::Map => kinds::map(file, text),
        FileKind::VehicleMap => kinds::vehicle_map(file, text),
    };
    problems.sort_by_key(|p| (p.line.is_none(), p.line, p.column));
    let facts = match kind {
        FileKind::Car if problems.is_empty() => {
            CarParams::from_toml(text).map_or(Vec::new(), |car| facts(&car))
        }
        _ => Vec::new(),
    };
    CheckedFile { file: file.to_owned(), kind, facts, problems }
}
