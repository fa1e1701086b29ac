//! The track from above with laps coloured by speed.

use std::fmt::Write as _;

use vehicle_model::Track;

use super::LapView;
use optimum_store::Known;
use racing::raceline::Raceline;
use racing::record::StepRow;
use svg_page::{escape, path};

/// Colours from slow to fast, legible on light and dark.
const COLOURS: [(f64, [f64; 3]); 5] = [
    (0.0, [67.0, 97.0, 238.0]),
    (0.3, [32.0, 178.0, 170.0]),
    (0.55, [126.0, 190.0, 60.0]),
    (0.8, [245.0, 159.0, 0.0]),
    (1.0, [214.0, 40.0, 40.0]),
];
/// Steps of the colour bar.
const BINS: usize = 24;
/// Points drawn between two control steps.
const SUBDIVISION: usize = 5;
/// Points along each edge of the track.
const EDGE_POINTS: usize = 600;

/// Speeds at the ends of the colour bar [m/s].
#[derive(Debug, Clone, Copy)]
pub(super) struct SpeedRange {
    /// Slowest.
    least: f64,
    /// Fastest.
    most: f64,
}

impl SpeedRange {
    /// Of some steps.
    #[must_use]
    pub(super) fn of(steps: &[StepRow]) -> Self {
        Self::among(steps.iter().map(|r| r.x.v_x))
    }

    /// Of some speeds \[m/s\].
    fn among(speeds: impl Iterator<Item = f64> + Clone) -> Self {
        let speeds = || speeds.clone().filter(|v| v.is_finite());
        let least = speeds().fold(f64::INFINITY, f64::min).max(0.0);
        let most = speeds().fold(0.0, f64::max);
        if least < most { Self { least, most } } else { Self { least: 0.0, most: most.max(1.0) } }
    }

    fn bin(&self, speed: f64) -> usize {
        let part = (speed - self.least) / (self.most - self.least);
        ((part * BINS as f64) as usize).min(BINS - 1)
    }
}

/// The map as HTML with its colour bar.
#[must_use]
pub(super) fn map(
    track: &Track,
    laps: &[LapView<'_>],
    (optimal, raceline): (Option<&Known>, Option<&Raceline>),
    off_track: Option<(f64, f64)>,
) -> String {
    let all: Vec<StepRow> = laps.iter().flat_map(|lap| lap.steps.iter().copied()).collect();
    let range = SpeedRange::of(&all);
    let (mut out, bounds) = road(track);
    for lap in laps {
        let _ = write!(out, "<g data-lap=\"{}\"><title>{}</title>", lap.number, escape(&lap.title));
        coloured(&lap.closed(), &range, &mut out);
        out.push_str("</g>\n");
    }
    if let Some(optimal) = optimal {
        let line: Vec<(f64, f64)> =
            optimal.points.iter().map(|p| track.beside(p[0], p[3])).collect();
        let _ = writeln!(
            out,
            "<path class=\"path optimal\" d=\"{}Z\"><title>time-optimal lap, {:.3} s</title></path>",
            d(&line),
            optimal.lap_time_s
        );
    }
    if let Some(raceline) = raceline {
        let line: Vec<(f64, f64)> = raceline.points.iter().map(|p| (p[0], p[1])).collect();
        let title = escape(&raceline.name);
        let _ = writeln!(
            out,
            "<path class=\"path raceline\" d=\"{}Z\"><title>{title}</title></path>",
            d(&line)
        );
    }
    if let Some((x, y)) = off_track {
        let _ = writeln!(
            out,
            "<circle class=\"off\" cx=\"{x:.3}\" cy=\"{:.3}\" r=\"{:.3}\"><title>here the run \
             failed</title></circle>",
            -y,
            0.009 * bounds.size()
        );
    }
    out.push_str("</svg>\n");
    out.push_str(&colour_bar(&range));
    out
}

/// The map of a track with points beside it and circles around places of its centre line.
#[must_use]
pub(crate) fn outline(track: &Track, points: &[(f64, f64)], places: &[f64]) -> String {
    let (mut out, bounds) = road(track);
    for (x, y) in points {
        let radius = 0.001 * bounds.size();
        let _ = writeln!(
            out,
            "<circle class=\"given\" cx=\"{x:.3}\" cy=\"{:.3}\" r=\"{radius:.4}\"/>",
            -y
        );
    }
    for &s in places {
        let ((x, y), radius) = (track.position(s), 0.015 * bounds.size());
        let _ = writeln!(
            out,
            "<circle class=\"cut\" cx=\"{x:.3}\" cy=\"{:.3}\" r=\"{radius:.4}\"/>",
            -y
        );
    }
    out.push_str("</svg>\n");
    out
}

/// A line coloured by speed on the track, as HTML with its colour bar; points are x, y \[m\] and
/// speed \[m/s\].
#[must_use]
pub(crate) fn speed_map(track: &Track, line: &[(f64, f64, f64)], title: &str) -> String {
    let range = SpeedRange::among(line.iter().map(|p| p.2));
    let (mut out, _) = road(track);
    let _ = write!(out, "<g><title>{}</title>", escape(title));
    let mut run: Vec<(f64, f64)> = Vec::new();
    let mut bin = 0;
    for &(x, y, speed) in line {
        run.push((x, y));
        let next = range.bin(speed);
        if next != bin {
            stroke(&run, bin, &mut out);
            run = vec![(x, y)];
        }
        bin = next;
    }
    stroke(&run, bin, &mut out);
    out.push_str("</g>\n</svg>\n");
    out.push_str(&colour_bar(&range));
    out
}

/// The track with its edges, centre line and start, as an open drawing.
fn road(track: &Track) -> (String, Bounds) {
    let edge = |side: f64| -> Vec<(f64, f64)> {
        (0..EDGE_POINTS)
            .map(|i| {
                let s = track.length() * i as f64 / EDGE_POINTS as f64;
                let width = if side > 0.0 { track.width_left(s) } else { track.width_right(s) };
                track.beside(s, side * width)
            })
            .collect()
    };
    let (left, right) = (edge(1.0), edge(-1.0));
    let bounds = Bounds::around(left.iter().chain(&right));
    let mut out = bounds.open();
    let _ = writeln!(
        out,
        "<path class=\"road\" fill-rule=\"evenodd\" d=\"{}Z {}Z\"/>",
        d(&left),
        d(&right)
    );
    let centre: Vec<(f64, f64)> = (0..EDGE_POINTS)
        .map(|i| track.beside(track.length() * i as f64 / EDGE_POINTS as f64, 0.0))
        .collect();
    let _ = writeln!(out, "<path class=\"centre\" d=\"{}Z\"/>", d(&centre));
    start(track, bounds.size(), &mut out);
    (out, bounds)
}

/// SVG has y downwards.
fn d(points: &[(f64, f64)]) -> String {
    path(points.iter().map(|(x, y)| (*x, -y)), 3)
}

/// The line and arrows that show where and in which direction a lap begins.
fn start(track: &Track, size: f64, out: &mut String) {
    let (left, right) =
        (track.beside(0.0, track.width_left(0.0)), track.beside(0.0, -track.width_right(0.0)));
    let _ = writeln!(
        out,
        "<path class=\"start\" d=\"{}\"><title>start and finish</title></path>",
        d(&[left, right])
    );
    for quarter in 0..4 {
        let s = track.length() * (f64::from(quarter) / 4.0 + 0.02);
        let width = track.width_right(s);
        let reach = (0.012 * size).min(0.6 * width);
        let tip = track.beside(s + reach, -0.6 * width);
        let wings = [
            track.beside(s, -0.6 * width + 0.5 * reach),
            track.beside(s, -0.6 * width - 0.5 * reach),
        ];
        let _ = writeln!(out, "<path class=\"arrow\" d=\"{}Z\"/>", d(&[tip, wings[0], wings[1]]));
    }
}

/// A lap as paths of one colour each, smooth between the control steps.
fn coloured(steps: &[StepRow], range: &SpeedRange, out: &mut String) {
    let mut run: Vec<(f64, f64)> = Vec::new();
    let mut colour = None;
    for pair in steps.windows(2) {
        for k in 0..SUBDIVISION {
            let part = k as f64 / SUBDIVISION as f64;
            let bin = range.bin(pair[0].x.v_x + part * (pair[1].x.v_x - pair[0].x.v_x));
            let point = between(&pair[0], &pair[1], part);
            run.push(point);
            if colour.is_some_and(|c| c != bin) {
                stroke(&run, colour.unwrap_or(bin), out);
                run = vec![point];
            }
            colour = Some(bin);
        }
    }
    if let (Some(last), Some(bin)) = (steps.last(), colour) {
        run.push((last.pose.x, last.pose.y));
        stroke(&run, bin, out);
    }
}

fn stroke(points: &[(f64, f64)], bin: usize, out: &mut String) {
    let _ = write!(
        out,
        "<path class=\"path\" stroke=\"{}\" d=\"{}\"/>",
        colour((bin as f64 + 0.5) / BINS as f64),
        d(points)
    );
}

/// Cubic Hermite point between two steps, whose velocities are the tangents.
fn between(from: &StepRow, to: &StepRow, t: f64) -> (f64, f64) {
    let dt = to.time - from.time;
    let tangent = |row: &StepRow| {
        let (sin, cos) = row.pose.psi.sin_cos();
        (dt * (row.x.v_x * cos - row.x.v_y * sin), dt * (row.x.v_x * sin + row.x.v_y * cos))
    };
    let (t2, t3) = (t * t, t * t * t);
    let (h00, h10) = (2.0 * t3 - 3.0 * t2 + 1.0, t3 - 2.0 * t2 + t);
    let (h01, h11) = (3.0 * t2 - 2.0 * t3, t3 - t2);
    let (m0, m1) = (tangent(from), tangent(to));
    (
        h00 * from.pose.x + h10 * m0.0 + h01 * to.pose.x + h11 * m1.0,
        h00 * from.pose.y + h10 * m0.1 + h01 * to.pose.y + h11 * m1.1,
    )
}

fn colour(part: f64) -> String {
    let upper = COLOURS.iter().position(|c| c.0 >= part).unwrap_or(COLOURS.len() - 1).max(1);
    let ((p0, c0), (p1, c1)) = (COLOURS[upper - 1], COLOURS[upper]);
    let t = ((part - p0) / (p1 - p0)).clamp(0.0, 1.0);
    let [r, g, b] = [0, 1, 2].map(|i| (c0[i] + t * (c1[i] - c0[i])).round() as u8);
    format!("#{r:02x}{g:02x}{b:02x}")
}

fn colour_bar(range: &SpeedRange) -> String {
    let stops: Vec<String> = (0..=12).map(|i| colour(f64::from(i) / 12.0)).collect();
    format!(
        "<div class=\"bar-scale\"><span>{:.1} m/s</span><i style=\"background:linear-gradient(90deg,\
         {})\"></i><span>{:.1} m/s</span></div>\n",
        range.least,
        stops.join(","),
        range.most
    )
}

struct Bounds {
    x: (f64, f64),
    y: (f64, f64),
}

impl Bounds {
    fn around<'a>(points: impl Iterator<Item = &'a (f64, f64)>) -> Self {
        let start = (f64::INFINITY, f64::NEG_INFINITY);
        points.fold(Self { x: start, y: start }, |b, p| Self {
            x: (b.x.0.min(p.0), b.x.1.max(p.0)),
            y: (b.y.0.min(p.1), b.y.1.max(p.1)),
        })
    }

    fn size(&self) -> f64 {
        (self.x.1 - self.x.0).max(self.y.1 - self.y.0)
    }

    fn open(&self) -> String {
        let room = 0.03 * self.size();
        let (width, height) = (self.x.1 - self.x.0 + 2.0 * room, self.y.1 - self.y.0 + 2.0 * room);
        format!(
            "<svg class=\"map\" viewBox=\"{:.3} {:.3} {width:.3} {height:.3}\" \
             style=\"max-height:600px\" role=\"img\" aria-label=\"track map coloured by speed\">\n",
            self.x.0 - room,
            -self.y.1 - room
        )
    }
}
