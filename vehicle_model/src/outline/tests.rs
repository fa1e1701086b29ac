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
