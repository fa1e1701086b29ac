//! The road as equations of motion see it: curvature, and where it is not flat, its surface.

use crate::Track;

/// A road along s.
pub trait Road {
    /// Curvature of the centre line in plan view at s, positive to the left \[1/m\].
    fn kappa(&self, s: f64) -> f64;

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
pub struct TrackRoad<'a, K> {
    track: &'a Track,
    kappa: K,
}

impl<K: Fn(f64) -> f64> Road for TrackRoad<'_, K> {
    fn kappa(&self, s: f64) -> f64 {
        (self.kappa)(s)
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
    pub fn road(&self) -> TrackRoad<'_, impl Fn(f64) -> f64> {
        TrackRoad { track: self, kappa: self.kappa_along() }
    }
}
