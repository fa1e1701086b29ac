//! A place of a road, and how fast it can be driven there.

use crate::params::GRAVITY;

pub(crate) use track::MIN_FRENET_SCALE;
pub use track::{Road, Surface};

/// A road that is everywhere as it is at one place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RoadPoint {
    /// Curvature of the centre line in plan view, positive to the left \[1/m\].
    pub kappa: f64,
    /// The surface; `None` where the road is flat.
    pub surface: Option<Surface>,
}

impl RoadPoint {
    /// A flat road of this curvature \[1/m\].
    #[must_use]
    pub const fn flat(kappa: f64) -> Self {
        Self { kappa, surface: None }
    }

    /// Of a road at s.
    #[must_use]
    pub fn of(road: &dyn Road, s: f64) -> Self {
        let surface = (!road.is_flat()).then(|| road.surface(s));
        Self { kappa: road.kappa(s), surface }
    }

    /// Greatest speed at which a point mass follows a line of the curvature `kappa` \[1/m\] on this
    /// surface \[m/s\], with the friction coefficient `mu` and the downforce `down` per mass and
    /// squared speed \[1/m\]; infinite where nothing bounds it.
    ///
    /// Across the surface, v^2 kappa cos(bank) + g sin(bank) = mu N/m; normal to it, N/m = g cos(bank)
    /// - v^2 kappa sin(bank) + down v^2.
    #[must_use]
    pub fn corner_speed(&self, kappa: f64, mu: f64, down: f64) -> f64 {
        let surface = self.surface.unwrap_or(Surface::FLAT);
        let mu = mu * surface.friction;
        // Positive where the outer edge is the lower one.
        let bank = if kappa < 0.0 { -surface.bank } else { surface.bank };
        let (sin, cos) = libm::sincos(bank);
        let gravity = GRAVITY * libm::cos(surface.slope);
        let needed = kappa.abs() * (cos + mu * sin) - mu * down;
        let held = gravity * (mu * cos - sin);
        if needed <= 1e-12 { f64::INFINITY } else { (held.max(0.0) / needed).sqrt() }
    }
}

impl Road for RoadPoint {
    fn kappa(&self, _s: f64) -> f64 {
        self.kappa
    }

    fn is_flat(&self) -> bool {
        self.surface.is_none()
    }

    fn surface(&self, _s: f64) -> Surface {
        self.surface.unwrap_or(Surface::FLAT)
    }
}
