//! Two ways to how far the body reaches.

use super::closed_form::{Extent, body_point};
use super::*;
use crate::track::Segment;

fn iac() -> Outline {
    Outline::new(&CarParams::builtin("iac").unwrap())
}

/// A circle to the left or right, far wider than any body needs.
fn circle(radius: f64) -> Track {
    let half = Segment::arc(radius, std::f64::consts::PI);
    Track::from_segments("circle", &[half, half], 5.0, 5.0).unwrap()
}

const STATES: [(f64, f64); 6] =
    [(0.0, 0.0), (0.3, 1.0), (-0.7, 2.0), (1.2, -2.5), (-2.0, 0.5), (0.01, -1.0)];

#[test]
fn the_closed_form_is_the_projection_on_a_circle() {
    for radius in [12.0, -12.0, 300.0, -300.0] {
        let track = circle(radius);
        for (e_psi, e_y) in STATES {
            let x = State { v_x: 1.0, e_psi, s: 7.0, e_y, ..State::default() };
            let extent = iac().extent(1.0 / radius, e_psi, e_y);
            let closed = (extent.left.e_y - 5.0).max(-extent.right.e_y - 5.0);
            let [left, right] = iac().projected_overhangs(&track, &x);
            let projected = left.max(right);
            assert!((closed - projected).abs() < 1e-9, "{radius} {x:?}: {closed} {projected}");
        }
    }
}

#[test]
fn anywhere_on_a_track_it_is_the_projection() {
    let track = Track::builtin("l").unwrap();
    let outline = Outline::new(&CarParams::builtin("barc").unwrap());
    let mut closed = 0;
    for i in 0..400 {
        let s = track.length() * f64::from(i) / 400.0;
        for (e_psi, e_y) in [(0.0, 0.0), (0.2, 0.3), (-0.4, -0.45), (0.1, 0.6)] {
            let x = State { v_x: 1.0, e_psi, s, e_y, ..State::default() };
            closed += u32::from(outline.overhangs_on_a_circle(&track, &x).is_some());
            let projected = outline.projected_overhangs(&track, &x);
            for (found, projected) in outline.overhangs(&track, &x).iter().zip(projected) {
                assert!((found - projected).abs() < 1e-9, "{x:?}: {found} {projected}");
            }
        }
    }
    assert!(closed > 400, "{closed} of 1,600 in closed form");
}

/// Beside straights and arcs to both sides the lever is the slope of the overhang, where it has one: not
/// where either end may reach farther, nor near the heading at which the nearest point leaves the side.
#[test]
fn the_lever_of_the_heading_is_the_slope_of_the_overhang() {
    let outline = iac();
    let straight = Track::from_segments(
        "oval",
        &[
            Segment::straight(200.0),
            Segment::arc(30.0, std::f64::consts::PI),
            Segment::straight(200.0),
            Segment::arc(30.0, std::f64::consts::PI),
        ],
        5.0,
        5.0,
    )
    .unwrap();
    let mut compared = 0;
    for (track, s) in [(straight, 100.0), (circle(25.0), 7.0), (circle(-25.0), 7.0)] {
        let kappa = track.kappa(s);
        for i in -15_i32..=15 {
            for e_y in [-2.0, 0.0, 2.0] {
                let e_psi = 0.05 * f64::from(i);
                let at = |e_psi: f64| {
                    outline
                        .overhangs(&track, &State { v_x: 1.0, e_psi, s, e_y, ..State::default() })
                };
                let step = 1e-4;
                let slopes = [0, 1].map(|side| {
                    let [before, here, after] = [-step, 0.0, step].map(|d| at(e_psi + d)[side]);
                    let [rise, next] = [(here - before) / step, (after - here) / step];
                    ((rise - next).abs() < 0.02).then_some(0.5 * (rise + next))
                });
                let left = outline.reach_by_heading(kappa, e_psi, e_y);
                // On the right a lever of the sum e_y + lever e_psi is against that side's reach.
                let right = -outline.reach_by_heading(-kappa, -e_psi, -e_y);
                for (lever, slope) in [left, right].into_iter().zip(slopes) {
                    let Some(slope) = slope.filter(|_| e_psi.abs() > EITHER_END) else { continue };
                    compared += 1;
                    let most = 0.06 * outline.front.max(outline.rear) + 0.1 * slope.abs();
                    assert!((lever - slope).abs() < most, "{kappa} {e_psi} {e_y}: {lever} {slope}");
                }
            }
        }
    }
    assert!(compared > 400, "{compared}");
}

#[test]
fn no_point_of_the_body_reaches_further() {
    let outline = iac();
    for kappa in [0.0, 0.08, -0.08, 1e-9] {
        for (e_psi, e_y) in STATES {
            let extent = outline.extent(kappa, e_psi, e_y);
            let (sin, cos) = e_psi.sin_cos();
            let (mut left, mut right) = (f64::NEG_INFINITY, f64::INFINITY);
            for i in 0..=400 {
                let share = f64::from(i) / 400.0;
                let forward = -outline.rear + share * (outline.front + outline.rear);
                let across = outline.half_width * (2.0 * share - 1.0);
                for point in [
                    (forward, outline.half_width),
                    (forward, -outline.half_width),
                    (outline.front, across),
                    (-outline.rear, across),
                ] {
                    let reach = body_point(point, kappa, sin, cos, e_y).e_y;
                    left = left.max(reach);
                    right = right.min(reach);
                }
            }
            let gap = (extent.left.e_y - left).max(right - extent.right.e_y);
            assert!(gap > -1e-12, "{kappa} {e_psi} {e_y}: {gap}");
            assert!(gap < 2e-3, "and the point found is one of the body: {gap}");
        }
    }
}

#[test]
fn gradients_are_differences() {
    let (outline, step) = (iac(), 1e-6);
    for kappa in [0.0, 0.05, -0.03] {
        for (e_psi, e_y) in [(0.02, 0.4), (-0.3, 1.5), (0.6, -2.0)] {
            let at = |psi: f64, y: f64| outline.extent(kappa, e_psi + psi, e_y + y);
            let here = at(0.0, 0.0);
            let slope = |a: Extent, b: Extent, side: fn(&Extent) -> f64| {
                (side(&a) - side(&b)) / (2.0 * step)
            };
            for (point, side) in [
                (here.left, (|e: &Extent| e.left.e_y) as fn(&Extent) -> f64),
                (here.right, |e| e.right.e_y),
            ] {
                let by_psi = slope(at(step, 0.0), at(-step, 0.0), side);
                let by_y = slope(at(0.0, step), at(0.0, -step), side);
                assert!((point.by_e_psi - by_psi).abs() < 1e-7, "{point:?} {by_psi}");
                assert!((point.by_e_y - by_y).abs() < 1e-7, "{point:?} {by_y}");
            }
        }
    }
}

#[test]
fn the_inner_side_reaches_over_the_inner_edge_of_a_tight_bend() {
    // Along the tangent at radius r the middle of the side is the nearest point: it reaches
    // exactly half a width, the corners less.
    let outline = Outline { front: 2.0, rear: 2.0, half_width: 1.0 };
    let extent = outline.extent(0.1, 0.0, 0.0);
    assert!((extent.left.e_y - 1.0).abs() < 1e-12);
    let corner = 10.0 - f64::hypot(2.0, 11.0);
    assert!((extent.right.e_y - corner).abs() < 1e-12);
}

#[test]
fn the_corner_is_compared_with_the_edge_at_its_own_place() {
    let segments = [
        Segment::straight(20.0).with_taper((4.0, 4.0), (2.0, 4.0)),
        Segment::arc(10.0, std::f64::consts::PI).with_widths(2.0, 4.0),
        Segment::straight(20.0).with_widths(2.0, 4.0),
        Segment::arc(10.0, std::f64::consts::PI).with_taper((2.0, 4.0), (4.0, 4.0)),
    ];
    let track = Track::from_segments("taper", &segments, 4.0, 4.0).unwrap();
    let outline = Outline { front: 2.0, rear: 2.0, half_width: 1.0 };
    let x = State { s: 10.0, e_y: 1.5, ..State::default() };
    // The front left corner at s = 12: the edge there is at 2.8 m.
    assert!((outline.overhang(&track, &x) - (2.5 - 2.8)).abs() < 1e-9);
}
