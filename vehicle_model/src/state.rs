//! State and input vectors, in the one order used everywhere: struct, vector, CSV, LCM, FMU.

use nalgebra::Vector2;
use serde::{Deserialize, Serialize};

pub use track::{GlobalState, NX, State};

/// Number of inputs.
pub const NU: usize = 2;

/// Control input u = [a, delta].
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Input {
    /// Longitudinal acceleration command [m/s^2].
    pub a: f64,
    /// Front steering angle, positive to the left \[rad\].
    pub delta: f64,
}

impl Input {
    /// The input as a vector [a, delta].
    #[must_use]
    pub fn to_vector(self) -> Vector2<f64> {
        Vector2::new(self.a, self.delta)
    }

    /// The input of a vector [a, delta].
    #[must_use]
    pub fn from_vector(u: &Vector2<f64>) -> Self {
        Self { a: u[0], delta: u[1] }
    }

    /// Whether both entries are finite numbers.
    #[must_use]
    pub fn is_finite(&self) -> bool {
        self.a.is_finite() && self.delta.is_finite()
    }
}
