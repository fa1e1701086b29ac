//! Affine time-varying model of one period.

use nalgebra::{Matrix6, Matrix6x2, Vector2, Vector6};

/// x_plus = A x + B u + C, linearised at one point of the horizon.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Affine {
    /// A, 6 x 6.
    pub a: Matrix6<f64>,
    /// B, 6 x 2.
    pub b: Matrix6x2<f64>,
    /// C, 6.
    pub c: Vector6<f64>,
}

impl Affine {
    /// A x + B u + C.
    #[must_use]
    pub fn apply(&self, x: &Vector6<f64>, u: &Vector2<f64>) -> Vector6<f64> {
        self.a * x + self.b * u + self.c
    }
}

impl std::ops::Add for Affine {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self { a: self.a + other.a, b: self.b + other.b, c: self.c + other.c }
    }
}
