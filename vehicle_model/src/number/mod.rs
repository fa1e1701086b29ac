//! The numbers the equations can be evaluated with.
//!
//! Every equation stands once, over a [`Number`]: plain `f64`, several cars side by side in the
//! lanes of a vector register ([`Lanes`]), either of them with derivatives ([`Dual`]), or `f64`
//! with second derivatives too ([`Jet`]). All of
//! them do the same operations in the same order, so that their values agree to the last bit on
//! every processor. A comparison gives a mask and the result is selected: lanes may disagree.

mod dual;
mod elementary;
mod jet;
mod lanes;

use std::ops::{Add, Div, Mul, Neg, Sub};

pub(crate) use dual::Dual;
pub(crate) use jet::Jet;
pub(crate) use lanes::Lanes;

/// A number of the equations.
pub(crate) trait Number:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Neg<Output = Self>
    + Add<f64, Output = Self>
    + Sub<f64, Output = Self>
    + Mul<f64, Output = Self>
{
    /// The number without its derivatives.
    type Real: Real;
    /// Whether it has no derivatives.
    const PLAIN: bool = false;

    /// Its value.
    fn real(self) -> Self::Real;
    /// A constant of the kind of `self`.
    fn constant(self, value: f64) -> Self;
    /// Product with a number that has no derivatives.
    fn scale(self, by: Self::Real) -> Self;
    /// 1/x.
    fn recip(self) -> Self;
    /// Square root.
    fn sqrt(self) -> Self;
    /// Sine and cosine.
    fn sin_cos(self) -> (Self, Self);
    /// Inverse tangent.
    fn atan(self) -> Self;
    /// `yes` where the mask holds, else `no`.
    fn select(mask: Mask<Self>, yes: Self, no: Self) -> Self;

    /// A function of it.
    #[inline(always)]
    fn through(self, f: &impl Function) -> Self {
        f.at(self)
    }

    /// Absolute value.
    #[inline(always)]
    fn abs(self) -> Self {
        Self::select(self.below(0.0), -self, self)
    }

    /// Where the value is below `limit`.
    #[inline(always)]
    fn below(self, limit: f64) -> Mask<Self> {
        self.real().less(self.real().constant(limit))
    }

    /// Where the value is above `limit`.
    #[inline(always)]
    fn above(self, limit: f64) -> Mask<Self> {
        self.real().constant(limit).less(self.real())
    }
}

/// Truth of a comparison of numbers of one kind, lane by lane.
pub(crate) type Mask<T> = <<T as Number>::Real as Real>::Mask;

/// A function of one number. A closure would not take numbers of every kind.
pub(crate) trait Function {
    /// Its value.
    fn at<T: Number>(&self, x: T) -> T;
}

/// A number without derivatives.
pub(crate) trait Real: Number<Real = Self> + Div<Output = Self> {
    /// Truth of a comparison.
    type Mask: Copy;

    /// Where `self < than`.
    fn less(self, than: Self) -> Self::Mask;
    /// Whether the mask holds in any lane.
    fn any(self, mask: Self::Mask) -> bool;
    /// `f` of every lane.
    fn map(self, f: impl FnMut(f64) -> f64) -> Self;
    /// `f` of every lane and those of `others`.
    fn map_with<const N: usize>(
        self,
        others: [Self; N],
        f: impl FnMut(f64, [f64; N]) -> f64,
    ) -> Self;
}

impl Number for f64 {
    type Real = Self;
    const PLAIN: bool = true;

    #[inline(always)]
    fn real(self) -> Self {
        self
    }

    #[inline(always)]
    fn constant(self, value: f64) -> Self {
        value
    }

    #[inline(always)]
    fn scale(self, by: Self) -> Self {
        self * by
    }

    #[inline(always)]
    fn recip(self) -> Self {
        1.0 / self
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self::sqrt(self)
    }

    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        elementary::sin_cos(self)
    }

    #[inline(always)]
    fn atan(self) -> Self {
        elementary::atan(self)
    }

    #[inline(always)]
    fn select(mask: bool, yes: Self, no: Self) -> Self {
        if mask { yes } else { no }
    }
}

impl Real for f64 {
    type Mask = bool;

    #[inline(always)]
    fn less(self, than: Self) -> bool {
        self < than
    }

    #[inline(always)]
    fn any(self, mask: bool) -> bool {
        mask
    }

    #[inline(always)]
    fn map(self, mut f: impl FnMut(f64) -> f64) -> Self {
        f(self)
    }

    #[inline(always)]
    fn map_with<const N: usize>(
        self,
        others: [Self; N],
        mut f: impl FnMut(f64, [f64; N]) -> f64,
    ) -> Self {
        f(self, others)
    }
}
