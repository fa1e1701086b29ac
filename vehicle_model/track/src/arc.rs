//! One piece of constant curvature: a straight or an arc of a circle, exact.
//!
//! With u the distance from the piece's beginning, the chord has the length
//! u sinc(kappa u / 2) and the direction psi_0 + kappa u / 2. The same formula holds for a
//! straight, and loses no digits for very large radii.

/// A straight or an arc with its starting pose.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Arc {
    /// Distance along the track at the beginning [m].
    pub s: f64,
    /// Length [m].
    pub length: f64,
    /// Curvature, positive to the left [1/m].
    pub kappa: f64,
    /// Position at the beginning [m].
    pub x: f64,
    /// Position at the beginning [m].
    pub y: f64,
    /// Heading at the beginning, continuous along the lap [rad].
    pub psi: f64,
}

/// sin(a) / a, continued at 0.
fn sinc(a: f64) -> f64 {
    if a.abs() < 1e-8 { 1.0 } else { libm::sin(a) / a }
}

impl Arc {
    /// Pose (x, y, psi) at distance u from the beginning.
    pub(super) fn pose(&self, u: f64) -> (f64, f64, f64) {
        let half = 0.5 * self.kappa * u;
        let (sin, cos) = libm::sincos(self.psi + half);
        let chord = u * sinc(half);
        (self.x + chord * cos, self.y + chord * sin, self.psi + 2.0 * half)
    }

    /// Distance u in [0, length] of the nearest point of the piece.
    pub(super) fn foot(&self, x: f64, y: f64) -> f64 {
        let (sin, cos) = libm::sincos(self.psi);
        let (dx, dy) = (x - self.x, y - self.y);
        let (along, across) = (dx * cos + dy * sin, dy * cos - dx * sin);
        // Around the centre of the circle; the angle is taken nearest to the middle of the arc,
        // so that the nearest end follows by clamping for arcs of up to a full turn.
        let radial = 1.0 - self.kappa * across;
        let mut u = if self.kappa == 0.0 {
            along
        } else {
            let middle = 0.5 * self.kappa * self.length;
            let angle = libm::atan2(self.kappa * along, radial);
            0.5 * self.length + super::frenet::wrap_angle(angle - middle) / self.kappa
        };
        if !(u > 0.0 && u < self.length) {
            return if u > 0.0 { self.length } else { 0.0 };
        }
        if self.kappa != 0.0 {
            // The angle around a far centre has lost digits; one Newton step brings them back.
            let (x_u, y_u, psi_u) = self.pose(u);
            let (sin, cos) = libm::sincos(psi_u);
            let (dx, dy) = (x - x_u, y - y_u);
            let stretch = 1.0 - self.kappa * (dy * cos - dx * sin);
            if stretch > 1e-6 {
                u += (dx * cos + dy * sin) / stretch;
            }
        }
        u.clamp(0.0, self.length)
    }
}
