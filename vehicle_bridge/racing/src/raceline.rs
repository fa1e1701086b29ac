//! Racelines in the format of TUM's tools: the learned lap as one, and those of others to compare with.

use std::fmt::Write as _;

use vehicle_model::track::wrap_angle;
use vehicle_model::{Track, TrackError};

use super::record::StepRow;

/// A line with its speeds.
#[derive(Debug, Clone, PartialEq)]
pub struct Raceline {
    /// What it is called.
    pub name: String,
    /// Points x, y \[m\] and speed \[m/s\], which is no number where the file has none.
    pub points: Vec<[f64; 3]>,
}

/// The steps of a lap as a raceline, with its time in a comment: `s_m; x_m; y_m; psi_rad; kappa_radpm;
/// vx_mps; ax_mps2`, along its own length. `psi_rad` is the course of the line, 0 along +x; curvature
/// and acceleration are central differences.
#[must_use]
pub fn text(title: &str, steps: &[StepRow], period: f64) -> String {
    let n = steps.len();
    let mut out = format!("# {title}\n# s_m; x_m; y_m; psi_rad; kappa_radpm; vx_mps; ax_mps2\n");
    let speed = |i: usize| steps[i].x.v_x.hypot(steps[i].x.v_y);
    let course = |i: usize| steps[i].pose.psi + steps[i].x.v_y.atan2(steps[i].x.v_x);
    let distance = |i: usize, j: usize| {
        let (a, b) = (&steps[i].pose, &steps[j].pose);
        (b.x - a.x).hypot(b.y - a.y)
    };
    let mut way = 0.0;
    for (i, step) in steps.iter().enumerate() {
        if i > 0 {
            way += distance(i - 1, i);
        }
        let (before, after) = (i.saturating_sub(1), (i + 1).min(n - 1));
        let length = distance(before, i) + distance(i, after);
        let kappa = wrap_angle(course(after) - course(before)) / length.max(1e-9);
        let time = period * (after - before).max(1) as f64;
        let along = (speed(after) - speed(before)) / time;
        let pose = &step.pose;
        let _ = writeln!(
            out,
            "{way:.7}; {:.7}; {:.7}; {:.7}; {kappa:.7}; {:.7}; {along:.7}",
            pose.x,
            pose.y,
            course(i),
            speed(i)
        );
    }
    out
}

/// Reads a raceline: 7 columns as above, or x, y and perhaps a speed; separated by semicolons, commas
/// or blanks, `#` before comments.
///
/// # Errors
/// The first line that holds something else, or that there are too few.
pub fn read(name: &str, text: &str) -> Result<Raceline, TrackError> {
    let mut points = Vec::new();
    for (i, line) in text.lines().enumerate() {
        let content = line.split('#').next().unwrap_or_default();
        let cells: Vec<&str> =
            content.split([';', ',', ' ', '\t']).map(str::trim).filter(|c| !c.is_empty()).collect();
        if cells.is_empty() {
            continue;
        }
        let numbers: Option<Vec<f64>> =
            cells.iter().map(|c| c.parse().ok().filter(|v: &f64| v.is_finite())).collect();
        let point = match numbers.as_deref() {
            Some([_, x, y, _, _, v, _]) => [*x, *y, *v],
            Some([x, y, v]) => [*x, *y, *v],
            Some([x, y]) => [*x, *y, f64::NAN],
            // A header.
            None if points.is_empty() => continue,
            _ => {
                return Err(TrackError::Syntax {
                    line: i + 1,
                    column: 1,
                    found: format!("`{}`", line.trim()),
                    expected: "7 numbers of a raceline (s; x; y; psi; kappa; v; a), or x, y and \
                               perhaps a speed"
                        .to_owned(),
                });
            }
        };
        points.push(point);
    }
    if points.len() < 3 {
        return Err(TrackError::Syntax {
            line: 1,
            column: 1,
            found: format!("{} points", points.len()),
            expected: "a raceline of at least 3".to_owned(),
        });
    }
    Ok(Raceline { name: name.to_owned(), points })
}

impl Raceline {
    /// Its points along the track: s, e_y \[m\] and speed \[m/s\], s ascending.
    #[must_use]
    pub fn along(&self, track: &Track) -> Vec<[f64; 3]> {
        let mut hint = None;
        let mut points: Vec<[f64; 3]> = self
            .points
            .iter()
            .map(|[x, y, v]| {
                let foot = track.project(*x, *y, hint);
                hint = Some(foot.s);
                [track.wrap(foot.s), foot.e_y, *v]
            })
            .collect();
        points.sort_by(|a, b| a[0].total_cmp(&b[0]));
        points
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "code of tests")]

    use controller::Status;
    use vehicle_model::{Input, State};

    use super::*;
    use crate::record::ModelErrorNorms;

    /// Round a circle at constant speed: its curvature, no acceleration, and the same points back.
    #[test]
    fn a_circle_comes_back() {
        let (radius, v, dt) = (5.0, 2.0, 0.1);
        let steps: Vec<StepRow> = (0..150)
            .map(|i| {
                let angle = v / radius * dt * f64::from(i);
                let pose = vehicle_model::GlobalState {
                    x: radius * angle.sin(),
                    y: radius * (1.0 - angle.cos()),
                    psi: angle,
                    ..Default::default()
                };
                StepRow {
                    time: dt * f64::from(i),
                    x: State { v_x: v, ..State::default() },
                    pose,
                    u: Input::default(),
                    status: Status::default(),
                    alpha_f: 0.0,
                    alpha_r: 0.0,
                    use_f: 0.0,
                    use_r: 0.0,
                    overhang: 0.0,
                    model_error: ModelErrorNorms::NONE,
                }
            })
            .collect();
        let text = text("circle", &steps, dt);
        let row: Vec<f64> =
            text.lines().nth(50).unwrap().split(';').map(|c| c.trim().parse().unwrap()).collect();
        assert!((row[4] * radius - 1.0).abs() < 1e-3 && row[6].abs() < 1e-9, "{row:?}");
        let read = read("circle", &text).unwrap();
        assert_eq!(read.points.len(), 150);
        assert!((read.points[48][0] - row[1]).abs() < 1e-6 && read.points[48][2] == 2.0);
        let error = super::read("bad", "0; 0; 1; 2\n").unwrap_err().to_string();
        assert!(error.contains("line 1") && error.contains("7 numbers"), "{error}");
    }
}
