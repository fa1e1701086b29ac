//! The lane of a stage: where the centre of gravity must be for the body to keep its distance from the edges.
//!
//! ```text
//! least <= e_y + heading e_psi <= greatest
//! ```
//!
//! linearised at the planned state: a drifting car whose corner is near an edge gets away from it by turning
//! as well as by moving.

use nalgebra::Matrix6;
use vehicle_model::{Outline, State, Track};

use crate::controller::Setup;
use crate::fhocp::Fhocp;

/// What the first learned lap keeps free more than later ones, in reserves beside the body: it meets
/// speeds and edges that no lap has tried.
const UNTRIED: f64 = 2.0;
/// What of that is left with each learned lap.
const LEFT: f64 = 0.75;
/// Most that the lane is narrower on each side, as a share of the track's width.
const NARROWED: f64 = 0.1;

/// Heading error beyond which a plan is no help to keep the body inside [rad].
const ACROSS: f64 = 1.0;

/// Bounds on `e_y + heading e_psi` near a planned state.
pub(crate) struct Lane {
    /// What the heading adds [m/rad].
    pub(crate) heading: f64,
    /// Least sum \[m\].
    pub(crate) least: f64,
    /// Greatest sum \[m\].
    pub(crate) greatest: f64,
}

impl Lane {
    /// Bounds the end of stage t of a problem.
    pub(crate) fn bound(&self, problem: &mut Fhocp, t: usize) {
        problem.lane_heading[t] = self.heading;
        problem.e_y_min[t] = self.least;
        problem.e_y_max[t] = self.greatest;
    }
}

/// The lane that keeps `more` free beside the lane margin. The heading counts as it does at the nearer edge.
pub(crate) fn bounds(setup: &Setup, outline: Option<&Outline>, x: &State, more: f64) -> Lane {
    let (left, right) = (setup.track.width_left(x.s), setup.track.width_right(x.s));
    let margin = setup.config.limits.lane_margin + more.min(NARROWED * (left + right));
    let Some(outline) = outline else {
        return Lane { heading: 0.0, least: margin - right, greatest: left - margin };
    };
    let e_psi = x.e_psi.clamp(-ACROSS, ACROSS);
    let [left, right] = room(outline, &setup.track, &State { e_psi, ..*x });
    let kappa = setup.track.kappa(x.s);
    let heading = if left - x.e_y < right + x.e_y {
        outline.reach_by_heading(kappa, e_psi, x.e_y)
    } else {
        outline.reach_by_heading(-kappa, -e_psi, -x.e_y)
    };
    let here = heading * x.e_psi;
    Lane { heading, least: margin - right + here, greatest: left - margin + here }
}

/// Room beside the body for the spread of its place under this covariance of the state \[m\].
pub(crate) fn unsure(setup: &Setup, covariance: &Matrix6<f64>) -> f64 {
    let reach = 0.5 * setup.car.length;
    let variance = covariance[(5, 5)] + reach * reach * covariance[(3, 3)];
    setup.config.limits.uncertainty * variance.max(0.0).sqrt()
}

/// Room beside the body that the first laps keep after so many learned ones \[m\].
pub(crate) fn untried(setup: &Setup, laps: u32) -> f64 {
    let limits = &setup.config.limits;
    if limits.uncertainty == 0.0 {
        return 0.0;
    }
    let reserve = (limits.lane_margin - 0.5 * setup.car.width).max(0.0);
    UNTRIED * reserve * libm::pow(LEFT, f64::from(laps))
}

/// Room on either side of the centre line for the centre of gravity of a car that stands along it, which
/// leaves the body as far from the edges as that of `x` is \[m\].
fn room(outline: &Outline, track: &Track, x: &State) -> [f64; 2] {
    let [left, right] = outline.overhangs(track, x);
    [x.e_y - left, -x.e_y - right].map(|room| room + outline.half_width)
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use vehicle_model::CarParams;

    use super::*;
    use crate::config::Config;
    use crate::controller::Controller;
    use crate::presets::Preset;

    /// What the row leaves at another heading is what the outline leaves there.
    #[test]
    fn a_plan_gets_away_from_an_edge_by_turning_as_the_body_does() {
        let car = CarParams::builtin("f1tenth").unwrap();
        let track = Arc::new(Track::builtin("l").unwrap());
        let config = Config::derived(Preset::Race, &car, &track);
        let setup = Controller::new(config, car.clone(), track.clone()).unwrap().setup;
        let outline = Outline::new(&car);
        let margin = setup.config.limits.lane_margin;
        let mut turned_away: f64 = 0.0;
        for s in [1.12, 6.0] {
            for (e_psi, e_y) in [(0.6, 0.2), (-0.6, 0.2), (0.3, -0.2), (-0.3, -0.2), (0.7, -0.2)] {
                let x = State { v_x: 3.0, s, e_psi, e_y, ..State::default() };
                let lane = bounds(&setup, Some(&outline), &x, 0.0);
                for turn in [-0.05, 0.05] {
                    let turned = State { e_psi: e_psi + turn, ..x };
                    let sum = e_y + lane.heading * turned.e_psi;
                    let [left, right] = outline.overhangs(&track, &turned);
                    let (row, body) = if left > right {
                        (lane.greatest - sum, outline.half_width - margin - left)
                    } else {
                        (sum - lane.least, outline.half_width - margin - right)
                    };
                    assert!((row - body).abs() < 0.002, "{s} {e_psi} {e_y}: {row} {body}");
                    let still = outline.overhangs(&track, &x);
                    turned_away = turned_away.max(still[0].max(still[1]) - left.max(right));
                }
            }
        }
        assert!(turned_away > 0.005, "{turned_away}");
    }

    /// On a straight a body at the end of its room touches the edge with a corner, as its rotation says.
    #[test]
    fn a_body_across_the_track_has_the_room_that_its_corners_leave() {
        let car = CarParams::builtin("f1tenth").unwrap();
        let track = Track::builtin("l").unwrap();
        let outline = Outline::new(&car);
        let s = 1.12;
        assert_eq!(track.even_around(s, car.length).map(|(kappa, _)| kappa), Some(0.0));
        for e_psi in [-0.9, -0.7, -0.4, 0.0, 0.4, 0.9] {
            let x = State { s, e_psi, e_y: 0.05, ..State::default() };
            let [left, right] = room(&outline, &track, &x);
            let (sin, cos) = libm::sincos(e_psi);
            let across = outline.corners().map(|(forward, left)| forward * sin + left * cos);
            let [most, least] = [
                across.iter().fold(f64::MIN, |a, b| a.max(*b)),
                across.iter().fold(f64::MAX, |a, b| a.min(*b)),
            ];
            let [to_left, to_right] = [left - outline.half_width, outline.half_width - right];
            assert!((to_left + most - track.width_left(s)).abs() < 1e-9, "{e_psi} {to_left}");
            assert!((to_right + least + track.width_right(s)).abs() < 1e-9, "{e_psi} {to_right}");
        }
    }
}
