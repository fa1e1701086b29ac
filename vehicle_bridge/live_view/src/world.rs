//! What stays the same along a drive: the track, the car, the time-optimal lap.

use lcm_types::Track;
use log_export::scene::on_track;
use serde::Serialize;
use vehicle_model::Outline;

use crate::lap::short;
use crate::reference::Reference;

/// Points of an edge that a page gets, at most. \[-\]
const POINTS: usize = 2000;
/// Length of a car that is not known, in widths of the track, and its width in lengths. \[-\]
const UNKNOWN: (f64, f64) = (0.4, 0.5);

/// The track and what drives on it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct World {
    name: String,
    length: f64,
    closed: bool,
    /// Points [x, y] of both edges and of the centre line.
    left: Vec<[f64; 2]>,
    right: Vec<[f64; 2]>,
    centre: Vec<[f64; 2]>,
    car: CarBody,
    optimum: Option<Line>,
}

/// The car's body and the limits of its inputs.
#[derive(Debug, Clone, PartialEq, Serialize)]
struct CarBody {
    name: String,
    /// Its parameters are known; otherwise the outline is a guess and there are no limits.
    known: bool,
    front: f64,
    rear: f64,
    half_width: f64,
    a_min: f64,
    a_max: f64,
    delta_max: f64,
    v_max: f64,
}

/// The time-optimal lap: points [t, s, x, y, v_x].
#[derive(Debug, Clone, PartialEq, Serialize)]
struct Line {
    time: f64,
    samples: Vec<[f64; 5]>,
}

impl World {
    pub(crate) fn new(track: &Track, named: &str, reference: Option<&Reference>) -> Self {
        let point = |s: f64, e_y: f64| on_track(track, s, e_y).map(|(x, y)| [short(x), short(y)]);
        let every = track.s.len().div_ceil(POINTS).max(1);
        let places = || track.s.iter().step_by(every).map(|s| f64::from(*s));
        let edge = |widths: &[f32], side: f64| {
            let at = |(s, width): (f64, &f32)| point(s, side * f64::from(*width));
            places().zip(widths.iter().step_by(every)).filter_map(at).collect()
        };
        let optimum = reference.and_then(|reference| reference.optimum.as_ref());
        Self {
            name: track.name.clone(),
            length: track.length,
            closed: track.closed,
            left: edge(&track.w_left, 1.0),
            right: edge(&track.w_right, -1.0),
            centre: places().filter_map(|s| point(s, 0.0)).collect(),
            car: car(track, named, reference),
            optimum: optimum.map(|known| Line {
                time: known.lap_time_s,
                samples: known
                    .points
                    .iter()
                    .filter_map(|&[s, t, v_x, e_y]| {
                        let [x, y] = point(s.min(track.length), e_y)?;
                        Some([short(t), short(s), x, y, short(v_x)])
                    })
                    .collect(),
            }),
        }
    }
}

fn car(track: &Track, named: &str, reference: Option<&Reference>) -> CarBody {
    if let Some(Reference { car, .. }) = reference {
        let body = Outline::new(car);
        return CarBody {
            name: car.name.clone(),
            known: true,
            front: body.front,
            rear: body.rear,
            half_width: body.half_width,
            a_min: car.a_min,
            a_max: car.a_max,
            delta_max: car.delta_max,
            v_max: car.speed_max.unwrap_or(f64::NAN),
        };
    }
    let first = |widths: &[f32]| widths.first().copied().map_or(0.5, f64::from);
    let length = UNKNOWN.0 * (first(&track.w_left) + first(&track.w_right));
    CarBody {
        name: named.to_owned(),
        known: false,
        front: 0.5 * length,
        rear: 0.5 * length,
        half_width: 0.5 * UNKNOWN.1 * length,
        a_min: f64::NAN,
        a_max: f64::NAN,
        delta_max: f64::NAN,
        v_max: f64::NAN,
    }
}
