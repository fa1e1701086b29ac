//! Tracks in our own file format.

use super::path::Path;
use super::{Origin, Station, Track, TrackPoint};
use std::fmt::Write as _;

impl Track {
    /// The track in our own format, see [`Track::from_toml`]; reading it again gives the same
    /// track to the last bit. None for a track of points, which [`points_to_toml`] writes.
    #[must_use]
    pub fn to_toml(&self) -> Option<String> {
        let Path::Arcs(arcs) = &self.path else { return None };
        let ((left, right), _) = self.widths.ends().next()?;
        let mut text = head(&self.name, self.length);
        let _ = writeln!(text, "width_left_m = {left:?}\nwidth_right_m = {right:?}");
        for (arc, (start, end)) in arcs.iter().zip(self.widths.ends()) {
            let _ = writeln!(text, "\n[[segment]]\nlength_m = {:?}", arc.length);
            if arc.kappa != 0.0 {
                let _ = writeln!(text, "radius_m = {:?}", radius(arc.kappa));
            }
            if start != (left, right) {
                let _ =
                    writeln!(text, "width_left_m = {:?}\nwidth_right_m = {:?}", start.0, start.1);
            }
            if end != start {
                let (left, right) = end;
                let _ =
                    writeln!(text, "width_left_end_m = {left:?}\nwidth_right_end_m = {right:?}");
            }
        }
        write_stations(&mut text, self.stations());
        Some(text)
    }
}

/// Points of a centre line in our own format, to be taken as they are, with the place on the
/// globe of x = y = 0 where it is known.
#[must_use]
pub fn points_to_toml(name: &str, points: &[TrackPoint], origin: Option<Origin>) -> String {
    let n = points.len();
    let length = (0..n).map(|i| (points[i], points[(i + 1) % n]));
    let length: f64 = length.map(|(a, b)| libm::hypot(b.x - a.x, b.y - a.y)).sum();
    let mut text = head(name, length);
    if let Some(Origin { latitude, longitude, height }) = origin {
        let _ = writeln!(
            text,
            "origin_lat_deg = {latitude:?}\norigin_lon_deg = {longitude:?}\norigin_height_m = {height:?}"
        );
    }
    text.push_str("smooth_m = 0.0\npoint = [\n");
    for TrackPoint { x, y, width_left, width_right } in points {
        let _ = writeln!(
            text,
            "  {{ x_m = {x:?}, y_m = {y:?}, width_left_m = {width_left:?}, \
             width_right_m = {width_right:?} }},"
        );
    }
    text.push_str("]\n");
    text
}

/// Writes the stations of a track.
pub(super) fn write_stations(text: &mut String, stations: &[Station]) {
    for Station { s, bank, slope, friction, speed_limit } in stations {
        let _ = writeln!(text, "\n[[station]]\ns_m = {s:?}");
        let angles = [("bank_deg", bank), ("slope_deg", slope)];
        for (key, angle) in angles {
            if let Some(angle) = angle {
                let _ = writeln!(text, "{key} = {:?}", degrees(*angle));
            }
        }
        if let Some(friction) = friction {
            let _ = writeln!(text, "friction = {friction:?}");
        }
        match speed_limit {
            Some(limit) if limit.is_finite() => {
                let _ = writeln!(text, "speed_limit_mps = {limit:?}");
            }
            Some(_) => text.push_str("speed_limit_mps = \"none\"\n"),
            None => {}
        }
    }
}

/// The degrees that are this angle \[rad\] to the last bit, if there are any.
fn degrees(angle: f64) -> f64 {
    let near = angle.to_degrees();
    let candidates = [near, near.next_up(), near.next_down()];
    let same = |degrees: &f64| degrees.to_radians().to_bits() == angle.to_bits();
    candidates.into_iter().find(same).unwrap_or(near)
}

/// The beginning of a file.
fn head(name: &str, length: f64) -> String {
    let name: String = name
        .chars()
        .map(|c| if c == '"' || c == '\\' || c.is_control() { '_' } else { c })
        .collect();
    format!("# {length:.3} m along the centre line.\nname = \"{name}\"\n")
}

/// The radius whose inverse is this curvature to the last bit, if there is one.
fn radius(kappa: f64) -> f64 {
    let near = 1.0 / kappa;
    let candidates = [near, near.next_up(), near.next_down()];
    candidates.into_iter().find(|r| (1.0 / r).to_bits() == kappa.to_bits()).unwrap_or(near)
}
