//! Speeds on a grid along the track, and braking from each point to the next.

use vehicle_model::{CarParams, GRAVITY, Track};

/// Grid points at most: a longer track gets a coarser grid.
const POINTS: usize = 20_000;

/// Number of grid points and their distance \[m\]: half a wheelbase apart.
pub(crate) fn grid(car: &CarParams, track: &Track) -> (usize, f64) {
    let wanted = (track.length() / (0.5 * car.wheelbase())).ceil();
    let points = (wanted as usize).clamp(16, POINTS);
    (points, track.length() / points as f64)
}

/// The grid point at or before s, of n with the distance `ds`, and the share of the way to the next.
pub(crate) fn place(s: f64, ds: f64, n: usize) -> (usize, f64) {
    let place = (s / ds).rem_euclid(n as f64);
    let i = (place as usize).min(n - 1);
    (i, place - i as f64)
}

/// Speed at s between the speeds of a grid with the distance `ds` \[m/s\]; infinite where it is empty.
pub(crate) fn between(speed: &[f64], ds: f64, s: f64) -> f64 {
    let n = speed.len();
    if n == 0 {
        return f64::INFINITY;
    }
    let (i, share) = place(s, ds, n);
    speed[i] + share * (speed[(i + 1) % n] - speed[i])
}

/// Replaces each speed by `change` of its index, itself and the speed after it, backward, twice round
/// the track.
pub(crate) fn backward(speed: &mut [f64], change: impl Fn(usize, f64, f64) -> f64) {
    let n = speed.len();
    for i in (0..2 * n).rev() {
        speed[i % n] = change(i % n, speed[i % n], speed[(i + 1) % n]);
    }
}

/// What brakes of the strength `brake` \[m/s^2\] do at s, with the friction and the slope there.
pub(crate) fn deceleration(track: &Track, s: f64, brake: f64) -> f64 {
    if track.is_flat() {
        return brake;
    }
    brake * track.friction(s).min(1.0) + GRAVITY * libm::sin(track.slope(s))
}
