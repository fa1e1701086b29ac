//! The car on a road with bank and slope: what gravity and the curved surface do to it.
//!
//! The car moves on the surface, its z axis normal to it. The frame of the road at the foot point
//! has the axes t along the road, n to the left in the surface and m normal to it; it is the
//! horizontal frame of the centre line in plan view, turned up by the slope theta about its y axis
//! and by the bank phi about t (Perantoni and Limebeer 2015, "Optimal control of a Formula One car
//! on a three-dimensional track", with s and e_y in plan view). With the velocities u along t and
//! w along n,
//!
//! ```text
//! s'     = (u cos theta - w sin theta sin phi) / (1 - kappa e_y)
//! e_y'   = w cos phi
//! omega  = [phi' + psi' sin theta, -theta' cos phi + psi' cos theta sin phi,
//!           theta' sin phi + psi' cos theta cos phi]   in t, n, m;  psi' = kappa s'
//! e_psi' = omega_z - omega_m
//! load   = cos theta cos phi + (omega_t w - omega_n u) / g
//! v_x'  += g_t cos e_psi + g_n sin e_psi,  g_t = -g sin theta
//! v_y'  += g_n cos e_psi - g_t sin e_psi,  g_n = -g cos theta sin phi
//! ```
//!
//! Loads of the axles grow with `load`; roll and pitch accelerations, and the load transfer between
//! left and right, are left out, as on a flat road.

use crate::number::{Number, Real};
use crate::params::GRAVITY;
use crate::road::{MIN_FRENET_SCALE, Road};

/// A car that flies keeps this share of its weight on the road, so that the tyres stay defined.
const MIN_LOAD: f64 = 0.02;
/// Lanes of the widest vector register there is.
const MOST_LANES: usize = 16;

/// The surface of the road below one or several cars.
#[derive(Clone, Copy)]
pub(crate) struct Terrain<R> {
    kappa: R,
    sin_bank: R,
    cos_bank: R,
    sin_slope: R,
    cos_slope: R,
    bank_rate: R,
    slope_rate: R,
    /// Factor of the friction.
    pub(crate) friction: R,
}

impl<R: Real> Terrain<R> {
    /// Of a road at s.
    #[inline(always)]
    pub(crate) fn new(road: &dyn Road, s: R) -> Self {
        Self::bent(road, s, s.map(|s| road.kappa(s)))
    }

    /// Of a road at s, with this curvature.
    #[inline(always)]
    pub(crate) fn bent(road: &dyn Road, s: R, kappa: R) -> Self {
        let mut seen = [[0.0; 7]; MOST_LANES];
        let mut lane = 0;
        let _ = s.map(|s| {
            let surface = road.surface(s);
            let (sin_bank, cos_bank) = libm::sincos(surface.bank);
            let (sin_slope, cos_slope) = libm::sincos(surface.slope);
            seen[lane.min(MOST_LANES - 1)] = [
                sin_bank,
                cos_bank,
                sin_slope,
                cos_slope,
                surface.bank_rate,
                surface.slope_rate,
                surface.friction,
            ];
            lane += 1;
            0.0
        });
        let all = |k: usize| {
            let mut lane = 0;
            s.map(|_| {
                lane += 1;
                seen[(lane - 1).min(MOST_LANES - 1)][k]
            })
        };
        Self {
            kappa,
            sin_bank: all(0),
            cos_bank: all(1),
            sin_slope: all(2),
            cos_slope: all(3),
            bank_rate: all(4),
            slope_rate: all(5),
            friction: all(6),
        }
    }
}

/// What the ground does to a car.
#[derive(Clone, Copy)]
pub(crate) struct Ground<T> {
    /// Gravity along the car and to its left \[m/s^2\].
    pub(super) gravity: [T; 2],
    /// Load of the axles over that on a flat road at rest \[-\].
    pub(super) load: T,
}

/// Rates of the pose [e_psi, s, e_y] and what the ground does, from velocities and pose.
#[inline(always)]
pub(crate) fn ground<T: Number>(
    terrain: &Terrain<T::Real>,
    v: &[T; 3],
    pose: &[T; 3],
) -> ([T; 3], Ground<T>) {
    let [v_x, v_y, omega_z] = *v;
    let [e_psi, _, e_y] = *pose;
    let Terrain { kappa, sin_bank, cos_bank, sin_slope, cos_slope, .. } = *terrain;
    let (sin_psi, cos_psi) = e_psi.sin_cos();
    let scale = -e_y.scale(kappa) + 1.0;
    let least = scale.constant(MIN_FRENET_SCALE);
    let scale = T::select(scale.below(MIN_FRENET_SCALE), least, scale);
    let u = v_x * cos_psi - v_y * sin_psi;
    let w = v_x * sin_psi + v_y * cos_psi;
    let s_dot = (u.scale(cos_slope) - w.scale(sin_slope * sin_bank)) * scale.recip();

    let psi_dot = s_dot.scale(kappa);
    let (bank_dot, slope_dot) = (s_dot.scale(terrain.bank_rate), s_dot.scale(terrain.slope_rate));
    let omega_t = bank_dot + psi_dot.scale(sin_slope);
    let omega_n = psi_dot.scale(cos_slope * sin_bank) - slope_dot.scale(cos_bank);
    let omega_m = psi_dot.scale(cos_slope * cos_bank) + slope_dot.scale(sin_bank);

    let g_t = cos_psi.constant(-GRAVITY).scale(sin_slope);
    let g_n = cos_psi.constant(-GRAVITY).scale(cos_slope * sin_bank);
    let normal = (omega_t * w - omega_n * u) * (1.0 / GRAVITY);
    let load = normal + normal.constant(1.0).scale(cos_slope * cos_bank);
    let load = T::select(load.below(MIN_LOAD), load.constant(MIN_LOAD), load);
    let gravity = [g_t * cos_psi + g_n * sin_psi, g_n * cos_psi - g_t * sin_psi];
    ([omega_z - omega_m, s_dot, w.scale(cos_bank)], Ground { gravity, load })
}
