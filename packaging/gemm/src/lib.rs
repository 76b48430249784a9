//! The functions of gemm that faer calls, as plain loops: see `Cargo.toml`. `unsafe`, as theirs: faer gives pointers and strides.
#![no_std]
#![allow(clippy::too_many_arguments, reason = "gemm has as many")]

use core::any::TypeId;
use core::mem::transmute_copy;

use nano_gemm::{Number, Strided, product};
use num_complex::Complex;

/// How many threads multiply. Here one does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Parallelism {
    /// The caller's.
    None,
    /// Several, of rayon.
    #[cfg(feature = "rayon")]
    Rayon(usize),
}

/// Multiply-adds from which gemm takes more than one thread.
pub fn get_threading_threshold() -> usize {
    48 * 48 * 256
}

/// `dst = alpha · dst + beta · lhs · rhs`; `dst` is not read unless `read_dst`.
///
/// # Safety
/// As of [`product`].
///
/// # Panics
/// `T` is no `f32`, `f64`, nor a complex number of them.
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
                // SAFETY: T is this type; the rest is the caller's.
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
