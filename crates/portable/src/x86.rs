//! Vectors in x86 registers: one of AVX-512, or two of AVX2.

use pulp::x86::{V3, V4};

use crate::operations::operations;
use crate::simd::Simd;

type Half32 = <V3 as pulp::Simd>::f32s;
type HalfU32 = <V3 as pulp::Simd>::u32s;
type Half64 = <V3 as pulp::Simd>::f64s;

/// A vector in two registers of AVX2, the lower half first.
#[derive(Clone, Copy, Debug)]
pub struct Two(pub V3);

macro_rules! in_one {
    ($($name:ident($($a:ident: $from:ident),*) -> $to:ident = $definition:expr;)*) => {
        impl Simd for V4 {
            type f32s = <V4 as pulp::Simd>::f32s;
            type f64s = <V4 as pulp::Simd>::f64s;
            type u32s = <V4 as pulp::Simd>::u32s;
            type m32s = <V4 as pulp::Simd>::m32s;

            #[inline(always)]
            fn splat_f32s(self, value: f32) -> Self::f32s {
                pulp::Simd::splat_f32s(self, value)
            }
            #[inline(always)]
            fn splat_u32s(self, value: u32) -> Self::u32s {
                pulp::Simd::splat_u32s(self, value)
            }
            #[inline(always)]
            fn splat_f64s(self, value: f64) -> Self::f64s {
                pulp::Simd::splat_f64s(self, value)
            }

            $(
                #[inline(always)]
                fn $name(self, $($a: Self::$from),*) -> Self::$to {
                    pulp::Simd::$name(self, $($a),*)
                }
            )*

            #[inline(always)]
            fn reduce_sum_f32s(self, a: Self::f32s) -> f32 {
                pulp::Simd::reduce_sum_f32s(self, a)
            }
            #[inline(always)]
            fn reduce_min_f32s(self, a: Self::f32s) -> f32 {
                pulp::Simd::reduce_min_f32s(self, a)
            }
            #[inline(always)]
            fn reduce_max_f32s(self, a: Self::f32s) -> f32 {
                pulp::Simd::reduce_max_f32s(self, a)
            }
            #[inline(always)]
            fn reduce_sum_f64s(self, a: Self::f64s) -> f64 {
                pulp::Simd::reduce_sum_f64s(self, a)
            }
            #[inline(always)]
            fn reduce_max_f64s(self, a: Self::f64s) -> f64 {
                pulp::Simd::reduce_max_f64s(self, a)
            }

            #[inline(always)]
            fn as_simd_f32s(slice: &[f32]) -> (&[Self::f32s], &[f32]) {
                <V4 as pulp::Simd>::as_simd_f32s(slice)
            }
            #[inline(always)]
            fn as_mut_simd_f32s(slice: &mut [f32]) -> (&mut [Self::f32s], &mut [f32]) {
                <V4 as pulp::Simd>::as_mut_simd_f32s(slice)
            }
            #[inline(always)]
            fn as_simd_u32s(slice: &[u32]) -> (&[Self::u32s], &[u32]) {
                <V4 as pulp::Simd>::as_simd_u32s(slice)
            }
            #[inline(always)]
            fn as_mut_simd_u32s(slice: &mut [u32]) -> (&mut [Self::u32s], &mut [u32]) {
                <V4 as pulp::Simd>::as_mut_simd_u32s(slice)
            }
            #[inline(always)]
            fn as_simd_f64s(slice: &[f64]) -> (&[Self::f64s], &[f64]) {
                <V4 as pulp::Simd>::as_simd_f64s(slice)
            }
            #[inline(always)]
            fn as_mut_simd_f64s(slice: &mut [f64]) -> (&mut [Self::f64s], &mut [f64]) {
                <V4 as pulp::Simd>::as_mut_simd_f64s(slice)
            }
        }
    };
}

operations!(in_one);

/// The pairs of registers in a slice, and the remainder.
macro_rules! pairs {
    ($slice:ident, $lanes:literal, $as_simd:ident) => {{
        let (whole, rest) = $slice.split_at($slice.len() / $lanes * $lanes);
        (<V3 as pulp::Simd>::$as_simd(whole).0.as_chunks().0, rest)
    }};
    (mut $slice:ident, $lanes:literal, $as_simd:ident) => {{
        let (whole, rest) = $slice.split_at_mut($slice.len() / $lanes * $lanes);
        (
            <V3 as pulp::Simd>::$as_simd(whole).0.as_chunks_mut().0,
            rest,
        )
    }};
}

macro_rules! in_two {
    ($($name:ident($($a:ident: $from:ident),*) -> $to:ident = $definition:expr;)*) => {
        impl Simd for Two {
            type f32s = [Half32; 2];
            type f64s = [Half64; 2];
            type u32s = [HalfU32; 2];
            type m32s = [<V3 as pulp::Simd>::m32s; 2];

            #[inline(always)]
            fn splat_f32s(self, value: f32) -> Self::f32s {
                [pulp::Simd::splat_f32s(self.0, value); 2]
            }
            #[inline(always)]
            fn splat_u32s(self, value: u32) -> Self::u32s {
                [pulp::Simd::splat_u32s(self.0, value); 2]
            }
            #[inline(always)]
            fn splat_f64s(self, value: f64) -> Self::f64s {
                [pulp::Simd::splat_f64s(self.0, value); 2]
            }

            $(
                #[inline(always)]
                fn $name(self, $($a: Self::$from),*) -> Self::$to {
                    [
                        pulp::Simd::$name(self.0, $($a[0]),*),
                        pulp::Simd::$name(self.0, $($a[1]),*),
                    ]
                }
            )*

            #[inline(always)]
            fn reduce_sum_f32s(self, [low, high]: Self::f32s) -> f32 {
                let halves = pulp::Simd::add_f32s(self.0, low, high);
                pulp::Simd::reduce_sum_f32s(self.0, halves)
            }
            #[inline(always)]
            fn reduce_min_f32s(self, [low, high]: Self::f32s) -> f32 {
                let halves = pulp::Simd::min_f32s(self.0, low, high);
                pulp::Simd::reduce_min_f32s(self.0, halves)
            }
            #[inline(always)]
            fn reduce_max_f32s(self, [low, high]: Self::f32s) -> f32 {
                let halves = pulp::Simd::max_f32s(self.0, low, high);
                pulp::Simd::reduce_max_f32s(self.0, halves)
            }
            #[inline(always)]
            fn reduce_sum_f64s(self, [low, high]: Self::f64s) -> f64 {
                let halves = pulp::Simd::add_f64s(self.0, low, high);
                pulp::Simd::reduce_sum_f64s(self.0, halves)
            }
            #[inline(always)]
            fn reduce_max_f64s(self, [low, high]: Self::f64s) -> f64 {
                let halves = pulp::Simd::max_f64s(self.0, low, high);
                pulp::Simd::reduce_max_f64s(self.0, halves)
            }

            #[inline(always)]
            fn as_simd_f32s(slice: &[f32]) -> (&[Self::f32s], &[f32]) {
                pairs!(slice, 16, as_simd_f32s)
            }
            #[inline(always)]
            fn as_mut_simd_f32s(slice: &mut [f32]) -> (&mut [Self::f32s], &mut [f32]) {
                pairs!(mut slice, 16, as_mut_simd_f32s)
            }
            #[inline(always)]
            fn as_simd_u32s(slice: &[u32]) -> (&[Self::u32s], &[u32]) {
                pairs!(slice, 16, as_simd_u32s)
            }
            #[inline(always)]
            fn as_mut_simd_u32s(slice: &mut [u32]) -> (&mut [Self::u32s], &mut [u32]) {
                pairs!(mut slice, 16, as_mut_simd_u32s)
            }
            #[inline(always)]
            fn as_simd_f64s(slice: &[f64]) -> (&[Self::f64s], &[f64]) {
                pairs!(slice, 8, as_simd_f64s)
            }
            #[inline(always)]
            fn as_mut_simd_f64s(slice: &mut [f64]) -> (&mut [Self::f64s], &mut [f64]) {
                pairs!(mut slice, 8, as_mut_simd_f64s)
            }
        }
    };
}

operations!(in_two);
