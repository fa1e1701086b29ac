//! The car's equations per metre, made smooth where braking passes into driving.
//!
//! A car that brakes with other wheels than it drives with has a kink at a = 0. Where it is not yet
//! known which of both the car does, the equations with the shares of driving and those with the
//! shares of braking are blended in a band around it.

use vehicle_model::{
    CarParams, Model, ModelKind, RoadPoint, SPATIAL_RATES, SPATIAL_VARIABLES, SpatialExpansion,
};

/// Index of a among the variables.
const A: usize = 5;

/// What the car does in an interval.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Mode {
    /// Either: the equations are blended.
    Either,
    /// It drives, a >= 0.
    Drive,
    /// It brakes, a <= 0.
    Brake,
}

/// The equations of one car.
#[derive(Debug, Clone)]
pub(crate) struct Dynamics {
    drive: Model,
    /// With the shares of braking; `None` if they are those of driving.
    brake: Option<Model>,
    /// Half the width of the band \[m/s^2\].
    band: f64,
}

/// Value, slope and curvature of a function of a.
type Share = [f64; 3];

impl Dynamics {
    /// `band` is half its width as a share of the weaker of both limits of a.
    pub(crate) fn new(car: &CarParams, band: f64) -> Self {
        // Limits of engine and brakes are constraints of the program: inside the equations they
        // would be kinks right where the solution lies.
        let free = CarParams {
            power_max: None,
            drive_force_max: None,
            brake_force_max: None,
            speed_max: None,
            ..car.clone()
        };
        let model = |car: CarParams| Model::new(ModelKind::Dynamic, car);
        let drive = CarParams { brake_front: car.drive_front, ..free.clone() };
        let brake = CarParams { drive_front: car.brake_front, ..free };
        Self {
            drive: model(drive),
            brake: (car.drive_front != car.brake_front).then(|| model(brake)),
            band: band * car.a_max.min(-car.a_min),
        }
    }

    /// Whether there is no kink.
    pub(crate) fn is_smooth(&self) -> bool {
        self.brake.is_none()
    }

    /// The model that holds at an acceleration, or both with the share of driving.
    fn at(&self, mode: Mode, a: f64) -> (&Model, Option<(&Model, Share)>) {
        match &self.brake {
            Some(brake) if mode == Mode::Brake => (brake, None),
            _ if mode == Mode::Drive => (&self.drive, None),
            Some(brake) if a <= -self.band => (brake, None),
            Some(brake) if a < self.band => (&self.drive, Some((brake, self.share(a)))),
            _ => (&self.drive, None),
        }
    }

    /// The share of driving in the band, a smoothstep with continuous curvature.
    fn share(&self, a: f64) -> Share {
        let per = 0.5 / self.band;
        let t = (a + self.band) * per;
        let rest = t * (1.0 - t);
        [
            t * t * t * (10.0 + t * (6.0 * t - 15.0)),
            30.0 * rest * rest * per,
            60.0 * rest * (1.0 - 2.0 * t) * per * per,
        ]
    }

    /// Rates per metre of [v_x, v_y, omega_z, e_psi, e_y, t].
    pub(crate) fn rates(
        &self,
        mode: Mode,
        z: &[f64; SPATIAL_VARIABLES],
        road: &RoadPoint,
    ) -> [f64; SPATIAL_RATES] {
        let (model, blend) = self.at(mode, z[A]);
        let rates = model.spatial_rates(z, road);
        let Some((brake, [share, ..])) = blend else { return rates };
        let other = brake.spatial_rates(z, road);
        std::array::from_fn(|i| other[i] + share * (rates[i] - other[i]))
    }

    /// The rates with first and second derivatives.
    pub(crate) fn expansion(
        &self,
        mode: Mode,
        z: &[f64; SPATIAL_VARIABLES],
        road: &RoadPoint,
    ) -> SpatialExpansion {
        let (model, blend) = self.at(mode, z[A]);
        let mut out = model.spatial_expansion(z, road);
        let Some((brake, [share, slope, curvature])) = blend else { return out };
        let other = brake.spatial_expansion(z, road);
        for row in 0..SPATIAL_RATES {
            let by = |i: usize| out.jacobian[row][i] - other.jacobian[row][i];
            let difference = out.value[row] - other.value[row];
            let mut hessian = [[0.0; SPATIAL_VARIABLES]; SPATIAL_VARIABLES];
            let mut jacobian = [0.0; SPATIAL_VARIABLES];
            for i in 0..SPATIAL_VARIABLES {
                let rows = out.hessian[row][i].iter().zip(&other.hessian[row][i]);
                for (entry, (own, old)) in hessian[i].iter_mut().zip(rows) {
                    *entry = old + share * (own - old);
                }
                jacobian[i] = other.jacobian[row][i] + share * by(i);
            }
            for (i, entries) in hessian.iter_mut().enumerate() {
                entries[A] += slope * by(i);
            }
            for (i, entry) in hessian[A].iter_mut().enumerate() {
                *entry += slope * by(i);
            }
            hessian[A][A] += curvature * difference;
            jacobian[A] += slope * difference;
            out.value[row] = other.value[row] + share * difference;
            out.jacobian[row] = jacobian;
            out.hessian[row] = hessian;
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Inside the band, differences of values and of slopes give slopes and curvatures.
    #[test]
    fn the_blend_is_differentiated_exactly() {
        let dynamics = Dynamics::new(&CarParams::builtin("iac").unwrap(), 0.05);
        let z = [40.0, -0.5, 0.3, 0.02, 1.0, 0.02, 0.03];
        let road = RoadPoint::flat(0.01);
        let exact = dynamics.expansion(Mode::Either, &z, &road);
        for i in 0..SPATIAL_VARIABLES {
            let at = |step: f64| {
                let mut moved = z;
                moved[i] += step;
                (
                    dynamics.rates(Mode::Either, &moved, &road),
                    dynamics.expansion(Mode::Either, &moved, &road).jacobian,
                )
            };
            let h = 1e-5;
            let (ahead, behind) = (at(h), at(-h));
            for row in 0..SPATIAL_RATES {
                let slope = (ahead.0[row] - behind.0[row]) / (2.0 * h);
                assert!((slope - exact.jacobian[row][i]).abs() < 1e-6 * (1.0 + slope.abs()));
                for j in 0..SPATIAL_VARIABLES {
                    let bend = (ahead.1[row][j] - behind.1[row][j]) / (2.0 * h);
                    assert!((bend - exact.hessian[row][i][j]).abs() < 1e-5 * (1.0 + bend.abs()));
                }
            }
        }
    }
}
