//! Limits of the rules of doubt, by default from car and track.

use vehicle_model::{CarParams, Track};

/// What may differ before a state or an actuator is doubted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DoubtLimits {
    /// How far a corner of the body may be beyond the edge. \[m\]
    pub edge: f64,
    /// How far a predicted stop may take the centre of mass beyond the edge. \[m\]
    pub stop_edge: f64,
    /// Greatest angle between car and track. \[rad\]
    pub heading: f64,
    /// Constant part of the disagreement between position and velocity. \[m\]
    pub position: f64,
    /// Share by which a speed may be wrong. \[-\]
    pub speed_share: f64,
    /// Angle by which a heading may be wrong. \[rad\]
    pub heading_error: f64,
    /// Time by which a measurement may be early or late. \[s\]
    pub timing: f64,
    /// Constant part of the disagreement between heading and yaw rate. \[rad\]
    pub turn: f64,
    /// Acceleration by which the speed may disagree with throttle and brake. \[m/s^2\]
    pub accel: f64,
    /// Steering angle by which the yaw rate may disagree with the steering. \[rad\]
    pub steer: f64,
    /// Yaw rate that is always allowed. \[rad/s\]
    pub yaw_rate: f64,
    /// A disagreement of twice its limit is doubted after this long. \[s\]
    pub patience: f64,
    /// Up to this speed a doubted car may still be accelerated: one that was armed askew has to turn
    /// round. \[m/s\]
    pub crawl: f64,
}

impl DoubtLimits {
    /// The limits of a car on a track.
    #[must_use]
    pub fn new(car: &CarParams, track: &Track) -> Self {
        let half = (0..256)
            .map(|i| track.length() * f64::from(i) / 256.0)
            .map(|s| track.width_left(s).min(track.width_right(s)))
            .fold(f64::INFINITY, f64::min);
        Self {
            // Laps are judged by the centre of mass: a corner may be out by as much as the body is wide.
            edge: 0.75 * car.width,
            stop_edge: 0.5 * car.width,
            heading: 1.8,
            position: 0.1 * half,
            speed_share: 0.07,
            heading_error: 0.035,
            timing: 0.03,
            turn: 0.1,
            accel: 0.35 * car.a_max.max(-car.a_min),
            steer: 0.05,
            yaw_rate: 0.15,
            patience: 0.1,
            // Full braking stops the car within half the width of its body.
            crawl: (-car.a_min * car.width).sqrt(),
        }
    }
}
