//! The road as equations of motion see it: curvature, and where it is not flat, its surface.

use std::cell::Cell;

use crate::Track;

/// Least 1 - kappa e_y that the pose equations divide by: the frame is singular at the centre of curvature,
/// far off every track.
pub const MIN_FRENET_SCALE: f64 = 0.05;

/// A road along s.
pub trait Road {
    /// Curvature of the centre line in plan view at s, positive to the left \[1/m\].
    fn kappa(&self, s: f64) -> f64;

    /// Whether the curvature jumps, from one value that holds along a stretch to the next.
    fn jumps(&self) -> bool {
        false
    }

    /// Mean curvature of the centre line from s on, while a car goes `ahead` \[m\] beside it at `e_y`
    /// \[1/m\]; on a road without jumps that at s.
    fn mean_kappa(&self, s: f64, _e_y: f64, _ahead: f64) -> f64 {
        self.kappa(s)
    }

    /// Whether the road is level, of even friction everywhere.
    fn is_flat(&self) -> bool {
        true
    }

    /// The surface at s.
    fn surface(&self, _s: f64) -> Surface {
        Surface::FLAT
    }
}

/// A function of the curvature is a flat road.
impl<F: Fn(f64) -> f64> Road for F {
    fn kappa(&self, s: f64) -> f64 {
        self(s)
    }
}

/// The surface of a road at a place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Surface {
    /// Bank: rotation about the direction of the road, positive where the left edge is the higher
    /// one \[rad\].
    pub bank: f64,
    /// Slope: angle of the direction of the road above the horizontal, positive uphill \[rad\].
    pub slope: f64,
    /// Change of the bank per metre of the centre line in plan view \[rad/m\].
    pub bank_rate: f64,
    /// Change of the slope per metre of the centre line in plan view \[rad/m\].
    pub slope_rate: f64,
    /// Factor of the tyres' peak friction \[-\].
    pub friction: f64,
}

impl Surface {
    /// A level road of full friction.
    pub const FLAT: Self =
        Self { bank: 0.0, slope: 0.0, bank_rate: 0.0, slope_rate: 0.0, friction: 1.0 };
}

/// The road of a track.
pub struct TrackRoad<'a> {
    track: &'a Track,
    /// Piece of the centre line where a place was found last.
    near: Cell<usize>,
}

impl TrackRoad<'_> {
    /// Piece that holds s in [0, L), and s from the piece's beginning on \[m\].
    fn find(&self, s: f64) -> (usize, f64) {
        let path = &self.track.path;
        let i = path.index_near(s, self.near.get());
        self.near.set(i);
        (i, s - path.start_of(i))
    }
}

impl Road for TrackRoad<'_> {
    fn kappa(&self, s: f64) -> f64 {
        let (i, u) = self.find(self.track.wrap(s));
        self.track.path.kappa_in(i, u)
    }

    fn jumps(&self) -> bool {
        self.track.path.is_arcs()
    }

    fn mean_kappa(&self, s: f64, e_y: f64, ahead: f64) -> f64 {
        let (i, u) = self.find(self.track.wrap(s));
        self.track.path.mean_kappa(i, u, e_y, ahead)
    }

    fn is_flat(&self) -> bool {
        self.track.is_flat()
    }

    fn surface(&self, s: f64) -> Surface {
        self.track.surface(s)
    }
}

impl Track {
    /// The road of the track, to be asked for places that follow one another.
    #[must_use]
    pub fn road(&self) -> TrackRoad<'_> {
        TrackRoad { track: self, near: Cell::new(0) }
    }
}
