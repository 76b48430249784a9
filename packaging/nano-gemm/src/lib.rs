//! The functions of nano-gemm that faer calls, as plain loops: see `Cargo.toml`. They are `unsafe`
//! like the originals, because faer passes pointers and strides.
#![no_std]
#![allow(clippy::too_many_arguments, reason = "nano-gemm has as many")]

use core::ops::{Add, Mul};

use num_complex::Complex;

/// An element of a matrix.
pub trait Number: Copy + Add<Output = Self> + Mul<Output = Self> + PartialEq {
    /// Zero.
    const ZERO: Self;
    /// Returns the complex conjugate.
    fn conjugate(self) -> Self;
}

macro_rules! numbers {
    ($($real:ty)*) => {$(
        impl Number for $real {
            const ZERO: Self = 0.0;
            fn conjugate(self) -> Self {
                self
            }
        }

        impl Number for Complex<$real> {
            const ZERO: Self = Complex::new(0.0, 0.0);
            fn conjugate(self) -> Self {
                self.conj()
            }
        }
    )*};
}
numbers!(f32 f64);

/// A matrix of `T` in memory.
#[derive(Clone, Copy)]
pub struct Strided<T> {
    /// First element.
    pub start: T,
    /// Distance from row to row, in elements.
    pub row: isize,
    /// Distance from column to column, in elements.
    pub column: isize,
}

impl<T> Strided<T> {
    fn offset(&self, row: usize, column: usize) -> isize {
        row as isize * self.row + column as isize * self.column
    }
}

/// Computes `into = alpha · into + beta · lhs · rhs`; `into` is not read if `alpha` is 0.
///
/// # Safety
/// `into` is m × n, `lhs` m × k and `rhs` k × n. All elements must be readable. Those of `into`
/// must be writable and must not overlap the other two matrices.
pub unsafe fn product<T: Number>(
    [m, n, k]: [usize; 3],
    into: Strided<*mut T>,
    [alpha, beta]: [T; 2],
    (lhs, conj_lhs): (Strided<*const T>, bool),
    (rhs, conj_rhs): (Strided<*const T>, bool),
) {
    // SAFETY: the caller guarantees it for each element of the matrix.
    let read = |from: &Strided<*const T>, row, column, conj| unsafe {
        let number = *from.start.offset(from.offset(row, column));
        if conj { number.conjugate() } else { number }
    };
    for column in 0..n {
        for row in 0..m {
            let terms =
                (0..k).map(|l| read(&lhs, row, l, conj_lhs) * read(&rhs, l, column, conj_rhs));
            let sum = beta * terms.fold(T::ZERO, |sum, term| sum + term);
            // SAFETY: as above, for an element of `into`.
            unsafe {
                let number = into.start.offset(into.offset(row, column));
                *number = if alpha == T::ZERO {
                    sum
                } else {
                    alpha * *number + sum
                };
            }
        }
    }
}

/// Functions with the signatures of nano-gemm.
pub mod planless {
    use super::{Complex, Strided, product};

    macro_rules! execute {
        ($($name:ident: $number:ty;)*) => {$(
            /// Computes `dst = alpha · dst + beta · lhs · rhs`.
            ///
            /// # Safety
            /// The same as for [`product`].
            pub unsafe fn $name(
                m: usize,
                n: usize,
                k: usize,
                dst: *mut $number,
                dst_rs: isize,
                dst_cs: isize,
                lhs: *const $number,
                lhs_rs: isize,
                lhs_cs: isize,
                rhs: *const $number,
                rhs_rs: isize,
                rhs_cs: isize,
                alpha: $number,
                beta: $number,
                conj_lhs: bool,
                conj_rhs: bool,
            ) {
                let into = Strided { start: dst, row: dst_rs, column: dst_cs };
                let lhs = Strided { start: lhs, row: lhs_rs, column: lhs_cs };
                let rhs = Strided { start: rhs, row: rhs_rs, column: rhs_cs };
                // SAFETY: the caller guarantees the same as for `product`.
                unsafe { product([m, n, k], into, [alpha, beta], (lhs, conj_lhs), (rhs, conj_rhs)) }
            }
        )*};
    }
    execute! {
        execute_f32: f32;
        execute_f64: f64;
        execute_c32: Complex<f32>;
        execute_c64: Complex<f64>;
    }
}
