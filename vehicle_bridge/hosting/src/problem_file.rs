//! Optimal control problems in files: one JSON document for each FHOCP.
//!
//! The format `lmpc-qp-2` is described in `docs/qp_files.md`: the numbers of [`Fhocp`] under the same names,
//! matrices row by row, an infinite bound as `null`. Numbers are written so that they are read back to
//! the same bits.

use std::path::{Path, PathBuf};

use bounded_file::Limit;
use controller::Affine;
use controller::fhocp::{Fhocp, SlipRow};
use nalgebra::{Matrix6, Matrix6x2, Vector2, Vector6};
use serde::{Deserialize, Serialize};

/// The version of the format.
pub const FORMAT: &str = "lmpc-qp-2";

/// The version before, without `lane_heading`; it is read as zeros.
const WITHOUT_HEADING: &str = "lmpc-qp-1";

/// Why a problem could not be written or read.
#[derive(Debug, thiserror::Error)]
pub enum ProblemError {
    /// The file system refuses.
    #[error("{path}: {source}")]
    File {
        /// The file or folder.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// The file cannot be read.
    #[error(transparent)]
    Read(#[from] bounded_file::ReadError),
    /// The file is not of this format.
    #[error(
        "{path} is no problem of the format {FORMAT}: {reason}; `lmpc bench --dump-qp DIR` writes some"
    )]
    Format {
        /// The file.
        path: PathBuf,
        /// What was found and what was expected.
        reason: String,
    },
    /// A folder without problems.
    #[error("{0} holds no *.json file; `lmpc bench --dump-qp DIR` writes some")]
    Empty(PathBuf),
}

/// A slip angle, linearised.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Slip {
    velocity: [f64; 3],
    steering: f64,
    offset: f64,
    weight: f64,
    reference: f64,
}

/// The model of one stage, row by row.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Stage {
    a: [[f64; 6]; 6],
    b: [[f64; 2]; 6],
    c: [f64; 6],
}

/// What stands in a file; each field is that of [`Fhocp`].
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Document {
    format: String,
    x_0: [f64; 6],
    u_prev: [f64; 2],
    lag: f64,
    input_cost: [f64; 2],
    rate_cost: [f64; 2],
    u_min: [f64; 2],
    u_max: [f64; 2],
    reserve: [[f64; 2]; 2],
    du_max: [Option<f64>; 2],
    lane_linear: f64,
    lane_quadratic: f64,
    front_max: Option<f64>,
    rear_max: Option<f64>,
    slip_linear: f64,
    speed_linear: f64,
    terminal_slack_weight: [f64; 6],
    #[serde(default)]
    lane_heading: Vec<f64>,
    e_y_min: Vec<f64>,
    e_y_max: Vec<f64>,
    front_share: Vec<f64>,
    rear_share: Vec<f64>,
    speed_max: Vec<Option<f64>>,
    front: Vec<Slip>,
    rear: Vec<Slip>,
    hull_cost: Vec<f64>,
    hull: Vec<[f64; 6]>,
    model: Vec<Stage>,
}

fn bound(value: f64) -> Option<f64> {
    value.is_finite().then_some(value)
}

fn unbound(value: Option<f64>) -> f64 {
    value.unwrap_or(f64::INFINITY)
}

impl Slip {
    fn of(row: &SlipRow) -> Self {
        let SlipRow { velocity, steering, offset, weight, reference } = *row;
        Self { velocity, steering, offset, weight, reference }
    }

    fn row(&self) -> SlipRow {
        let Self { velocity, steering, offset, weight, reference } = *self;
        SlipRow { velocity, steering, offset, weight, reference }
    }
}

impl Stage {
    fn of(model: &Affine) -> Self {
        Self {
            a: std::array::from_fn(|i| std::array::from_fn(|j| model.a[(i, j)])),
            b: std::array::from_fn(|i| std::array::from_fn(|j| model.b[(i, j)])),
            c: model.c.into(),
        }
    }

    fn model(&self) -> Affine {
        Affine {
            a: Matrix6::from_fn(|i, j| self.a[i][j]),
            b: Matrix6x2::from_fn(|i, j| self.b[i][j]),
            c: Vector6::from(self.c),
        }
    }
}

impl Document {
    fn of(problem: &Fhocp) -> Self {
        Self {
            format: FORMAT.to_owned(),
            x_0: problem.x_0.into(),
            u_prev: problem.u_prev.into(),
            lag: problem.lag,
            input_cost: problem.input_cost.into(),
            rate_cost: problem.rate_cost.into(),
            u_min: problem.u_min.into(),
            u_max: problem.u_max.into(),
            reserve: problem.reserve.map(Into::into),
            du_max: [bound(problem.du_max[0]), bound(problem.du_max[1])],
            lane_linear: problem.lane_linear,
            lane_quadratic: problem.lane_quadratic,
            front_max: bound(problem.front_max),
            rear_max: bound(problem.rear_max),
            slip_linear: problem.slip_linear,
            speed_linear: problem.speed_linear,
            terminal_slack_weight: problem.terminal_slack_weight.into(),
            lane_heading: problem.lane_heading.clone(),
            e_y_min: problem.e_y_min.clone(),
            e_y_max: problem.e_y_max.clone(),
            front_share: problem.front_share.clone(),
            rear_share: problem.rear_share.clone(),
            speed_max: problem.speed_max.iter().map(|most| bound(*most)).collect(),
            front: problem.front.iter().map(Slip::of).collect(),
            rear: problem.rear.iter().map(Slip::of).collect(),
            hull_cost: problem.hull_cost.clone(),
            hull: problem.hull.iter().map(|point| (*point).into()).collect(),
            model: problem.model.iter().map(Stage::of).collect(),
        }
    }

    /// The problem, or what does not fit.
    fn problem(mut self) -> Result<Fhocp, String> {
        let (horizon, points) = (self.model.len(), self.hull.len());
        match self.format.as_str() {
            FORMAT => {}
            WITHOUT_HEADING if self.lane_heading.is_empty() => {
                self.lane_heading = vec![0.0; horizon];
            }
            WITHOUT_HEADING => return Err(format!("`lane_heading` needs `format` {FORMAT}")),
            _ => return Err(format!("`format` is '{}'", self.format)),
        }
        if horizon == 0 || points == 0 {
            return Err(format!(
                "{horizon} stages in `model` and {points} points in `hull`; both take at least one"
            ));
        }
        let lengths = [
            ("lane_heading", self.lane_heading.len()),
            ("e_y_min", self.e_y_min.len()),
            ("e_y_max", self.e_y_max.len()),
            ("front_share", self.front_share.len()),
            ("rear_share", self.rear_share.len()),
            ("speed_max", self.speed_max.len()),
            ("front", self.front.len()),
            ("rear", self.rear.len()),
        ];
        if let Some((name, found)) = lengths.into_iter().find(|(_, length)| *length != horizon) {
            return Err(format!("`{name}` has {found} entries, not {horizon} as `model`"));
        }
        if self.hull_cost.len() != points {
            return Err(format!(
                "`hull_cost` has {} entries, not {points} as `hull`",
                self.hull_cost.len()
            ));
        }
        let mut problem = Fhocp::new(horizon, points);
        problem.x_0 = Vector6::from(self.x_0);
        problem.u_prev = Vector2::from(self.u_prev);
        problem.lag = self.lag;
        problem.input_cost = Vector2::from(self.input_cost);
        problem.rate_cost = Vector2::from(self.rate_cost);
        problem.u_min = Vector2::from(self.u_min);
        problem.u_max = Vector2::from(self.u_max);
        problem.reserve = self.reserve.map(Vector2::from);
        problem.du_max = Vector2::from(self.du_max.map(unbound));
        problem.lane_linear = self.lane_linear;
        problem.lane_quadratic = self.lane_quadratic;
        problem.front_max = unbound(self.front_max);
        problem.rear_max = unbound(self.rear_max);
        problem.slip_linear = self.slip_linear;
        problem.speed_linear = self.speed_linear;
        problem.terminal_slack_weight = Vector6::from(self.terminal_slack_weight);
        problem.lane_heading = self.lane_heading;
        problem.e_y_min = self.e_y_min;
        problem.e_y_max = self.e_y_max;
        problem.front_share = self.front_share;
        problem.rear_share = self.rear_share;
        problem.speed_max = self.speed_max.into_iter().map(unbound).collect();
        problem.front = self.front.iter().map(Slip::row).collect();
        problem.rear = self.rear.iter().map(Slip::row).collect();
        problem.hull_cost = self.hull_cost;
        problem.hull = self.hull.into_iter().map(Vector6::from).collect();
        problem.model = self.model.iter().map(Stage::model).collect();
        Ok(problem)
    }
}

/// Writes a problem. One that holds a number that is not finite, infinite bounds apart, cannot be read back.
///
/// # Errors
/// If the file cannot be written.
pub fn write(path: &Path, problem: &Fhocp) -> Result<(), ProblemError> {
    let file = |source| ProblemError::File { path: path.to_owned(), source };
    let text = serde_json::to_string(&Document::of(problem)).map_err(|e| file(e.into()))?;
    std::fs::write(path, text + "\n").map_err(file)
}

/// Reads a problem.
///
/// # Errors
/// If the file cannot be read or is not of the format.
pub fn read(path: &Path) -> Result<Fhocp, ProblemError> {
    let text = bounded_file::text(path, Limit::SETTINGS)?;
    let document: Result<Document, _> = serde_json::from_str(&text);
    let problem = document.map_err(|e| e.to_string()).and_then(Document::problem);
    problem.map_err(|reason| ProblemError::Format { path: path.to_owned(), reason })
}

/// The problems of a folder, or of one file, by name in alphabetical order.
///
/// # Errors
/// If the folder holds no problem, or a file cannot be read.
pub fn read_all(path: &Path) -> Result<Vec<(String, Fhocp)>, ProblemError> {
    let file = |source| ProblemError::File { path: path.to_owned(), source };
    let mut paths = Vec::new();
    if path.is_dir() {
        for entry in std::fs::read_dir(path).map_err(file)? {
            let path = entry.map_err(file)?.path();
            if path.extension().is_some_and(|ending| ending == "json") {
                paths.push(path);
            }
        }
        paths.sort();
    } else {
        paths.push(path.to_owned());
    }
    if paths.is_empty() {
        return Err(ProblemError::Empty(path.to_owned()));
    }
    let name = |path: &Path| path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    paths.into_iter().map(|path| Ok((name(&path), read(&path)?))).collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    #[test]
    fn what_is_written_is_read_back_to_the_bit() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.json");
        let mut problem = Fhocp::new(2, 3);
        problem.model[1].a[(1, 4)] = 0.1 + 0.2;
        problem.model[0].b[(3, 1)] = -1.0 / 3.0;
        problem.hull[2][5] = f64::MIN_POSITIVE;
        problem.speed_max[1] = 2.5;
        problem.du_max[0] = 0.7;
        problem.front[1].velocity = [1e-300, 2.0, -3.0];
        problem.reserve[1][0] = 0.05;
        problem.lane_heading[1] = 0.1 + 0.2;
        write(&path, &problem).unwrap();
        assert_eq!(read_all(folder.path()).unwrap(), [("a".to_owned(), problem)]);
    }

    /// Files of the version before had lanes that the heading does not enter.
    #[test]
    fn the_version_before_is_read_with_levers_of_zero() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("c.json");
        let problem = Fhocp::new(3, 2);
        write(&path, &problem).unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        let text = text.replacen("\"lane_heading\":[0.0,0.0,0.0],", "", 1);
        std::fs::write(&path, text.replacen(FORMAT, WITHOUT_HEADING, 1)).unwrap();
        assert_eq!(read(&path).unwrap(), problem);
    }

    #[test]
    fn what_is_wrong_with_a_file_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("b.json");
        assert!(matches!(read_all(folder.path()), Err(ProblemError::Empty(_))));
        write(&path, &Fhocp::new(3, 2)).unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        for (from, to, expected) in [
            (FORMAT, "lmpc-qp-0", "`format` is 'lmpc-qp-0'"),
            ("\"rear_share\":[1.0,", "\"rear_share\":[", "`rear_share` has 2 entries, not 3"),
            ("\"lag\":0.0", "\"lag\":null", "invalid type: null"),
            ("\"lag\"", "\"leg\"", "unknown field `leg`"),
            ("lane_heading", "lane_herding", "unknown field `lane_herding`"),
            ("\"lane_heading\":[0.0,0.0,0.0],", "", "`lane_heading` has 0 entries, not 3"),
            (FORMAT, WITHOUT_HEADING, "`lane_heading` needs `format` lmpc-qp-2"),
        ] {
            std::fs::write(&path, text.replacen(from, to, 1)).unwrap();
            let found = read(&path).unwrap_err().to_string();
            assert!(found.contains(expected), "{found}");
        }
    }
}
