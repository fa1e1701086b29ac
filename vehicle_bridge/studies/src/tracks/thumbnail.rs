//! A small map of a track with the places where cars failed.

use std::fmt::Write as _;

use vehicle_model::Track;

use svg_page::{escape, path};

/// Points along each edge.
const POINTS: usize = 240;
/// Room around the track, as a share of its size.
const ROOM: f64 = 0.06;
/// Radius of a mark, as a share of the track's size.
const MARK: f64 = 0.022;

/// A place on a track with a text.
#[derive(Debug, Clone)]
pub(super) struct Place {
    /// Progress \[m\].
    pub s: f64,
    /// Lateral deviation \[m\].
    pub e_y: f64,
    /// What happened there.
    pub text: String,
}

/// The map as SVG.
#[must_use]
pub(super) fn thumbnail(track: &Track, places: &[Place]) -> String {
    let along = || (0..POINTS).map(|i| track.length() * i as f64 / POINTS as f64);
    let left: Vec<_> = along().map(|s| track.beside(s, track.width_left(s))).collect();
    let right: Vec<_> = along().map(|s| track.beside(s, -track.width_right(s))).collect();
    let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    for (x, y) in left.iter().chain(&right) {
        low = [low[0].min(*x), low[1].min(*y)];
        high = [high[0].max(*x), high[1].max(*y)];
    }
    let (width, height) = (high[0] - low[0], high[1] - low[1]);
    let size = width.max(height);
    let room = ROOM * size;
    // SVG has y downwards.
    let mut out = format!(
        "<svg class=\"map\" viewBox=\"{:.3} {:.3} {:.3} {:.3}\" role=\"img\">\
         <path class=\"road\" fill-rule=\"evenodd\" d=\"{}Z {}Z\"/>",
        low[0] - room,
        -high[1] - room,
        width + 2.0 * room,
        height + 2.0 * room,
        d(&left),
        d(&right)
    );
    let line =
        [track.beside(0.0, track.width_left(0.0)), track.beside(0.0, -track.width_right(0.0))];
    let _ = write!(out, "<path class=\"start\" d=\"{}\"/>", d(&line));
    for place in places {
        let (x, y) = track.beside(place.s, place.e_y);
        let _ = write!(
            out,
            "<circle class=\"off\" cx=\"{x:.3}\" cy=\"{:.3}\" r=\"{:.3}\"><title>{}</title></circle>",
            -y,
            MARK * size,
            escape(&place.text)
        );
    }
    out.push_str("</svg>\n");
    out
}

/// SVG has y downwards.
fn d(points: &[(f64, f64)]) -> String {
    path(points.iter().map(|(x, y)| (*x, -y)), 2)
}
