//! The equations of motion per metre of the centre line instead of per second, with first and
//! second derivatives: what an optimisation along s needs.

use super::{Held, Model, Terrain};
use crate::number::{Jet, Number};
use crate::road::{Road as _, RoadPoint};

/// Number of quantities the rates depend on: [v_x, v_y, omega_z, e_psi, e_y, a, delta].
pub const SPATIAL_VARIABLES: usize = 7;
/// Number of rates: those of [v_x, v_y, omega_z, e_psi, e_y] and of the time.
pub const SPATIAL_RATES: usize = 6;

/// The rates per metre at a point with their derivatives, exact. Rows are the
/// rates [v_x, v_y, omega_z, e_psi, e_y, t], directions [v_x, v_y, omega_z, e_psi, e_y, a, delta].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpatialExpansion {
    /// The rates; that of the time is the pace dt/ds \[s/m\].
    pub value: [f64; SPATIAL_RATES],
    /// First derivatives.
    pub jacobian: [[f64; SPATIAL_VARIABLES]; SPATIAL_RATES],
    /// Second derivatives.
    pub hessian: [[[f64; SPATIAL_VARIABLES]; SPATIAL_VARIABLES]; SPATIAL_RATES],
}

impl Model {
    /// Rates of [v_x, v_y, omega_z, e_psi, e_y, t] per metre of the centre line in plan view at
    /// z = [v_x, v_y, omega_z, e_psi, e_y, a, delta] at a place of a road. A pace that is not above 0 means that the car does not go forward along the line.
    #[must_use]
    pub fn spatial_rates(
        &self,
        z: &[f64; SPATIAL_VARIABLES],
        road: &RoadPoint,
    ) -> [f64; SPATIAL_RATES] {
        self.spatial_generic(z, road, &self.grip)
    }

    /// [`Model::spatial_rates`] with first and second derivatives.
    #[must_use]
    pub fn spatial_expansion(
        &self,
        z: &[f64; SPATIAL_VARIABLES],
        road: &RoadPoint,
    ) -> SpatialExpansion {
        type Second = Jet<SPATIAL_VARIABLES, { SPATIAL_VARIABLES * (SPATIAL_VARIABLES + 1) / 2 }>;
        let z: [Second; SPATIAL_VARIABLES] = std::array::from_fn(|i| Jet::direction(z[i], i));
        let rates = self.spatial_generic(&z, road, &self.grip.map(Jet::fixed));
        SpatialExpansion {
            value: rates.map(|rate| rate.value),
            jacobian: rates.map(|rate| rate.gradient),
            hessian: rates
                .map(|rate| std::array::from_fn(|i| std::array::from_fn(|j| rate.second(i, j)))),
        }
    }

    /// The time derivatives divided by that of s.
    #[inline(always)]
    fn spatial_generic<T: Number>(
        &self,
        z: &[T; SPATIAL_VARIABLES],
        road: &RoadPoint,
        grip: &[T; 2],
    ) -> [T; SPATIAL_RATES] {
        let x = [z[0], z[1], z[2], z[3], z[0].constant(0.0), z[4]];
        let u = Held::new(&[z[5], z[6]]);
        let nowhere = z[0].real().constant(0.0);
        let rates = if road.is_flat() {
            self.derivative_generic(&x, &u, nowhere.constant(road.kappa), grip)
        } else {
            self.derivative_on(&x, &u, &Terrain::new(road, nowhere), grip)
        };
        let [v_x, v_y, omega_z, e_psi, s, e_y] = rates;
        let pace = s.recip();
        [v_x * pace, v_y * pace, omega_z * pace, e_psi * pace, e_y * pace, pace]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::ModelKind;
    use crate::params::CarParams;
    use crate::road::Surface;

    /// Differences of the values give the Jacobian, differences of the Jacobian the Hessian.
    #[test]
    fn derivatives_agree_with_central_differences() {
        let surface =
            Surface { bank: -0.15, slope: 0.06, bank_rate: 0.02, slope_rate: -0.01, friction: 0.9 };
        let roads = [RoadPoint::flat(0.05), RoadPoint { kappa: 0.05, surface: Some(surface) }];
        let names = CarParams::builtin_names();
        for (name, road) in names.iter().flat_map(|name| roads.map(|road| (name, road))) {
            let car = CarParams::builtin(name).unwrap();
            let v = 3.0 * (9.81 * car.wheelbase()).sqrt();
            let model = Model::new(ModelKind::Dynamic, car);
            let z = [v, -0.02 * v, 0.05 * v, 0.1, 0.2, -0.7, 0.06];
            let exact = model.spatial_expansion(&z, &road);
            assert_eq!(exact.value, model.spatial_rates(&z, &road));
            for i in 0..SPATIAL_VARIABLES {
                let h = 1e-6;
                let at = |step: f64| {
                    let mut moved = z;
                    moved[i] += step;
                    model.spatial_expansion(&moved, &road)
                };
                let (ahead, behind) = (at(h), at(-h));
                for row in 0..SPATIAL_RATES {
                    let slope = (ahead.value[row] - behind.value[row]) / (2.0 * h);
                    let scale = 1.0 + slope.abs();
                    assert!((slope - exact.jacobian[row][i]).abs() < 1e-6 * scale, "{name}");
                    for j in 0..SPATIAL_VARIABLES {
                        let bend = (ahead.jacobian[row][j] - behind.jacobian[row][j]) / (2.0 * h);
                        let found = exact.hessian[row][i][j];
                        let scale = 1.0 + bend.abs();
                        assert!((bend - found).abs() < 1e-5 * scale, "{name} {bend} {found}");
                    }
                }
            }
        }
    }
}
