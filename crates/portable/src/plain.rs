//! Vectors as arrays: the definition, and the implementation for machines without wide registers
//! known to pulp. The compiler turns its loops into the baseline instructions (SSE2, NEON).

use crate::operations::operations;
use crate::simd::Simd;

/// Vectors as arrays.
#[derive(Clone, Copy, Debug)]
pub struct Plain;

/// Combines both halves until one number is left.
macro_rules! halve {
    ($a:ident, $number:ident, $lanes:literal, |$x:ident, $y:ident| $joined:expr) => {{
        let mut numbers = $a;
        let mut half = $lanes / 2;
        while half > 0 {
            for i in 0..half {
                let ($x, $y): ($number, $number) = (numbers[i], numbers[i + half]);
                numbers[i] = $joined;
            }
            half /= 2;
        }
        numbers[0]
    }};
}

macro_rules! define {
    ($($name:ident($($a:ident: $from:ident),*) -> $to:ident = $definition:expr;)*) => {
        impl Simd for Plain {
            type f32s = [f32; 16];
            type f64s = [f64; 8];
            type u32s = [u32; 16];
            type m32s = [bool; 16];

            #[inline(always)]
            fn splat_f32s(self, value: f32) -> Self::f32s {
                [value; 16]
            }
            #[inline(always)]
            fn splat_u32s(self, value: u32) -> Self::u32s {
                [value; 16]
            }
            #[inline(always)]
            fn splat_f64s(self, value: f64) -> Self::f64s {
                [value; 8]
            }

            $(
                #[inline(always)]
                fn $name(self, $($a: Self::$from),*) -> Self::$to {
                    std::array::from_fn(
                        #[inline(always)]
                        |i| {
                            $(let $a = $a[i];)*
                            $definition
                        },
                    )
                }
            )*

            #[inline(always)]
            fn reduce_sum_f32s(self, a: Self::f32s) -> f32 {
                halve!(a, f32, 16, |x, y| x + y)
            }
            #[inline(always)]
            fn reduce_min_f32s(self, a: Self::f32s) -> f32 {
                halve!(a, f32, 16, |x, y| if x < y { x } else { y })
            }
            #[inline(always)]
            fn reduce_max_f32s(self, a: Self::f32s) -> f32 {
                halve!(a, f32, 16, |x, y| if x > y { x } else { y })
            }
            #[inline(always)]
            fn reduce_sum_f64s(self, a: Self::f64s) -> f64 {
                halve!(a, f64, 8, |x, y| x + y)
            }
            #[inline(always)]
            fn reduce_max_f64s(self, a: Self::f64s) -> f64 {
                halve!(a, f64, 8, |x, y| if x > y { x } else { y })
            }

            #[inline(always)]
            fn as_simd_f32s(slice: &[f32]) -> (&[Self::f32s], &[f32]) {
                slice.as_chunks()
            }
            #[inline(always)]
            fn as_mut_simd_f32s(slice: &mut [f32]) -> (&mut [Self::f32s], &mut [f32]) {
                slice.as_chunks_mut()
            }
            #[inline(always)]
            fn as_simd_u32s(slice: &[u32]) -> (&[Self::u32s], &[u32]) {
                slice.as_chunks()
            }
            #[inline(always)]
            fn as_mut_simd_u32s(slice: &mut [u32]) -> (&mut [Self::u32s], &mut [u32]) {
                slice.as_chunks_mut()
            }
            #[inline(always)]
            fn as_simd_f64s(slice: &[f64]) -> (&[Self::f64s], &[f64]) {
                slice.as_chunks()
            }
            #[inline(always)]
            fn as_mut_simd_f64s(slice: &mut [f64]) -> (&mut [Self::f64s], &mut [f64]) {
                slice.as_chunks_mut()
            }
        }
    };
}

operations!(define);
