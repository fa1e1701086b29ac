//! Numbers with first and second derivatives by N directions: truncated Taylor series. The Hessian
//! is kept as its lower triangle, row by row.

use std::ops::{Add, Mul, Neg, Sub};

use super::{Mask, Number};

/// A value, its gradient and the M = N (N + 1)/2 different entries of its Hessian.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Jet<const N: usize, const M: usize> {
    /// The value.
    pub(crate) value: f64,
    /// Derivative by each direction.
    pub(crate) gradient: [f64; N],
    /// Second derivative by directions i and j <= i at i (i + 1)/2 + j.
    pub(crate) hessian: [f64; M],
}

impl<const N: usize, const M: usize> Jet<N, M> {
    /// A number that depends on no direction.
    #[inline(always)]
    pub(crate) fn fixed(value: f64) -> Self {
        Self { value, gradient: [0.0; N], hessian: [0.0; M] }
    }

    /// A number that is a direction itself.
    #[inline(always)]
    pub(crate) fn direction(value: f64, direction: usize) -> Self {
        let mut number = Self::fixed(value);
        number.gradient[direction] = 1.0;
        number
    }

    /// Second derivative by directions i and j.
    pub(crate) fn second(&self, i: usize, j: usize) -> f64 {
        let (i, j) = (i.max(j), i.min(j));
        self.hessian[i * (i + 1) / 2 + j]
    }

    /// The function value with the function's slope and curvature: the chain rule.
    #[inline]
    fn chain(&self, value: f64, slope: f64, curvature: f64) -> Self {
        let mut out = Self::fixed(value);
        let mut at = 0;
        for i in 0..N {
            out.gradient[i] = self.gradient[i] * slope;
            let bend = self.gradient[i] * curvature;
            for j in 0..=i {
                out.hessian[at] = self.hessian[at] * slope + bend * self.gradient[j];
                at += 1;
            }
        }
        out
    }

    #[inline(always)]
    fn each(self, other: &Self, f: impl Fn(f64, f64) -> f64) -> Self {
        let mut out = self;
        out.value = f(self.value, other.value);
        for (own, other) in out.gradient.iter_mut().zip(&other.gradient) {
            *own = f(*own, *other);
        }
        for (own, other) in out.hessian.iter_mut().zip(&other.hessian) {
            *own = f(*own, *other);
        }
        out
    }

    #[inline(always)]
    fn map(self, f: impl Fn(f64) -> f64) -> Self {
        Self {
            value: f(self.value),
            gradient: self.gradient.map(&f),
            hessian: self.hessian.map(&f),
        }
    }
}

impl<const N: usize, const M: usize> Number for Jet<N, M> {
    type Real = f64;

    #[inline(always)]
    fn real(self) -> f64 {
        self.value
    }

    #[inline(always)]
    fn constant(self, value: f64) -> Self {
        Self::fixed(value)
    }

    #[inline(always)]
    fn scale(self, by: f64) -> Self {
        self * by
    }

    #[inline(always)]
    fn recip(self) -> Self {
        let value = self.value.recip();
        let square = value * value;
        self.chain(value, -square, 2.0 * square * value)
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        let value = Number::sqrt(self.value);
        let slope = (value * 2.0).recip();
        self.chain(value, slope, -slope / (2.0 * self.value))
    }

    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        let (sin, cos) = Number::sin_cos(self.value);
        (self.chain(sin, cos, -sin), self.chain(cos, -sin, -cos))
    }

    #[inline(always)]
    fn atan(self) -> Self {
        let slope = (self.value * self.value + 1.0).recip();
        let value = Number::atan(self.value);
        self.chain(value, slope, -2.0 * self.value * slope * slope)
    }

    #[inline(always)]
    fn select(mask: Mask<Self>, yes: Self, no: Self) -> Self {
        if mask { yes } else { no }
    }
}

impl<const N: usize, const M: usize> Add for Jet<N, M> {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.each(&other, |a, b| a + b)
    }
}

impl<const N: usize, const M: usize> Sub for Jet<N, M> {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.each(&other, |a, b| a - b)
    }
}

impl<const N: usize, const M: usize> Mul for Jet<N, M> {
    type Output = Self;

    #[inline]
    fn mul(self, other: Self) -> Self {
        let (a, b) = (&self, &other);
        let mut out = Self::fixed(a.value * b.value);
        let mut at = 0;
        for i in 0..N {
            out.gradient[i] = a.gradient[i] * b.value + a.value * b.gradient[i];
            for j in 0..=i {
                out.hessian[at] = a.hessian[at] * b.value
                    + a.value * b.hessian[at]
                    + a.gradient[i] * b.gradient[j]
                    + a.gradient[j] * b.gradient[i];
                at += 1;
            }
        }
        out
    }
}

impl<const N: usize, const M: usize> Neg for Jet<N, M> {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        self.map(|x| -x)
    }
}

impl<const N: usize, const M: usize> Add<f64> for Jet<N, M> {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: f64) -> Self {
        Self { value: self.value + other, ..self }
    }
}

impl<const N: usize, const M: usize> Sub<f64> for Jet<N, M> {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: f64) -> Self {
        Self { value: self.value - other, ..self }
    }
}

impl<const N: usize, const M: usize> Mul<f64> for Jet<N, M> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: f64) -> Self {
        self.map(|x| x * other)
    }
}
