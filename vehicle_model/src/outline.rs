//! The body of a car seen from above: a rectangle, and how far it reaches across the track.
//!
//! Two ways to the same number. [`Outline::extent`] takes the centre line for a circle of the
//! curvature at the centre of gravity: closed form with gradients, for the rows of an optimal
//! control problem. [`Outline::overhang`] projects points of the body onto the centre line and
//! compares each with the edge at its own place: exact on any track, for judging what was driven.

use crate::params::CarParams;
use crate::state::State;
use crate::track::Track;

/// Below this angle along the centre line a corner's arc length is its tangent \[rad\].
const SMALL_ANGLE: f64 = 1e-6;

/// A rectangle around the centre of gravity, in the frame of the body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Outline {
    /// Centre of gravity to the front end \[m\].
    pub front: f64,
    /// Centre of gravity to the rear end, positive \[m\].
    pub rear: f64,
    /// Centre of gravity to either side \[m\].
    pub half_width: f64,
}

/// A point of the body in the frame of the track.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BodyPoint {
    /// Progress relative to that of the centre of gravity \[m\].
    pub ds: f64,
    /// Lateral deviation, positive to the left \[m\].
    pub e_y: f64,
    /// Change of `e_y` with the heading of the car e_psi \[m/rad\].
    pub by_e_psi: f64,
    /// Change of `e_y` with the lateral deviation of the centre of gravity \[-\].
    pub by_e_y: f64,
}

/// The points of the body that reach furthest to either side.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Extent {
    /// The point with the greatest e_y.
    pub left: BodyPoint,
    /// The point with the least e_y.
    pub right: BodyPoint,
}

impl Outline {
    /// The body of a car: `length` by `width`, its middle half-way between the axles.
    ///
    /// Car files do not state the overhangs; equal ones put the centre of gravity
    /// (l_f - l_r)/2 behind the middle of the body.
    #[must_use]
    pub fn new(car: &CarParams) -> Self {
        let middle = 0.5 * (car.l_f - car.l_r);
        Self {
            front: 0.5 * car.length + middle,
            rear: 0.5 * car.length - middle,
            half_width: 0.5 * car.width,
        }
    }

    /// The corners (forward, left) in the frame of the body: front left, front right, rear left,
    /// rear right \[m\].
    #[must_use]
    pub fn corners(&self) -> [(f64, f64); 4] {
        let (front, rear, side) = (self.front, -self.rear, self.half_width);
        [(front, side), (front, -side), (rear, side), (rear, -side)]
    }

    /// How far the body reaches to either side where the centre line has the curvature `kappa`
    /// \[1/m\]: over the four corners, and over the point of each side that is nearest to the
    /// centre of curvature, which is where the inner edge of a bend reaches under a long car.
    ///
    /// Exact on a centre line of constant curvature over the length of the body. The gradients
    /// are those of the point found: the greatest of several functions changes as that one does.
    #[must_use]
    pub fn extent(&self, kappa: f64, e_psi: f64, e_y: f64) -> Extent {
        let (sin, cos) = libm::sincos(e_psi);
        let at = |point| body_point(point, kappa, sin, cos, e_y);
        let first = at((self.front, self.half_width));
        let mut extent = Extent { left: first, right: first };
        let nearest = self.nearest_points(kappa, e_psi, e_y);
        for point in self.corners().into_iter().skip(1).chain(nearest.into_iter().flatten()) {
            let point = at(point);
            if point.e_y > extent.left.e_y {
                extent.left = point;
            }
            if point.e_y < extent.right.e_y {
                extent.right = point;
            }
        }
        extent
    }

    /// How far the body reaches beyond the edges of the track, at its worst point \[m\]: positive
    /// outside, and minus the least distance to an edge while the whole body is inside.
    ///
    /// Each corner is compared with the width at its own foot on the centre line, and so is the
    /// point of each side nearest to the centre of curvature.
    #[must_use]
    pub fn overhang(&self, track: &Track, x: &State) -> f64 {
        let [left, right] = self.overhangs(track, x);
        left.max(right)
    }

    /// [`Outline::overhang`] beyond the left edge and beyond the right edge \[m\].
    #[must_use]
    pub fn overhangs(&self, track: &Track, x: &State) -> [f64; 2] {
        let centre = track.to_global(x);
        let (sin, cos) = libm::sincos(centre.psi);
        let beyond = |(forward, left): (f64, f64)| {
            let (x_p, y_p) =
                (centre.x + forward * cos - left * sin, centre.y + forward * sin + left * cos);
            let foot = track.project(x_p, y_p, Some(x.s));
            [foot.e_y - track.width_left(foot.s), -foot.e_y - track.width_right(foot.s)]
        };
        let nearest = self.nearest_points(track.kappa(x.s), x.e_psi, x.e_y);
        let points = self.corners().into_iter().chain(nearest.into_iter().flatten());
        points.map(beyond).fold([f64::NEG_INFINITY; 2], |[left, right], [more_left, more_right]| {
            [left.max(more_left), right.max(more_right)]
        })
    }

    /// The points of the four sides nearest to the centre of curvature; none where that is a
    /// corner, or the centre line is straight.
    fn nearest_points(&self, kappa: f64, e_psi: f64, e_y: f64) -> [Option<(f64, f64)>; 4] {
        if kappa == 0.0 {
            return [None; 4];
        }
        // The centre of curvature lies on the normal, at 1/kappa.
        let distance = 1.0 / kappa - e_y;
        let (sin, cos) = libm::sincos(e_psi);
        let (forward, left) = (distance * sin, distance * cos);
        let beside = forward > -self.rear && forward < self.front;
        let ahead = left.abs() < self.half_width;
        let side = |y: f64| beside.then_some((forward, y));
        let end = |x: f64| ahead.then_some((x, left));
        [side(self.half_width), side(-self.half_width), end(self.front), end(-self.rear)]
    }
}

/// A point (forward, left) of the body on a centre line that is a circle: with (t, n) its offset
/// from the foot of the centre of gravity along the tangent and the normal, the distance from the
/// centre of curvature is h/kappa with h^2 = (kappa t)^2 + (1 - kappa n)^2. Written so that a
/// straight line, kappa = 0, is no special case for e_y.
fn body_point((forward, left): (f64, f64), kappa: f64, sin: f64, cos: f64, e_y: f64) -> BodyPoint {
    let (t, n) = (forward * cos - left * sin, e_y + forward * sin + left * cos);
    let (along, across) = (kappa * t, 1.0 - kappa * n);
    let h = libm::hypot(along, across);
    let angle = libm::atan2(along, across);
    let ds = if angle.abs() < SMALL_ANGLE { t / across } else { angle / kappa };
    // The unit normal of the centre line at the point's own foot, in the frame of (t, n).
    let (normal_t, normal_n) = (-along / h, across / h);
    BodyPoint {
        ds,
        e_y: (2.0 * n - kappa * (t * t + n * n)) / (1.0 + h),
        by_e_psi: normal_t * (e_y - n) + normal_n * t,
        by_e_y: normal_n,
    }
}

#[cfg(test)]
mod tests {
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
                let projected = iac().overhang(&track, &x);
                assert!((closed - projected).abs() < 1e-9, "{radius} {x:?}: {closed} {projected}");
            }
        }
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
}
