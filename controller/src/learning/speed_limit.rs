//! Speed limits of the track and the car's top speed, with the braking distance before them.

use vehicle_model::{CarParams, Track};

use super::braking::{backward, deceleration, grid, place};

/// Greatest speed along the track that limits allow.
#[derive(Debug, Clone, Default)]
pub(crate) struct SpeedLimit {
    /// Distance of the grid points \[m\].
    ds: f64,
    /// Speed at each grid point \[m/s\]; empty without any limit.
    speed: Vec<f64>,
}

impl SpeedLimit {
    /// Of this car on this track, braking with this share of the brakes.
    pub(crate) fn new(car: &CarParams, track: &Track, brake_share: f64) -> Self {
        let top = car.speed_max.unwrap_or(f64::INFINITY);
        let limited = track.stations().iter().any(|station| station.speed_limit.is_some());
        if !limited && top.is_infinite() {
            return Self::default();
        }
        let (points, ds) = grid(car, track);
        // Between two points the smaller of both sides holds: a plan keeps a limit where it begins.
        let stated: Vec<f64> = (0..points)
            .map(|i| {
                let here = i as f64 * ds;
                let near = (-4..=4).map(|k| track.speed_limit(here + 0.25 * f64::from(k) * ds));
                near.fold(top, f64::min)
            })
            .collect();
        let mut limit = Self { ds, speed: stated };
        let brake = brake_share * car.hardest_braking();
        backward(&mut limit.speed, |i, here, after| {
            let room = deceleration(track, i as f64 * ds, brake);
            here.min((after * after + 2.0 * ds * room.max(0.0)).sqrt())
        });
        limit
    }

    /// Greatest speed at s \[m/s\]; infinite where nothing limits it.
    pub(crate) fn at(&self, s: f64) -> f64 {
        if self.speed.is_empty() {
            return f64::INFINITY;
        }
        let n = self.speed.len();
        let (i, _) = place(s, self.ds, n);
        self.speed[i].min(self.speed[(i + 1) % n])
    }
}

#[cfg(test)]
mod tests {
    use vehicle_model::GRAVITY;
    use vehicle_model::track::Station;

    use super::*;

    /// Before a limit the speed falls as constant deceleration says; uphill it may be higher.
    #[test]
    fn a_limit_is_reached_by_braking_before_it() {
        let car = CarParams::builtin("barc").unwrap();
        let track = Track::builtin("l").unwrap();
        let limited = |slope: f64| {
            let first = Station { s: 10.0, speed_limit: Some(1.0), ..Station::default() };
            let end = Station { s: 12.0, speed_limit: Some(f64::INFINITY), ..Station::default() };
            let hill = Station { s: 0.0, slope: Some(slope), ..Station::default() };
            let stations = if slope == 0.0 { vec![first, end] } else { vec![first, end, hill] };
            SpeedLimit::new(&car, &track.clone().with_stations(&stations).unwrap(), 0.5)
        };
        let flat = limited(0.0);
        assert!(flat.at(11.0) <= 1.0, "{}", flat.at(11.0));
        // A lap before the limit comes again.
        assert!(flat.at(13.0) > 5.0, "{}", flat.at(13.0));
        let expected = (1.0_f64 + 2.0 * 0.5 * 2.0 * 3.0).sqrt();
        assert!((flat.at(7.0) / expected - 1.0).abs() < 0.05, "{} {expected}", flat.at(7.0));
        let up = (1.0 + 2.0 * 3.0 * (0.5 * 2.0 + GRAVITY * 0.05_f64.sin())).sqrt();
        assert!((limited(0.05).at(7.0) / up - 1.0).abs() < 0.05, "{}", limited(0.05).at(7.0));
        assert!(SpeedLimit::new(&car, &track, 0.5).at(3.0).is_infinite());
        let slow = CarParams { speed_max: Some(1.7), ..car };
        assert!((SpeedLimit::new(&slow, &track, 0.5).at(3.0) - 1.7).abs() < 1e-12);
    }
}
