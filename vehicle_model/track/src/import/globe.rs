//! Positions on the globe, projected to the plane that touches it in their middle.

use crate::{Origin, TrackError};

/// Semi-major axis of WGS 84 [m].
const A: f64 = 6_378_137.0;
/// Square of the first eccentricity of WGS 84 [-].
const E2: f64 = 6.694_379_990_141_316_5e-3;
/// Places are rounded to this, since the last bits of a sine depend on the platform [m].
const ROUNDING: f64 = 1e-5;
/// Largest distance from the middle [m].
const MOST: f64 = 30_000.0;

/// Places in the plane [m], and where its zero is.
pub(super) type Projected = (Vec<(f64, f64)>, Origin);

/// A position on the globe.
#[derive(Debug, Clone, Copy)]
pub(super) struct Fix {
    /// Geodetic latitude \[degree\].
    pub latitude: f64,
    /// Longitude \[degree\].
    pub longitude: f64,
    /// Height above the ellipsoid [m].
    pub height: f64,
}

impl Fix {
    /// Earth-centred, earth-fixed coordinates [m] (Hofmann-Wellenhof et al., GNSS, 2008, eq. 8.4).
    fn earth(&self) -> [f64; 3] {
        let (sin, cos) = libm::sincos(self.latitude.to_radians());
        let (sin_l, cos_l) = libm::sincos(self.longitude.to_radians());
        let normal = A / (1.0 - E2 * sin * sin).sqrt();
        let across = (normal + self.height) * cos;
        [across * cos_l, across * sin_l, (normal * (1.0 - E2) + self.height) * sin]
    }
}

/// The places east and north of the middle of the fixes, in the plane that touches the ellipsoid
/// there [m], and the middle. `item` names fix i.
pub(super) fn project(
    fixes: &[Fix],
    item: &dyn Fn(usize) -> String,
) -> Result<Projected, Vec<TrackError>> {
    let mut problems = Vec::new();
    for (i, fix) in fixes.iter().enumerate() {
        for (key, found, most, expected) in [
            ("latitude", fix.latitude, 90.0, "degrees from -90 to 90"),
            ("longitude", fix.longitude, 360.0, "degrees from -180 to 180, or from 0 to 360"),
        ] {
            if !found.is_finite() || found.abs() > most {
                problems.push(TrackError::Value { item: item(i), key, found, expected });
            }
        }
    }
    if !problems.is_empty() {
        return Err(problems);
    }
    let range = |value: &dyn Fn(&Fix) -> f64| {
        fixes
            .iter()
            .map(value)
            .fold((f64::INFINITY, f64::NEG_INFINITY), |r, v| (r.0.min(v), r.1.max(v)))
    };
    let middle = |value: &dyn Fn(&Fix) -> f64| 0.5 * (range(value).0 + range(value).1);
    // A track that crosses the meridian of 180 degrees, or of 0 where that is 360, goes on there.
    let (west, east) = range(&|f| f.longitude);
    let around = east - west > 180.0;
    let turned = |f: &Fix| match around && f.longitude < 0.5 * (west + east) {
        true => f.longitude + 360.0,
        false => f.longitude,
    };
    let longitude = middle(&turned);
    let origin = Fix {
        latitude: middle(&|f| f.latitude),
        longitude: if longitude > 180.0 { longitude - 360.0 } else { longitude },
        height: middle(&|f| f.height),
    };
    let (sin, cos) = libm::sincos(origin.latitude.to_radians());
    let (sin_l, cos_l) = libm::sincos(origin.longitude.to_radians());
    let zero = origin.earth();
    let places: Vec<(f64, f64)> = fixes
        .iter()
        .map(|fix| {
            let earth = fix.earth();
            let [x, y, z] = [0, 1, 2].map(|i| earth[i] - zero[i]);
            let east = cos_l * y - sin_l * x;
            let north = cos * z - sin * (cos_l * x + sin_l * y);
            let round = |v: f64| (v / ROUNDING).round() * ROUNDING;
            (round(east), round(north))
        })
        .collect();
    let far = places.iter().position(|(x, y)| libm::hypot(*x, *y) > MOST);
    if let Some(i) = far {
        let (key, found) = ("distance from the middle", libm::hypot(places[i].0, places[i].1));
        let expected = "at most 30000 m; check the order of latitude and longitude";
        return Err(vec![TrackError::Value { item: item(i), key, found, expected }]);
    }
    let Fix { latitude, longitude, height } = origin;
    Ok((places, Origin { latitude, longitude, height }))
}

#[cfg(test)]
mod tests {
    use super::{A, E2, Fix, project};

    #[test]
    fn a_minute_of_arc_has_the_length_of_the_radii_of_curvature() {
        // Meridian and transverse radius at the latitude, times the angle.
        let latitude = 50.0_f64;
        let angle = 1.0 / 60.0;
        let fix = |n: f64, e: f64| Fix { latitude: latitude + n, longitude: 8.0 + e, height: 0.0 };
        let corners = [fix(-angle, 0.0), fix(angle, 0.0), fix(0.0, -angle), fix(0.0, angle)];
        let (places, origin) = project(&corners, &|i| i.to_string()).unwrap();
        assert!((origin.latitude - latitude).abs() < 1e-12);
        let sin = latitude.to_radians().sin();
        let w = 1.0 - E2 * sin * sin;
        let north = A * (1.0 - E2) / (w * w.sqrt()) * angle.to_radians();
        let east = A / w.sqrt() * latitude.to_radians().cos() * angle.to_radians();
        assert!((places[1].1 - north).abs() < 0.01, "{places:?} {north}");
        assert!((places[3].0 - east).abs() < 0.01, "{places:?} {east}");
        assert!(places[1].0.abs() < 1e-4 && places[3].1 < 0.5);
    }
}
