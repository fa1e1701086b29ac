//! Random closed tracks at a car's scale: straights into hairpins, chicanes, changing width.

use super::{CarSize, Segment, Track, TrackError, wrap_angle};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use std::f64::consts::TAU;

/// Mean width of the track, in widths of the car's body.
const WIDTH: f64 = 6.0;
/// Least radius, in radii at full steering lock and in mean widths; the larger one counts.
const LEAST_RADIUS: (f64, f64) = (2.0, 0.8);
/// Distance of a corner from the middle of the track, in least radii, from which a track's size
/// is drawn.
const SIZE: (f64, f64) = (6.0, 10.5);
/// Cornering speed at the least radius from which tracks grow longer than their bends [m/s].
const FAST: f64 = 12.0;
/// Distances of the corners from the middle, in sizes.
const CORNER: (f64, f64) = (0.35, 1.0);
/// Number of corners: least, and most plus one.
const CORNERS: (usize, usize) = (6, 11);
/// Largest turn of a corner [rad].
const MOST_TURN: f64 = 2.6;
/// Radii of corners, in least radii.
const RADIUS: (f64, f64) = (1.0, 2.5);
/// Straights as long as this get a chicane with this probability, in least radii.
const CHICANE: (f64, f64) = (10.0, 0.4);
/// Displacement of a chicane's two corners, in mean widths.
const CHICANE_WIDTHS: (f64, f64) = (0.6, 1.4);
/// Widths in corners, in mean widths.
const WIDTHS: (f64, f64) = (0.75, 1.15);
/// Least distance between stretches of the track that are not neighbours, in mean widths.
const CLEARANCE: f64 = 1.3;
/// Places closer than this along the line are neighbours, in mean widths.
const NEIGHBOURS: f64 = 3.0;
/// Draws before giving up.
const DRAWS: usize = 20_000;

/// Lengths that a car's tracks are made of [m].
struct Scale {
    width: f64,
    radius: f64,
    size: (f64, f64),
}

impl Scale {
    /// The lengths of this car.
    fn of(car: &CarSize<'_>) -> Self {
        let width = WIDTH * car.width;
        let radius = (LEAST_RADIUS.0 * car.lock).max(LEAST_RADIUS.1 * width);
        // The square of the cornering speed, in that of a fast car.
        let speed = car.grip * radius / (FAST * FAST);
        let size = radius * (1.0 + speed);
        Self { width, radius, size: (SIZE.0 * size, SIZE.1 * size) }
    }
}

/// A corner of the polygon.
#[derive(Clone, Copy)]
struct Corner {
    x: f64,
    y: f64,
    /// Radius of its arc before it is fitted between its neighbours [m].
    radius: f64,
    /// Width from edge to edge [m].
    width: f64,
}

/// A closed track at the scale of a car, the same for the same seed and car. Its lengths follow
/// from the car: the width is six bodies, the least radius twice that at full lock (or 0.8
/// widths), and the straights grow with the cornering speed. It never comes nearer to itself
/// than 1.3 widths.
///
/// # Errors
/// If the car's numbers are such that no track can be drawn; never for a car
/// whose parameters are in their ranges.
pub fn random<'a>(seed: u64, car: impl Into<CarSize<'a>>) -> Result<Track, TrackError> {
    let car = car.into();
    let scale = Scale::of(&car);
    let mut rng = Pcg64Mcg::seed_from_u64(seed);
    let name = format!("random_{}_{seed}", car.name);
    for _ in 0..DRAWS {
        let corners = polygon(&mut rng, &scale);
        let Some(segments) = rounded(&corners, &scale) else { continue };
        let half = 0.5 * scale.width;
        let track = Track::from_segments(&name, &segments, half, half);
        if let Ok(track) = track
            && keeps_apart(&track, scale.width)
        {
            return Ok(track);
        }
    }
    Err(TrackError::Value {
        item: format!("car {}", car.name),
        key: "width",
        found: car.width,
        expected: "a car with finite lengths, steering and friction",
    })
}

/// A number between the two.
fn between(rng: &mut Pcg64Mcg, range: (f64, f64)) -> f64 {
    range.0 + (range.1 - range.0) * rng.random::<f64>()
}

/// Corners around a middle, in the order of driving.
fn polygon(rng: &mut Pcg64Mcg, scale: &Scale) -> Vec<Corner> {
    let size = between(rng, scale.size);
    let count = rng.random_range(CORNERS.0..CORNERS.1);
    let side = if rng.random::<bool>() { 1.0 } else { -1.0 };
    let corner = |rng: &mut Pcg64Mcg, x: f64, y: f64| Corner {
        x,
        y,
        radius: scale.radius * between(rng, RADIUS),
        width: scale.width * between(rng, WIDTHS),
    };
    let around: Vec<Corner> = (0..count)
        .map(|k| {
            let angle = side * TAU * (k as f64 + between(rng, (-0.3, 0.3))) / count as f64;
            let distance = size * between(rng, CORNER);
            corner(rng, distance * libm::cos(angle), distance * libm::sin(angle))
        })
        .collect();
    let mut corners = Vec::new();
    for (k, a) in around.iter().enumerate() {
        let b = around[(k + 1) % count];
        corners.push(*a);
        let (dx, dy) = (b.x - a.x, b.y - a.y);
        let length = libm::hypot(dx, dy);
        if length > CHICANE.0 * scale.radius && rng.random::<f64>() < CHICANE.1 {
            let side = if rng.random::<bool>() { 1.0 } else { -1.0 };
            let off = side * scale.width * between(rng, CHICANE_WIDTHS) / length;
            let first = between(rng, (0.3, 0.45));
            for (part, off) in [(first, off), (first + between(rng, (0.15, 0.3)), -off)] {
                let (x, y) = (a.x + part * dx - off * dy, a.y + part * dy + off * dx);
                let mut corner = corner(rng, x, y);
                corner.radius *= 2.0;
                corners.push(corner);
            }
        }
    }
    corners
}

/// Straights and arcs through the corners, begun in the middle of the longest straight; none if a
/// corner does not fit between its neighbours.
fn rounded(corners: &[Corner], scale: &Scale) -> Option<Vec<Segment>> {
    let n = corners.len();
    let edge = |i: usize| {
        let (a, b) = (&corners[i % n], &corners[(i + 1) % n]);
        (b.x - a.x, b.y - a.y)
    };
    let length = |i: usize| libm::hypot(edge(i).0, edge(i).1);
    // The arc at corner i: signed radius, turn, and how much of both edges it takes.
    let mut arcs = Vec::with_capacity(n);
    for (i, corner) in corners.iter().enumerate() {
        let (before, after) = (edge(i + n - 1), edge(i));
        let turn = wrap_angle(libm::atan2(after.1, after.0) - libm::atan2(before.1, before.0));
        let room = 0.45 * length((i + n - 1) % n).min(length(i));
        let half = libm::tan(0.5 * turn.abs());
        let radius = corner.radius.min(room / half);
        if turn.abs() > MOST_TURN || radius < scale.radius {
            return None;
        }
        arcs.push((radius.copysign(turn), turn.abs(), radius * half));
    }
    let straight = |i: usize| length(i) - arcs[i].2 - arcs[(i + 1) % n].2;
    let longest = (0..n).max_by(|&a, &b| straight(a).total_cmp(&straight(b)))?;
    let half = |i: usize| (0.5 * corners[i % n].width, 0.5 * corners[i % n].width);
    let mean = |a: (f64, f64), b: (f64, f64)| (0.5 * (a.0 + b.0), 0.5 * (a.1 + b.1));
    let middle = mean(half(longest), half(longest + 1));
    let begin = Segment::straight(0.5 * straight(longest));
    let mut segments = vec![begin.with_taper(middle, half(longest + 1))];
    for k in 1..=n {
        let i = (longest + k) % n;
        let (radius, turn, _) = arcs[i];
        segments.push(Segment::arc(radius, turn).with_taper(half(i), half(i)));
        if k < n {
            segments.push(Segment::straight(straight(i)).with_taper(half(i), half(i + 1)));
        }
    }
    segments.push(begin.with_taper(half(longest), middle));
    Some(segments)
}

/// Whether stretches that are not neighbours keep apart.
fn keeps_apart(track: &Track, width: f64) -> bool {
    let step = 0.25 * width;
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let n = (track.length() / step).ceil() as usize;
    let step = track.length() / n as f64;
    let places: Vec<(f64, f64)> = (0..n).map(|i| track.position(i as f64 * step)).collect();
    places.iter().enumerate().all(|(i, a)| {
        places[..i].iter().enumerate().all(|(j, b)| {
            let along = (i - j).min(n - (i - j)) as f64 * step;
            along < NEIGHBOURS * width || libm::hypot(a.0 - b.0, a.1 - b.1) > CLEARANCE * width
        })
    })
}
