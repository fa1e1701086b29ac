//! Dual numbers: a value and its derivatives by N directions, by the rules of the calculus.

use std::ops::{Add, Mul, Neg, Sub};

use super::{Function, Mask, Number};

/// A value and its gradient.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Dual<T, const N: usize> {
    /// The value.
    pub(crate) value: T,
    /// Derivative by each direction.
    pub(crate) gradient: [T; N],
}

impl<T: Number, const N: usize> Dual<T, N> {
    /// A number that depends on no direction.
    #[inline(always)]
    pub(crate) fn fixed(value: T) -> Self {
        Self { value, gradient: [value.constant(0.0); N] }
    }

    /// A number that is a direction itself.
    #[inline(always)]
    pub(crate) fn direction(value: T, direction: usize) -> Self {
        let mut number = Self::fixed(value);
        number.gradient[direction] = value.constant(1.0);
        number
    }

    /// The function value with the function's slope: the chain rule.
    #[inline(always)]
    fn chain(self, value: T, slope: T) -> Self {
        let mut gradient = self.gradient;
        for g in &mut gradient {
            *g = *g * slope;
        }
        Self { value, gradient }
    }
}

impl<T: Number, const N: usize> Number for Dual<T, N> {
    type Real = T::Real;

    #[inline(always)]
    fn real(self) -> T::Real {
        self.value.real()
    }

    #[inline(always)]
    fn constant(self, value: f64) -> Self {
        Self::fixed(self.value.constant(value))
    }

    #[inline(always)]
    fn scale(self, by: T::Real) -> Self {
        let mut gradient = self.gradient;
        for g in &mut gradient {
            *g = g.scale(by);
        }
        Self { value: self.value.scale(by), gradient }
    }

    #[inline(always)]
    fn recip(self) -> Self {
        let value = self.value.recip();
        self.chain(value, -(value * value))
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        let value = self.value.sqrt();
        self.chain(value, (value * 2.0).recip())
    }

    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        let (sin, cos) = self.value.sin_cos();
        (self.chain(sin, cos), self.chain(cos, -sin))
    }

    #[inline(always)]
    fn atan(self) -> Self {
        self.chain(self.value.atan(), (self.value * self.value + 1.0).recip())
    }

    /// Along one direction, whatever their number: the rest is the chain rule.
    #[inline(always)]
    fn through(self, f: &impl Function) -> Self {
        let found = f.at(Dual::<T, 1>::direction(self.value, 0));
        self.chain(found.value, found.gradient[0])
    }

    #[inline(always)]
    fn select(mask: Mask<Self>, yes: Self, no: Self) -> Self {
        let mut gradient = no.gradient;
        for (g, yes) in gradient.iter_mut().zip(yes.gradient) {
            *g = T::select(mask, yes, *g);
        }
        Self { value: T::select(mask, yes.value, no.value), gradient }
    }
}

impl<T: Number, const N: usize> Add for Dual<T, N> {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        let mut gradient = self.gradient;
        for (g, other) in gradient.iter_mut().zip(other.gradient) {
            *g = *g + other;
        }
        Self { value: self.value + other.value, gradient }
    }
}

impl<T: Number, const N: usize> Sub for Dual<T, N> {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        let mut gradient = self.gradient;
        for (g, other) in gradient.iter_mut().zip(other.gradient) {
            *g = *g - other;
        }
        Self { value: self.value - other.value, gradient }
    }
}

impl<T: Number, const N: usize> Mul for Dual<T, N> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        let mut gradient = self.gradient;
        for (g, by) in gradient.iter_mut().zip(other.gradient) {
            *g = *g * other.value + self.value * by;
        }
        Self { value: self.value * other.value, gradient }
    }
}

impl<T: Number, const N: usize> Neg for Dual<T, N> {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        let mut gradient = self.gradient;
        for g in &mut gradient {
            *g = -*g;
        }
        Self { value: -self.value, gradient }
    }
}

impl<T: Number, const N: usize> Add<f64> for Dual<T, N> {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: f64) -> Self {
        Self { value: self.value + other, ..self }
    }
}

impl<T: Number, const N: usize> Sub<f64> for Dual<T, N> {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: f64) -> Self {
        Self { value: self.value - other, ..self }
    }
}

impl<T: Number, const N: usize> Mul<f64> for Dual<T, N> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: f64) -> Self {
        let mut gradient = self.gradient;
        for g in &mut gradient {
            *g = *g * other;
        }
        Self { value: self.value * other, gradient }
    }
}
