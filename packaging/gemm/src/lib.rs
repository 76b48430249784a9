//! The functions of gemm that faer calls, as plain loops: see `Cargo.toml`. They are `unsafe` like
//! the originals, because faer passes pointers and strides.
#![no_std]
#![allow(clippy::too_many_arguments, reason = "gemm has as many")]

use core::any::TypeId;
use core::mem::transmute_copy;

use nano_gemm::{Number, Strided, product};
use num_complex::Complex;

/// Number of threads that multiply. This crate uses one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Parallelism {
    /// The caller's thread.
    None,
    /// Several threads of rayon.
    #[cfg(feature = "rayon")]
    Rayon(usize),
}

/// Number of multiply-adds from which gemm uses more than one thread.
pub fn get_threading_threshold() -> usize {
    48 * 48 * 256
}

/// Computes `dst = alpha · dst + beta · lhs · rhs`; `dst` is not read unless `read_dst`.
///
/// # Safety
/// The same as for [`product`].
///
/// # Panics
/// Panics if `T` is not `f32`, `f64`, or a complex number of these.
pub unsafe fn gemm<T: 'static>(
    m: usize,
    n: usize,
    k: usize,
    dst: *mut T,
    dst_cs: isize,
    dst_rs: isize,
    read_dst: bool,
    lhs: *const T,
    lhs_cs: isize,
    lhs_rs: isize,
    rhs: *const T,
    rhs_cs: isize,
    rhs_rs: isize,
    alpha: T,
    beta: T,
    _conj_dst: bool,
    conj_lhs: bool,
    conj_rhs: bool,
    _parallelism: Parallelism,
) {
    macro_rules! of {
        ($($number:ty)*) => {$(
            if TypeId::of::<T>() == TypeId::of::<$number>() {
                let into = Strided { start: dst.cast::<$number>(), row: dst_rs, column: dst_cs };
                let lhs = Strided { start: lhs.cast(), row: lhs_rs, column: lhs_cs };
                let rhs = Strided { start: rhs.cast(), row: rhs_rs, column: rhs_cs };
                // SAFETY: `T` is this type; the caller guarantees the rest.
                unsafe {
                    let (alpha, beta) = (transmute_copy(&alpha), transmute_copy(&beta));
                    let alpha = if read_dst { alpha } else { <$number>::ZERO };
                    product([m, n, k], into, [alpha, beta], (lhs, conj_lhs), (rhs, conj_rhs));
                }
                return;
            }
        )*};
    }
    of!(f32 f64 Complex<f32> Complex<f64>);
    panic!("no such number is multiplied");
}
