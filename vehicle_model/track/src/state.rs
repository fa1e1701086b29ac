//! Where a car is and how it moves: relative to a track, and in a global frame.

use nalgebra::Vector6;
use serde::{Deserialize, Serialize};

/// Number of states.
pub const NX: usize = 6;

/// Vehicle state in the Frenet frame of the track's centre line: the paper's
/// x = [v_x, v_y, omega_z, e_psi, s, e_y].
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct State {
    /// Longitudinal velocity of the centre of gravity, body frame [m/s].
    pub v_x: f64,
    /// Lateral velocity of the centre of gravity, body frame, positive to the left [m/s].
    pub v_y: f64,
    /// Yaw rate, positive counter-clockwise [rad/s].
    pub omega_z: f64,
    /// Heading relative to the centre line's tangent \[rad\].
    pub e_psi: f64,
    /// Progress along the centre line \[m\].
    pub s: f64,
    /// Signed lateral deviation from the centre line, positive to the left \[m\].
    ///
    /// The paper prints a distance, which has no sign; the signed deviation is meant.
    pub e_y: f64,
}

/// Pose in a global frame with the velocities of the body frame.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct GlobalState {
    /// Position of the centre of gravity \[m\].
    pub x: f64,
    /// Position of the centre of gravity \[m\].
    pub y: f64,
    /// Heading, zero along +x, positive counter-clockwise \[rad\].
    pub psi: f64,
    /// Longitudinal velocity, body frame [m/s].
    pub v_x: f64,
    /// Lateral velocity, body frame [m/s].
    pub v_y: f64,
    /// Yaw rate [rad/s].
    pub omega_z: f64,
}

impl State {
    /// The state as a vector [v_x, v_y, omega_z, e_psi, s, e_y].
    #[must_use]
    pub fn to_vector(self) -> Vector6<f64> {
        Vector6::new(self.v_x, self.v_y, self.omega_z, self.e_psi, self.s, self.e_y)
    }

    /// The state of a vector [v_x, v_y, omega_z, e_psi, s, e_y].
    #[must_use]
    pub fn from_vector(x: &Vector6<f64>) -> Self {
        Self { v_x: x[0], v_y: x[1], omega_z: x[2], e_psi: x[3], s: x[4], e_y: x[5] }
    }

    /// Whether every entry is a finite number.
    #[must_use]
    pub fn is_finite(&self) -> bool {
        self.to_vector().iter().all(|v| v.is_finite())
    }
}

impl GlobalState {
    /// Whether every entry is a finite number.
    #[must_use]
    pub fn is_finite(&self) -> bool {
        [self.x, self.y, self.psi, self.v_x, self.v_y, self.omega_z].iter().all(|v| v.is_finite())
    }
}
