//! The body of a car seen from above: a rectangle, and how far it reaches across the track.
//!
//! [`Outline::overhang`] projects points of the body onto the centre line and compares each with the edge
//! at its own place: exact on any track, for plans and for judging what was driven. Around a body on a straight or
//! an arc with even edges a closed form gives the same.

use crate::params::CarParams;
use crate::state::State;
use crate::track::Track;

/// How far from the foot of the centre of gravity those of the body may lie for the closed form, in
/// lengths of the body.
const AROUND: f64 = 2.0;

/// Heading error up to which either end may be the one that reaches farther to a side [rad].
const EITHER_END: f64 = 0.1;

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
        self.overhangs_on_a_circle(track, x).unwrap_or_else(|| self.projected_overhangs(track, x))
    }

    /// [`Outline::overhangs`] in closed form where road and edges are even around the body.
    fn overhangs_on_a_circle(&self, track: &Track, x: &State) -> Option<[f64; 2]> {
        let length = libm::hypot(self.front.max(self.rear), self.half_width);
        let (kappa, width) = track.even_around(x.s, AROUND * length)?;
        let (sin, cos) = libm::sincos(x.e_psi);
        let nearest = self.nearest_points(kappa, x.e_psi, x.e_y);
        let points = self.corners().into_iter().chain(nearest.into_iter().flatten());
        let mut reach = [f64::NEG_INFINITY, f64::INFINITY];
        for (forward, left) in points {
            let (t, n) = (forward * cos - left * sin, x.e_y + forward * sin + left * cos);
            let (along, across) = (kappa * t, 1.0 - kappa * n);
            // Its foot is nearer than t / across.
            if across * AROUND < 1.0 {
                return None;
            }
            let h = (along * along + across * across).sqrt();
            let e_y = (2.0 * n - kappa * (t * t + n * n)) / (1.0 + h);
            reach = [reach[0].max(e_y), reach[1].min(e_y)];
        }
        let found = [reach[0] - width[0], -reach[1] - width[1]];
        // Farther off the foot may be on another part of the track.
        (found[0].max(found[1]) < length).then_some(found)
    }

    /// [`Outline::overhangs`] by projection.
    fn projected_overhangs(&self, track: &Track, x: &State) -> [f64; 2] {
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

    /// How much farther the body reaches to the left with its heading, about [m/rad]: the lever of the
    /// corner that reaches farthest, or of the side's point nearest to a centre of curvature there.
    /// Mirrored arguments give that to the right.
    #[must_use]
    pub fn reach_by_heading(&self, kappa: f64, e_psi: f64, e_y: f64) -> f64 {
        let (sin, cos) = libm::sincos(e_psi);
        let share = (0.5 + 0.5 * e_psi / EITHER_END).clamp(0.0, 1.0);
        let mut forward = share * self.front - (1.0 - share) * self.rear;
        if kappa > 0.0 {
            let nearest = (1.0 / kappa - e_y).max(0.0) * sin;
            forward = nearest.clamp(forward.min(0.0), forward.max(0.0));
        }
        forward * cos - self.half_width * sin
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

#[cfg(test)]
mod closed_form;
#[cfg(test)]
mod tests;
