//! The centre line as a chain of pieces, whatever each of them is.

use super::arc::Arc;

/// The centre line of one lap.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Path {
    /// Straights and arcs, exact.
    Arcs(Vec<Arc>),
}

impl Path {
    /// Number of pieces.
    pub(super) fn len(&self) -> usize {
        match self {
            Self::Arcs(arcs) => arcs.len(),
        }
    }

    /// Piece that holds s in [0, L); a boundary belongs to the piece that begins there.
    pub(super) fn index_of(&self, s: f64) -> usize {
        match self {
            Self::Arcs(arcs) => arcs.partition_point(|arc| arc.s <= s).saturating_sub(1),
        }
    }

    /// Distance along the track where piece i begins [m].
    pub(super) fn start_of(&self, i: usize) -> f64 {
        match self {
            Self::Arcs(arcs) => arcs[i].s,
        }
    }

    /// Length of piece i [m].
    pub(super) fn length_of(&self, i: usize) -> f64 {
        match self {
            Self::Arcs(arcs) => arcs[i].length,
        }
    }

    /// Curvature at s in [0, L) [1/m].
    pub(super) fn kappa(&self, s: f64) -> f64 {
        let i = self.index_of(s);
        match self {
            Self::Arcs(arcs) => arcs[i].kappa,
        }
    }

    /// Pose (x, y, psi) at distance u in piece i.
    pub(super) fn pose_in(&self, i: usize, u: f64) -> (f64, f64, f64) {
        match self {
            Self::Arcs(arcs) => arcs[i].pose(u),
        }
    }

    /// Distance in [0, length] of the point of piece i nearest to (x, y).
    pub(super) fn foot_in(&self, i: usize, x: f64, y: f64) -> f64 {
        match self {
            Self::Arcs(arcs) => arcs[i].foot(x, y),
        }
    }

    /// Distance of (x, y) from the beginning of piece i [m].
    pub(super) fn distance_to_start(&self, i: usize, x: f64, y: f64) -> f64 {
        match self {
            Self::Arcs(arcs) => (x - arcs[i].x).hypot(y - arcs[i].y),
        }
    }
}
