//! Where the car is, and where a stop would take it.

use vehicle_model::{Input, State, Track};

use super::super::hold::Hold;
use super::super::rules::Rules;
use super::super::stop;
use super::{DoubtFinding, DoubtLimits, Suspicion};

/// A race on the edge of the track cannot everywhere be stopped inside it: that is reported, no more.
/// \[-\]
const REPORTED: f64 = 0.7;
/// Step and longest time of a predicted stop. \[s\]
const STEP: f64 = 0.02;
const LONGEST: f64 = 12.0;

/// How far the farthest corner of the body is beyond the edge, negative inside. \[m\]
pub(crate) fn beyond(rules: &Rules, x: &State) -> f64 {
    let car = &rules.rolling.params;
    let (sin, cos) = x.e_psi.sin_cos();
    let corners = [(0.5, 0.5), (0.5, -0.5), (-0.5, 0.5), (-0.5, -0.5)];
    let out = corners.map(|(along, across)| {
        let (forward, left) = (along * car.length, across * car.width);
        let s = x.s + forward * cos - left * sin;
        edge(&rules.track, s, x.e_y + forward * sin + left * cos)
    });
    out.into_iter().fold(f64::NEG_INFINITY, f64::max)
}

fn edge(track: &Track, s: f64, e_y: f64) -> f64 {
    (e_y - track.width_left(s)).max(-e_y - track.width_right(s))
}

/// The rules that look at the place alone.
pub(super) fn here(rules: &Rules, limits: &DoubtLimits, x: &State) -> DoubtFinding {
    let off = beyond(rules, x) / limits.edge;
    let off = DoubtFinding { what: Suspicion::OffTrack, level: off.max(0.0) };
    off.or(DoubtFinding { what: Suspicion::WrongWay, level: x.e_psi.abs() / limits.heading })
}

/// The rules of the place, now and at the end of a stop that begins now.
pub(super) fn finding(rules: &Rules, limits: &DoubtLimits, x: &State) -> DoubtFinding {
    let here = here(rules, limits, x);
    let stopped = beyond_at_stop(rules, x) / limits.stop_edge;
    here.or(DoubtFinding { what: Suspicion::Overspeed, level: stopped.clamp(0.0, REPORTED) })
}

/// How far a safe stop takes the centre of mass beyond the edge, negative inside. \[m\]
fn beyond_at_stop(rules: &Rules, x: &State) -> f64 {
    let mut x = *x;
    let (mut worst, mut input) = (edge(&rules.track, x.s, x.e_y), Input::default());
    let mut time = 0.0;
    while x.v_x > 0.5 && time < LONGEST {
        let asked = stop::brake(rules, &x, Hold::default());
        input = rules.limiter.limit(asked, input, x.v_x, STEP).sent;
        x = stop::roll(rules, &rules.sliding[0], &x, input, (STEP, 0.01), rules.track.kappa(x.s));
        worst = worst.max(edge(&rules.track, x.s, x.e_y));
        time += STEP;
    }
    worst
}
