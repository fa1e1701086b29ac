//! The lane of a stage: where the centre of gravity must be for the body to keep its distance from the edges.

use nalgebra::Matrix6;
use vehicle_model::{Outline, State, Track};

use crate::controller::Setup;

/// Standard deviations of the estimated place of the body that the lane is narrower on each side.
const UNSURE: f64 = 2.0;
/// Most that it is narrower, as a share of the track's width.
const NARROWED: f64 = 0.1;

/// Heading error beyond which a plan is no help to keep the body inside [rad].
const ACROSS: f64 = 0.5;

/// Least and greatest e_y of a planned state; `unsure` is what the estimate of the pose asks for \[m\].
pub(crate) fn bounds(setup: &Setup, outline: Option<&Outline>, x: &State, unsure: f64) -> [f64; 2] {
    let (left, right) = (setup.track.width_left(x.s), setup.track.width_right(x.s));
    let margin = setup.config.limits.lane_margin + unsure.min(NARROWED * (left + right));
    let [left, right] = match outline {
        Some(outline) => room(outline, &setup.track, x),
        None => [left, right],
    };
    [margin - right, left - margin]
}

/// Room beside the body that the estimate of the pose asks for \[m\].
pub(crate) fn unsure(setup: &Setup, covariance: Option<&Matrix6<f64>>) -> f64 {
    let Some(p) = covariance else { return 0.0 };
    let reach = 0.5 * setup.car.length;
    UNSURE * (p[(5, 5)] + reach * reach * p[(3, 3)]).max(0.0).sqrt()
}

/// Room on either side of the centre line for the centre of gravity of a car that stands along it, which
/// leaves the body as far from the edges as that of `x` is \[m\].
fn room(outline: &Outline, track: &Track, x: &State) -> [f64; 2] {
    let e_psi = x.e_psi.clamp(-ACROSS, ACROSS);
    let [left, right] = outline.overhangs(track, &State { e_psi, ..*x });
    [x.e_y - left, -x.e_y - right].map(|room| room + outline.half_width)
}
