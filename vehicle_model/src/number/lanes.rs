//! Several cars side by side, one in each lane of the widest vector register the processor has.

use std::ops::{Add, Div, Mul, Neg, Sub};

use pulp::{Simd, bytemuck};

use super::{Number, Real, elementary};

/// One number of every lane.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Lanes<S: Simd> {
    simd: S,
    lanes: S::f64s,
}

impl<S: Simd> Lanes<S> {
    /// `value(i)` in lane i.
    #[inline(always)]
    pub(crate) fn from_fn(simd: S, value: impl FnMut(usize) -> f64) -> Self {
        let mut lanes = [simd.splat_f64s(0.0)];
        let each: &mut [f64] = bytemuck::cast_slice_mut(&mut lanes);
        for (lane, value) in each.iter_mut().zip((0..).map(value)) {
            *lane = value;
        }
        Self { simd, lanes: lanes[0] }
    }

    /// The number in lane i.
    #[inline(always)]
    pub(crate) fn lane(&self, i: usize) -> f64 {
        let lanes = [self.lanes];
        let each: &[f64] = bytemuck::cast_slice(&lanes);
        each[i]
    }

    #[inline(always)]
    fn with(self, lanes: S::f64s) -> Self {
        Self { simd: self.simd, lanes }
    }
}

impl<S: Simd> Number for Lanes<S> {
    type Real = Self;
    const PLAIN: bool = true;

    #[inline(always)]
    fn real(self) -> Self {
        self
    }

    #[inline(always)]
    fn constant(self, value: f64) -> Self {
        self.with(self.simd.splat_f64s(value))
    }

    #[inline(always)]
    fn scale(self, by: Self) -> Self {
        self * by
    }

    #[inline(always)]
    fn recip(self) -> Self {
        self.constant(1.0) / self
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        self.with(self.simd.sqrt_f64s(self.lanes))
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
    fn select(mask: S::m64s, yes: Self, no: Self) -> Self {
        yes.with(yes.simd.select_f64s(mask, yes.lanes, no.lanes))
    }
}

impl<S: Simd> Real for Lanes<S> {
    type Mask = S::m64s;

    #[inline(always)]
    fn less(self, than: Self) -> S::m64s {
        self.simd.less_than_f64s(self.lanes, than.lanes)
    }

    #[inline(always)]
    fn any(self, mask: S::m64s) -> bool {
        self.simd.first_true_m64s(mask) < S::F64_LANES
    }

    #[inline(always)]
    fn map(self, mut f: impl FnMut(f64) -> f64) -> Self {
        let mut lanes = [self.lanes];
        let each: &mut [f64] = bytemuck::cast_slice_mut(&mut lanes);
        for lane in each {
            *lane = f(*lane);
        }
        self.with(lanes[0])
    }

    #[inline(always)]
    fn map_with<const N: usize>(
        self,
        others: [Self; N],
        mut f: impl FnMut(f64, [f64; N]) -> f64,
    ) -> Self {
        let mut lane = 0;
        self.map(|value| {
            lane += 1;
            f(value, others.map(|other| other.lane(lane - 1)))
        })
    }
}

/// Arithmetic of lanes with lanes and with one number for all of them.
macro_rules! arithmetic {
    ($($operator:ident $method:ident $vector:ident),*) => {$(
        impl<S: Simd> $operator for Lanes<S> {
            type Output = Self;

            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                self.with(self.simd.$vector(self.lanes, other.lanes))
            }
        }

        impl<S: Simd> $operator<f64> for Lanes<S> {
            type Output = Self;

            #[inline(always)]
            fn $method(self, other: f64) -> Self {
                self.with(self.simd.$vector(self.lanes, self.simd.splat_f64s(other)))
            }
        }
    )*};
}

arithmetic!(Add add add_f64s, Sub sub sub_f64s, Mul mul mul_f64s, Div div div_f64s);

impl<S: Simd> Neg for Lanes<S> {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        self.with(self.simd.neg_f64s(self.lanes))
    }
}
