//! The body on a centre line that is a circle of the curvature at the centre of gravity, in closed form with
//! gradients: the second way to the same number.

use super::Outline;

/// Below this angle along the centre line a corner's arc length is its tangent \[rad\].
const SMALL_ANGLE: f64 = 1e-6;

/// A point of the body in the frame of the track.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct BodyPoint {
    /// Progress relative to that of the centre of gravity \[m\].
    pub(super) ds: f64,
    /// Lateral deviation, positive to the left \[m\].
    pub(super) e_y: f64,
    /// Change of `e_y` with the heading of the car e_psi \[m/rad\].
    pub(super) by_e_psi: f64,
    /// Change of `e_y` with the lateral deviation of the centre of gravity \[-\].
    pub(super) by_e_y: f64,
}

/// The points of the body that reach furthest to either side.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Extent {
    /// The point with the greatest e_y.
    pub(super) left: BodyPoint,
    /// The point with the least e_y.
    pub(super) right: BodyPoint,
}

impl Outline {
    /// How far the body reaches to either side where the centre line has the curvature `kappa`
    /// \[1/m\]: over the four corners, and over the point of each side that is nearest to the
    /// centre of curvature, which is where the inner edge of a bend reaches under a long car.
    ///
    /// Exact on a centre line of constant curvature over the length of the body. The gradients
    /// are those of the point found: the greatest of several functions changes as that one does.
    #[must_use]
    pub(super) fn extent(&self, kappa: f64, e_psi: f64, e_y: f64) -> Extent {
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
}

/// A point (forward, left) of the body on a centre line that is a circle: with (t, n) its offset
/// from the foot of the centre of gravity along the tangent and the normal, the distance from the
/// centre of curvature is h/kappa with h^2 = (kappa t)^2 + (1 - kappa n)^2. Written so that a
/// straight line, kappa = 0, is no special case for e_y.
pub(super) fn body_point(
    (forward, left): (f64, f64),
    kappa: f64,
    sin: f64,
    cos: f64,
    e_y: f64,
) -> BodyPoint {
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
