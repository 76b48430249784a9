//! Vectors of floats with arithmetic operators.
//!
//! All functions are force-inlined, and closures over vectors are avoided. A function that is not
//! inlined is not compiled for the machine's vector registers.

use lariat_portable::Simd;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// Number of floats in a vector.
pub(super) const LANES: usize = 16;
/// A float in each lane.
pub(super) type Lanes = [f32; LANES];

/// A vector of floats.
#[derive(Clone, Copy)]
pub(super) struct Floats<S: Simd> {
    simd: S,
    lanes: S::f32s,
}

impl<S: Simd> Floats<S> {
    /// Creates a vector with the number in every lane.
    #[inline(always)]
    pub(super) fn splat(simd: S, number: f32) -> Self {
        let lanes = simd.splat_f32s(number);
        Self { simd, lanes }
    }

    /// Loads the first numbers of a slice, one per lane.
    #[inline(always)]
    pub(super) fn of(simd: S, numbers: &[f32]) -> Self {
        let lanes = S::as_simd_f32s(numbers).0[0];
        Self { simd, lanes }
    }

    /// Returns the number in each lane.
    #[inline(always)]
    pub(super) fn lanes(self) -> Lanes {
        let mut lanes = [0.0; LANES];
        S::as_mut_simd_f32s(&mut lanes).0[0] = self.lanes;
        lanes
    }

    #[inline(always)]
    pub(super) fn sqrt(self) -> Self {
        self.with(self.simd.sqrt_f32s(self.lanes))
    }

    #[inline(always)]
    pub(super) fn abs(self) -> Self {
        self.with(self.simd.abs_f32s(self.lanes))
    }

    #[inline(always)]
    pub(super) fn min(self, other: Self) -> Self {
        self.with(self.simd.min_f32s(self.lanes, other.lanes))
    }

    #[inline(always)]
    pub(super) fn max(self, other: Self) -> Self {
        self.with(self.simd.max_f32s(self.lanes, other.lanes))
    }

    /// Selects `self` where `a < b`, and `other` elsewhere.
    #[inline(always)]
    pub(super) fn where_less(self, a: Self, b: Self, other: Self) -> Self {
        let is_less = self.simd.less_than_f32s(a.lanes, b.lanes);
        self.with(self.simd.select_f32s(is_less, self.lanes, other.lanes))
    }

    /// Rounds to the nearest integers, for absolute values below 4 million.
    #[inline(always)]
    pub(super) fn rounded(self) -> Self {
        let rounding = Self::splat(self.simd, 12_582_912.0);
        (self + rounding) - rounding
    }

    #[inline(always)]
    pub(super) fn least(self) -> f32 {
        self.simd.reduce_min_f32s(self.lanes)
    }

    #[inline(always)]
    fn with(self, lanes: S::f32s) -> Self {
        Self { lanes, ..self }
    }
}

impl<S: Simd> Add for Floats<S> {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.with(self.simd.add_f32s(self.lanes, other.lanes))
    }
}

impl<S: Simd> Sub for Floats<S> {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.with(self.simd.sub_f32s(self.lanes, other.lanes))
    }
}

impl<S: Simd> Mul for Floats<S> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self.with(self.simd.mul_f32s(self.lanes, other.lanes))
    }
}

impl<S: Simd> Div for Floats<S> {
    type Output = Self;

    #[inline(always)]
    fn div(self, other: Self) -> Self {
        self.with(self.simd.div_f32s(self.lanes, other.lanes))
    }
}

impl<S: Simd> Neg for Floats<S> {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Self::splat(self.simd, 0.0) - self
    }
}
