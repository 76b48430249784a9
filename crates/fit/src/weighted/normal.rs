//! The normal equations `M a = AᵀWc`, factored by Cholesky together with the right-hand sides and
//! the identity. The row operations that turn `M = LLᵀ` into `Lᵀ` also give `y = L⁻¹AᵀWc` and
//! `L⁻¹`, so no triangular solve is needed afterwards.
//!
//! ```text
//! [ M | AᵀWc | I ]  →  [ Lᵀ | y | L⁻¹ ]
//! ```

use super::columns::{LANES, padded};
use lariat_portable::{Simd, WithSimd};

/// `[M | AᵀWc | I]`, row by row, and after the factorization `[Lᵀ | y | L⁻¹]`.
pub(crate) struct Normal<const D: usize> {
    count: usize,
    /// Numbers from row to row.
    stride: usize,
    rows: Vec<f64>,
}

impl<const D: usize> Normal<D> {
    pub(super) fn new(count: usize) -> Self {
        let stride = padded(2 * count + D);
        Self {
            count,
            stride,
            rows: vec![0.0; count * stride],
        }
    }

    pub(super) fn stride(&self) -> usize {
        self.stride
    }

    /// Clears all except the identity, and returns the rows, to be filled from the diagonal of `M`.
    pub(super) fn start(&mut self) -> &mut [f64] {
        self.rows.fill(0.0);
        for j in 0..self.count {
            self.rows[j * self.stride + self.count + D + j] = 1.0;
        }
        &mut self.rows
    }

    /// Adds `other`, `count` × `count`, to `M`.
    pub(super) fn add(&mut self, other: &[f64]) {
        for (row, other) in self
            .rows
            .chunks_exact_mut(self.stride)
            .zip(other.chunks_exact(self.count))
        {
            for (number, other) in row.iter_mut().zip(other) {
                *number += other;
            }
        }
    }

    /// Factorizes. Returns false if `M` is not numerically positive definite.
    pub(super) fn factor(&mut self, arch: lariat_portable::Arch) -> bool {
        arch.dispatch(Factor {
            rows: &mut self.rows,
            stride: self.stride,
        })
    }

    /// Copies `y`.
    pub(super) fn copy_y(&self, y: &mut [[f64; D]]) {
        for (y, row) in y.iter_mut().zip(self.rows.chunks_exact(self.stride)) {
            y.copy_from_slice(&row[self.count..self.count + D]);
        }
    }

    /// Row `j` of `L⁻¹`: zero beyond the diagonal.
    pub(super) fn inverse_row(&self, j: usize) -> &[f64] {
        &self.rows[j * self.stride + self.count + D..][..self.count]
    }

    /// The rows of `L⁻¹`, each [`Normal::stride`] from the one before; the last is cut at its end.
    pub(super) fn inverse(&self) -> &[f64] {
        &self.rows[self.count + D..]
    }

    /// Replaces `right` by `y = L⁻¹ right`.
    pub(crate) fn solve_lower(&self, right: &mut [[f64; D]]) {
        // Starts with the last row, because each row needs those before it.
        for j in (0..self.count).rev() {
            let mut y = [0.0; D];
            for (inverse, right) in self.inverse_row(j)[..=j].iter().zip(&*right) {
                for axis in 0..D {
                    y[axis] += inverse * right[axis];
                }
            }
            right[j] = y;
        }
    }

    /// `a = L⁻ᵀ y`.
    pub(super) fn coefficients(&self, y: &[[f64; D]], a: &mut [[f64; D]]) {
        a.fill([0.0; D]);
        for (j, y) in y.iter().enumerate() {
            for (a, &inverse) in a[..=j].iter_mut().zip(self.inverse_row(j)) {
                for axis in 0..D {
                    a[axis] += inverse * y[axis];
                }
            }
        }
    }
}

/// Right-looking Cholesky, a row at a time.
struct Factor<'a> {
    rows: &'a mut [f64],
    stride: usize,
}

impl WithSimd for Factor<'_> {
    type Output = bool;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> bool {
        let count = self.rows.len() / self.stride;
        // The diagonal may fall to the level of its own rounding error (Higham, Accuracy and
        // Stability of Numerical Algorithms, theorem 10.7: it is proportional to the number of
        // rows).
        let tolerance = 4.0 * count as f64 * f64::EPSILON;
        for k in 0..count {
            let (done, rest) = self.rows.split_at_mut((k + 1) * self.stride);
            // Amount that the rows above have subtracted from the diagonal: the squares of their
            // column.
            let taken: f64 = (0..k).map(|j| done[j * self.stride + k].powi(2)).sum();
            let row = &mut done[k * self.stride..];
            let pivot = row[k];
            #[allow(clippy::neg_cmp_op_on_partial_ord, reason = "NaN must fail")]
            if !(pivot > tolerance * (pivot + taken)) {
                return false;
            }
            let scale = simd.splat_f64s(1.0 / pivot.sqrt());
            let from = k - k % LANES;
            for number in S::as_mut_simd_f64s(&mut row[from..]).0 {
                *number = simd.mul_f64s(scale, *number);
            }
            for (i, below) in rest.chunks_exact_mut(self.stride).enumerate() {
                let factor = simd.splat_f64s(-row[k + 1 + i]);
                let from = (k + 1 + i) - (k + 1 + i) % LANES;
                let row = S::as_simd_f64s(&row[from..]).0;
                for (number, &above) in S::as_mut_simd_f64s(&mut below[from..])
                    .0
                    .iter_mut()
                    .zip(row)
                {
                    *number = simd.mul_add_f64s(factor, above, *number);
                }
            }
        }
        true
    }
}
