//! Vectors of 512 bits.

use std::fmt::Debug;

use crate::operations::operations;

macro_rules! declare {
    ($($name:ident($($a:ident: $from:ident),*) -> $to:ident = $definition:expr;)*) => {
        /// Vectors of 512 bits, 16 floats or 8 doubles, in any kind of registers. The names are
        /// those of `pulp::Simd`.
        ///
        /// Minimum and maximum behave as on x86: they return the second operand if both are equal
        /// or one is NaN.
        #[allow(non_camel_case_types, reason = "pulp's names")]
        pub trait Simd: Copy + Debug + Send + Sync + 'static {
            /// Floats in a vector.
            const F32_LANES: usize = 16;
            /// Doubles in a vector.
            const F64_LANES: usize = 8;

            /// 16 floats.
            type f32s: Copy + Debug + Send + Sync + 'static;
            /// 8 doubles.
            type f64s: Copy + Debug + Send + Sync + 'static;
            /// 16 integers.
            type u32s: Copy + Debug + Send + Sync + 'static;
            /// 16 bools.
            type m32s: Copy + Debug + Send + Sync + 'static;

            /// The number in every lane.
            fn splat_f32s(self, value: f32) -> Self::f32s;
            /// The number in every lane.
            fn splat_u32s(self, value: u32) -> Self::u32s;
            /// The number in every lane.
            fn splat_f64s(self, value: f64) -> Self::f64s;

            $(
                #[doc = concat!("`", stringify!($definition), "` in every lane.")]
                fn $name(self, $($a: Self::$from),*) -> Self::$to;
            )*

            /// `a·b + c` in every lane, with the product rounded before the sum. Rounding only once
            /// takes fifty times as long on machines without such an instruction.
            #[inline(always)]
            fn mul_add_f32s(self, a: Self::f32s, b: Self::f32s, c: Self::f32s) -> Self::f32s {
                self.add_f32s(self.mul_f32s(a, b), c)
            }

            /// The same as [`mul_add_f32s`](Self::mul_add_f32s), for doubles.
            #[inline(always)]
            fn mul_add_f64s(self, a: Self::f64s, b: Self::f64s, c: Self::f64s) -> Self::f64s {
                self.add_f64s(self.mul_f64s(a, b), c)
            }

            /// The sum of all lanes: adds the upper half to the lower half, lane by lane, until one
            /// lane is left.
            fn reduce_sum_f32s(self, a: Self::f32s) -> f32;
            /// The minimum of all lanes, in the order of
            /// [`reduce_sum_f32s`](Self::reduce_sum_f32s).
            fn reduce_min_f32s(self, a: Self::f32s) -> f32;
            /// The maximum of all lanes, in the same order.
            fn reduce_max_f32s(self, a: Self::f32s) -> f32;
            /// The sum of all lanes, in the same order.
            fn reduce_sum_f64s(self, a: Self::f64s) -> f64;
            /// The maximum of all lanes, in the same order.
            fn reduce_max_f64s(self, a: Self::f64s) -> f64;

            /// The vectors of a slice, and the remainder.
            fn as_simd_f32s(slice: &[f32]) -> (&[Self::f32s], &[f32]);
            /// The vectors of a slice, and the remainder.
            fn as_mut_simd_f32s(slice: &mut [f32]) -> (&mut [Self::f32s], &mut [f32]);
            /// The vectors of a slice, and the remainder.
            fn as_simd_u32s(slice: &[u32]) -> (&[Self::u32s], &[u32]);
            /// The vectors of a slice, and the remainder.
            fn as_mut_simd_u32s(slice: &mut [u32]) -> (&mut [Self::u32s], &mut [u32]);
            /// The vectors of a slice, and the remainder.
            fn as_simd_f64s(slice: &[f64]) -> (&[Self::f64s], &[f64]);
            /// The vectors of a slice, and the remainder.
            fn as_mut_simd_f64s(slice: &mut [f64]) -> (&mut [Self::f64s], &mut [f64]);
        }
    };
}

operations!(declare);
