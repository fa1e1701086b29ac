//! The centre line as a chain of pieces, whatever each of them is.

use super::arc::Arc;
use super::road::MIN_FRENET_SCALE;
use super::spline::Spline;

/// The centre line of one lap.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Path {
    /// Straights and arcs, exact.
    Arcs(Vec<Arc>),
    /// A closed spline whose parameter is its arc length.
    Spline(Spline),
}

/// A way beside the centre line, followed from piece to piece.
struct Way {
    e_y: f64,
    /// What of the way is left [m].
    rest: f64,
    /// What has passed of the centre line [m], and how far that turns [rad].
    along: f64,
    turned: f64,
}

impl Way {
    fn new(e_y: f64, ahead: f64) -> Self {
        Self { e_y, rest: ahead.abs(), along: 0.0, turned: 0.0 }
    }

    /// Whether the way ends within `length` [m] of the curvature `kappa`, which it passes; one without
    /// end does at once.
    #[inline]
    fn ends_in(&mut self, kappa: f64, length: f64) -> bool {
        let scale = (1.0 - kappa * self.e_y).max(MIN_FRENET_SCALE);
        let ends = !(self.rest > length * scale && self.rest.is_finite());
        let passed = if ends { self.rest / scale } else { length };
        self.along += passed;
        self.turned += kappa * passed;
        self.rest -= passed * scale;
        ends
    }
}

/// Piece that holds s, found by walking from piece `near` of `count`; piece i begins at `begin(i)`.
#[inline]
pub(super) fn walk(s: f64, near: usize, count: usize, begin: impl Fn(usize) -> f64) -> usize {
    let mut i = near.min(count - 1);
    while i > 0 && s < begin(i) {
        i -= 1;
    }
    while i + 1 < count && s >= begin(i + 1) {
        i += 1;
    }
    i
}

impl Path {
    /// Number of pieces.
    pub(super) fn len(&self) -> usize {
        match self {
            Self::Arcs(arcs) => arcs.len(),
            Self::Spline(spline) => spline.len(),
        }
    }

    /// Piece that holds s in [0, L); a boundary belongs to the piece that begins there.
    pub(super) fn index_of(&self, s: f64) -> usize {
        match self {
            Self::Arcs(arcs) => arcs.partition_point(|arc| arc.s <= s).saturating_sub(1),
            Self::Spline(spline) => spline.index_of(s),
        }
    }

    /// [`Path::index_of`], found by walking from piece `near`.
    #[inline]
    pub(super) fn index_near(&self, s: f64, near: usize) -> usize {
        match self {
            Self::Arcs(arcs) => walk(s, near, arcs.len(), |i| arcs[i].s),
            Self::Spline(spline) => spline.index_of(s),
        }
    }

    /// Distance along the track where piece i begins [m].
    #[inline]
    pub(super) fn start_of(&self, i: usize) -> f64 {
        match self {
            Self::Arcs(arcs) => arcs[i].s,
            Self::Spline(spline) => spline.start_of(i),
        }
    }

    /// Length of piece i [m].
    pub(super) fn length_of(&self, i: usize) -> f64 {
        match self {
            Self::Arcs(arcs) => arcs[i].length,
            Self::Spline(spline) => spline.length_of(i),
        }
    }

    /// Curvature at s in [0, L) [1/m].
    pub(super) fn kappa(&self, s: f64) -> f64 {
        let i = self.index_of(s);
        self.kappa_in(i, s - self.start_of(i))
    }

    /// Whether the curvature is constant in each piece.
    #[inline]
    pub(super) fn is_arcs(&self) -> bool {
        matches!(self, Self::Arcs(_))
    }

    /// Mean curvature along the centre line beside a way of `ahead` \[m\] at `e_y`, from distance u in
    /// piece i on \[1/m\]; along a spline that where it begins.
    pub(super) fn mean_kappa(&self, i: usize, u: f64, e_y: f64, ahead: f64) -> f64 {
        let Self::Arcs(arcs) = self else { return self.kappa_in(i, u) };
        let mut way = Way::new(e_y, ahead);
        let onwards = ahead >= 0.0;
        if way.ends_in(arcs[i].kappa, if onwards { arcs[i].length - u } else { u }) {
            return arcs[i].kappa;
        }
        let count = arcs.len();
        let next = |j: usize| (j + if onwards { 1 } else { count - 1 }) % count;
        let mut j = next(i);
        while !way.ends_in(arcs[j].kappa, arcs[j].length) && j != i {
            j = next(j);
        }
        way.turned / way.along
    }

    /// Curvature from `from` to `to`, if both lie in one straight or arc [1/m].
    pub(super) fn constant(&self, from: f64, to: f64) -> Option<f64> {
        let Self::Arcs(arcs) = self else { return None };
        let arc = arcs.get(arcs.partition_point(|arc| arc.s <= from).checked_sub(1)?)?;
        (to <= arc.s + arc.length).then_some(arc.kappa)
    }

    /// Curvature at distance u in piece i [1/m].
    #[inline]
    pub(super) fn kappa_in(&self, i: usize, u: f64) -> f64 {
        match self {
            Self::Arcs(arcs) => arcs[i].kappa,
            Self::Spline(spline) => spline.kappa_in(i, u),
        }
    }

    /// Pose (x, y, psi) at distance u in piece i.
    pub(super) fn pose_in(&self, i: usize, u: f64) -> (f64, f64, f64) {
        match self {
            Self::Arcs(arcs) => arcs[i].pose(u),
            Self::Spline(spline) => spline.pose_in(i, u),
        }
    }

    /// Point (x, y) at distance u in piece i.
    pub(super) fn point_in(&self, i: usize, u: f64) -> (f64, f64) {
        match self {
            Self::Arcs(arcs) => {
                let (x, y, _) = arcs[i].pose(u);
                (x, y)
            }
            Self::Spline(spline) => spline.point_in(i, u),
        }
    }

    /// Distance in [0, length] of the point of piece i nearest to (x, y).
    pub(super) fn foot_in(&self, i: usize, x: f64, y: f64) -> f64 {
        match self {
            Self::Arcs(arcs) => arcs[i].foot(x, y),
            Self::Spline(spline) => spline.foot_in(i, x, y),
        }
    }
}
