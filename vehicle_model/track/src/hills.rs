//! The slope of a track whose points have heights.

use super::{Imported, Station, TrackError, points, smooth};

/// A track that is nowhere steeper than this is taken for flat: heights are no more exact, and a level
/// road needs fewer terms in the equations of motion \[rad\].
const LEVEL: f64 = 1e-3;

/// The track with slopes that follow from the heights of its points \[m\], smoothed as their noise asks
/// for.
pub(super) fn with_heights(
    imported: Imported,
    heights: Option<Vec<f64>>,
) -> Result<Imported, Vec<TrackError>> {
    let Some(heights) = heights else { return Ok(imported) };
    let track = &imported.track;
    let mut hint = None;
    let mut places: Vec<(f64, f64)> = Vec::with_capacity(heights.len());
    for (point, height) in imported.points.iter().zip(heights) {
        let s = track.wrap(track.project(point.x, point.y, hint).s);
        hint = Some(s);
        places.push((s, height));
    }
    places.sort_by(|a, b| a.0.total_cmp(&b.0));
    places.dedup_by(|next, kept| next.0 - kept.0 < points::SAME);
    if places.len() < points::FEWEST {
        return Ok(imported);
    }
    let slopes = smooth::slopes(&places, track.length());
    let stations: Vec<Station> = slopes
        .into_iter()
        .map(|(s, rise)| Station {
            s: track.wrap(s),
            slope: Some(written(libm::atan(rise))),
            ..Station::default()
        })
        .collect();
    if stations.iter().all(|at| at.slope.is_none_or(|slope| slope.abs() < LEVEL)) {
        return Ok(imported);
    }
    let track = imported.track.clone().with_stations(&stations).map_err(|error| vec![error])?;
    Ok(Imported { track, ..imported })
}

/// The angle as our own format writes it: a short number of degrees, to the last bit \[rad\].
fn written(angle: f64) -> f64 {
    ((angle.to_degrees() * 1e6).round() / 1e6).to_radians()
}
