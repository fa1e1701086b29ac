//! The page of an import: a track before and after it.

use vehicle_model::track::{Change, Imported, TrackPoint, wrap_angle};

use crate::map::outline;
use svg_page::{Chart, Mark, Series, card, escape, page, table};

/// Places along the lap that the charts show.
const PLACES: usize = 2000;
/// Ends of the curvature's axis, in largest curvatures of the track.
const KAPPA_ROOM: f64 = 1.3;

/// The points of the file as charts show them.
struct Before {
    /// Distance along the chords, scaled to the length of the track [m].
    s: Vec<f64>,
    /// Curvature through three neighbours [1/m].
    kappa: Vec<f64>,
    /// Heading of the chords, continuous along the lap [rad].
    heading: Vec<f64>,
}

impl Before {
    fn of(points: &[TrackPoint], length: f64, heading: f64) -> Self {
        let n = points.len();
        let chord = |i: usize| {
            let (a, b) = (points[i % n], points[(i + 1) % n]);
            (b.x - a.x, b.y - a.y)
        };
        let total: f64 = (0..n).map(|i| chord(i).0.hypot(chord(i).1)).sum();
        let mut before = Self { s: Vec::new(), kappa: Vec::new(), heading: Vec::new() };
        let (mut s, mut psi) = (0.0, heading);
        for i in 0..n {
            let (back, ahead) = (chord(i + n - 1), chord(i));
            let (long_back, long) = (back.0.hypot(back.1), ahead.0.hypot(ahead.1));
            let turn = wrap_angle(ahead.1.atan2(ahead.0) - back.1.atan2(back.0));
            before.s.push(s * length / total);
            before.kappa.push(turn / (0.5 * (long_back + long)));
            psi += wrap_angle(ahead.1.atan2(ahead.0) - psi);
            before.heading.push(psi);
            s += long;
        }
        before
    }

    /// Pairs of s and one value of each point.
    fn along(&self, value: impl Fn(usize) -> f64) -> Vec<(f64, f64)> {
        self.s.iter().enumerate().map(|(i, s)| (*s, value(i))).collect()
    }
}

/// The page of a track that was imported from `file`: what was changed, and the track before and after.
#[must_use]
pub fn import_page(imported: &Imported, file: &str) -> String {
    let Imported { track, changes, points, .. } = imported;
    let given: Vec<(f64, f64)> = points.iter().map(|p| (p.x, p.y)).collect();
    let cuts: Vec<f64> = changes
        .iter()
        .filter_map(|change| match change {
            Change::Clipped { from, to, .. } => Some(0.5 * (from + to)),
            _ => None,
        })
        .collect();
    let mut body = facts(imported);
    let note = "Dots: the points of the file. Circles: where a width was cut.";
    body.push_str(&card("Track", note, &outline(track, &given, &cuts)));
    let rows: Vec<Vec<String>> = changes.iter().map(|change| vec![change.to_string()]).collect();
    let list =
        if rows.is_empty() { "<p>Nothing.</p>".to_owned() } else { table(&["change"], &rows) };
    body.push_str(&card("What was changed", "", &list));
    let before = Before::of(points, track.length(), track.heading(0.0));
    let along = |value: &dyn Fn(f64) -> f64| -> Vec<(f64, f64)> {
        (0..PLACES)
            .map(|i| track.length() * i as f64 / PLACES as f64)
            .map(|s| (s, value(s)))
            .collect()
    };
    let mut kappa = Chart::new("s [m]", "kappa [1/m]");
    let most = (KAPPA_ROOM * track.max_abs_kappa()).max(1e-6);
    kappa.y_range = Some((-most, most));
    let cut = |i: usize| {
        let kappa = before.kappa[i];
        if kappa.abs() < most { kappa } else { f64::NAN }
    };
    push(&mut kappa, "before", "soft faint", before.along(cut));
    push(&mut kappa, "after", "s0", along(&|s| track.kappa(s)));
    let note = "Through three neighbouring points before, of the track after.";
    body.push_str(&card("Curvature", note, &kappa.html()));
    let mut widths = Chart::new("s [m]", "distance to the edge [m]");
    push(&mut widths, "left, before", "s0 faint", before.along(|i| points[i].width_left));
    push(&mut widths, "right, before", "s1 faint", before.along(|i| points[i].width_right));
    push(&mut widths, "left", "s0", along(&|s| track.width_left(s)));
    push(&mut widths, "right", "s1", along(&|s| track.width_right(s)));
    body.push_str(&card("Widths", "", &widths.html()));
    let mut heading = Chart::new("s [m]", "psi [rad]");
    push(&mut heading, "before", "soft faint", before.along(|i| before.heading[i]));
    push(&mut heading, "after", "s0", along(&|s| track.heading(s)));
    body.push_str(&card("Heading", "", &heading.html()));
    page(track.name(), &format!("Import of {file}."), &body, "")
}

fn push(chart: &mut Chart, label: &str, class: &str, points: Vec<(f64, f64)>) {
    if !points.is_empty() {
        chart.series.push(Series::new(label, class, Mark::Line, points));
    }
}

fn facts(imported: &Imported) -> String {
    let track = &imported.track;
    let turn = track.heading(track.length().next_down()) - track.heading(0.0);
    let way = if turn > 0.0 { "counter-clockwise" } else { "clockwise" };
    let facts = [
        (format!("{:.2} m", track.length()), format!("a lap, {way}")),
        (format!("{:.3} m", 1.0 / track.max_abs_kappa()), "least radius".to_owned()),
        (format!("{:.3} m", track.narrowest()), "wide at the narrowest place".to_owned()),
        (imported.points.len().to_string(), "points in the file".to_owned()),
        (imported.changes.len().to_string(), "changes".to_owned()),
    ];
    let cards: String = facts
        .iter()
        .map(|(value, text)| {
            format!(
                "<div class=\"fact\"><b>{}</b><span>{}</span></div>\n",
                escape(value),
                escape(text)
            )
        })
        .collect();
    format!("<div class=\"facts\">\n{cards}</div>\n")
}
