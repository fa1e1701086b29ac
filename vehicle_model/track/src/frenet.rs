//! Between the global frame and the Frenet frame of the centre line.
//!
//! A point is r(s) + e_y n(s) with the unit normal n to the left. Its s is where the distance
//! to the centre line is least, which needs 1 - kappa e_y > 0.

use super::{GlobalState, State, Track};
use std::f64::consts::{PI, TAU};

/// How far a warm projection follows the centre line from its hint, in widths of the track.
const WINDOW_WIDTHS: f64 = 10.0;

/// Pieces looked at together in a cold projection.
const BLOCK: usize = 32;
/// Allowance for the arc length of a spline not being exactly its parameter.
const SLACK: f64 = 1.001;

/// The foot of a point on the centre line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Projection {
    /// Progress along the centre line, in [0, L) \[m\].
    pub s: f64,
    /// Signed distance from the centre line, positive to the left \[m\].
    pub e_y: f64,
    /// Heading of the centre line at s, continuous along the lap \[rad\].
    pub heading: f64,
}

/// The angle brought into (-pi, pi] \[rad\].
#[must_use]
pub fn wrap_angle(angle: f64) -> f64 {
    if angle > -PI && angle <= PI {
        return angle;
    }
    let wrapped = angle.rem_euclid(TAU);
    if wrapped > PI { wrapped - TAU } else { wrapped }
}

/// The place `e_y` to the left of a pose x, y, psi.
fn to_the_left((x, y, psi): (f64, f64, f64), e_y: f64) -> (f64, f64) {
    let (sin, cos) = libm::sincos(psi);
    (x - e_y * sin, y + e_y * cos)
}

impl Track {
    /// Pose and velocities in the global frame of a state in the Frenet frame. `psi` is the
    /// centre line's heading, continuous along the lap, plus `e_psi`.
    #[must_use]
    pub fn to_global(&self, x: &State) -> GlobalState {
        let pose = self.pose(x.s);
        let place = to_the_left(pose, x.e_y);
        GlobalState {
            x: place.0,
            y: place.1,
            psi: pose.2 + x.e_psi,
            v_x: x.v_x,
            v_y: x.v_y,
            omega_z: x.omega_z,
        }
    }

    /// The place at s, `e_y` to the left of the centre line: x, y \[m\].
    #[must_use]
    pub fn beside(&self, s: f64, e_y: f64) -> (f64, f64) {
        to_the_left(self.pose(s), e_y)
    }

    /// State in the Frenet frame of a pose and its velocities; `e_psi` in (-pi, pi]. The hint
    /// is that of [`Track::project`]. Where the track crosses itself on a bridge and there is no
    /// usable hint, the passage counts whose heading is nearest to that of the car.
    #[must_use]
    pub fn to_frenet(&self, g: &GlobalState, hint: Option<f64>) -> State {
        let foot = self.project_near(g.x, g.y, hint, || {
            if self.bridges.is_empty() {
                return self.nearest(g.x, g.y);
            }
            self.nearest_heading(g).unwrap_or_else(|| self.nearest(g.x, g.y))
        });
        State {
            v_x: g.v_x,
            v_y: g.v_y,
            omega_z: g.omega_z,
            e_psi: wrap_angle(g.psi - foot.heading),
            s: foot.s,
            e_y: foot.e_y,
        }
    }

    /// Foot of the point (x, y) \[m\] on the centre line.
    ///
    /// With a hint (the last s, in any lap \[m\]) the search follows the centre line downhill
    /// from there, so that a track passing near itself does not catch the point on its other
    /// branch. Without one the nearest point of the whole track is taken; so it is when the hint
    /// turns out to be wrong: no foot within ten track widths of it, or a foot from which the
    /// point is more than a track width beyond the edge, while the nearest one has it inside.
    #[must_use]
    pub fn project(&self, x: f64, y: f64, hint: Option<f64>) -> Projection {
        self.project_near(x, y, hint, || self.nearest(x, y))
    }

    /// [`Track::project`] with the piece and the distance in it that count without a hint.
    fn project_near(
        &self,
        x: f64,
        y: f64,
        hint: Option<f64>,
        nearest: impl Fn() -> (usize, f64),
    ) -> Projection {
        let hint = hint.filter(|s| s.is_finite());
        let Some((i, u)) = hint.and_then(|s| self.follow(x, y, self.wrap(s))) else {
            let (i, u) = nearest();
            return self.foot(i, u, x, y);
        };
        let warm = self.foot(i, u, x, y);
        if self.beyond_edge(&warm) > self.max_width {
            let (i, u) = nearest();
            let cold = self.foot(i, u, x, y);
            if self.beyond_edge(&cold) <= 0.0 {
                return cold;
            }
        }
        warm
    }

    /// The projection of (x, y) whose foot lies at distance u in piece i.
    fn foot(&self, i: usize, u: f64, x: f64, y: f64) -> Projection {
        let (x_c, y_c, heading) = self.path.pose_in(i, u);
        let (sin, cos) = libm::sincos(heading);
        let e_y = (y - y_c) * cos - (x - x_c) * sin;
        let s = self.wrap(self.path.start_of(i) + u);
        // The end of the lap is its beginning: same point, heading one turn earlier.
        let heading = if s == 0.0 { self.heading(0.0) } else { heading };
        Projection { s, e_y, heading }
    }

    /// How far the point of a projection is beyond the edge on its side, negative inside [m].
    fn beyond_edge(&self, foot: &Projection) -> f64 {
        let (left, right) = self.widths.at(foot.s);
        if foot.e_y > 0.0 { foot.e_y - left } else { -foot.e_y - right }
    }

    /// Piece and distance in it of the foot reached by going downhill from s; `None` if it is
    /// further away than the window.
    fn follow(&self, x: f64, y: f64, s: f64) -> Option<(usize, f64)> {
        let n = self.path.len();
        let window = (WINDOW_WIDTHS * self.max_width).min(0.25 * self.length());
        let mut i = self.path.index_of(s);
        let mut from = (s - self.path.start_of(i)).clamp(0.0, self.path.length_of(i));
        let mut went = 0.0;
        let mut direction = 0_i8;
        while went <= window {
            let u = self.path.foot_in(i, x, y);
            went += (u - from).abs();
            if went > window {
                return None;
            }
            let length = self.path.length_of(i);
            if u >= length && direction >= 0 {
                (i, from, direction) = ((i + 1) % n, 0.0, 1);
            } else if u <= 0.0 && direction <= 0 {
                i = (i + n - 1) % n;
                (from, direction) = (self.path.length_of(i), -1);
            } else {
                return Some((i, u));
            }
        }
        None
    }

    /// Piece and distance in it of the foot within the edges whose heading is nearest to that of
    /// the pose; none if the pose is outside the track.
    fn nearest_heading(&self, g: &GlobalState) -> Option<(usize, f64)> {
        let n = self.path.len();
        let mut best: Option<(f64, (usize, f64))> = None;
        for i in 0..n {
            let u = self.path.foot_in(i, g.x, g.y);
            let foot = self.foot(i, u, g.x, g.y);
            let (x_c, y_c) = self.path.point_in(i, u);
            let distance = libm::hypot(g.x - x_c, g.y - y_c);
            // The end of a piece is nearest only where the next piece begins with it.
            let is_foot = distance - foot.e_y.abs() <= 1e-3 * self.max_width;
            if !is_foot || self.beyond_edge(&foot) > 0.0 {
                continue;
            }
            let turn = wrap_angle(g.psi - foot.heading).abs();
            if best.is_none_or(|(least, _)| turn < least) {
                best = Some((turn, (i, u)));
            }
        }
        let (_, (i, u)) = best?;
        self.follow(g.x, g.y, self.wrap(self.path.start_of(i) + u)).or(Some((i, u)))
    }

    /// Piece and distance in it of the nearest point of the whole centre line.
    fn nearest(&self, x: f64, y: f64) -> (usize, f64) {
        let distance = |i: usize, u: f64| {
            let (x_c, y_c) = self.path.point_in(i, u);
            libm::hypot(x - x_c, y - y_c)
        };
        // No point of a block of pieces is further from its beginning than the block is long.
        let starts = (0..self.path.len()).step_by(BLOCK);
        let reach = |from: usize, to: usize| {
            let last = to.min(self.path.len()) - 1;
            self.path.start_of(last) + self.path.length_of(last) - self.path.start_of(from)
        };
        let mut best = (0, 0.0);
        let mut least = distance(0, 0.0);
        for i in starts.clone().filter(|&i| i > 0) {
            let d = distance(i, 0.0);
            if d < least {
                (best, least) = ((i, 0.0), d);
            }
        }
        for block in starts {
            if distance(block, 0.0) > least + SLACK * reach(block, block + BLOCK) {
                continue;
            }
            for i in block..(block + BLOCK).min(self.path.len()) {
                if distance(i, 0.0) > least + SLACK * reach(i, i + 1) {
                    continue;
                }
                let u = self.path.foot_in(i, x, y);
                let d = distance(i, u);
                if d < least {
                    (best, least) = ((i, u), d);
                }
            }
        }
        best
    }
}
