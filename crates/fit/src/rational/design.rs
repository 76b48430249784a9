//! Everything that does not depend on the points: the Bernstein polynomials on the grid, and an
//! orthonormal basis of the curves that free control points can represent.
//!
//! `B = Q T` is the QR of the polynomials on the grid. In the basis `Q`, the condition of a
//! weighted curve's normal equations depends only on how even the curve's denominator is, at any
//! order. `T⁻¹` is only needed for the final control points.

use super::kernels::padded;
use crate::bezier::bernstein;
use crate::factor::Qr;
use crate::matrix::row_by_row;
use faer::MatRef;

/// The constant matrices. Each polynomial is a row over the grid, padded with zeros.
pub(super) struct Design {
    /// Number of control points, `n + 1`.
    pub(super) count: usize,
    /// Number of points of a centerline.
    pub(super) points: usize,
    /// Length of a row: `points`, padded.
    pub(super) stride: usize,
    /// True if the end control points are the end points.
    pub(super) pinned: bool,
    /// The Bernstein polynomials, `count` rows.
    pub(super) b: Vec<f64>,
    /// Orthonormal basis of the polynomials whose control points are free, `free()` rows.
    pub(super) q: Vec<f64>,
    /// `T`, upper triangular, `free()` × `free()`, row-major:
    /// `b[first_free() + j] = Σₗ t[l][j] q[l]`.
    t: Vec<f64>,
}

impl Design {
    pub(super) fn new(order: usize, points: usize, pinned: bool) -> Self {
        let (count, stride) = (order + 1, padded(points));
        let mut b = vec![0.0; count * stride];
        let mut values = vec![0.0; count];
        for i in 0..points {
            bernstein(order, i as f64 / (points - 1) as f64, &mut values);
            for (row, value) in b.chunks_exact_mut(stride).zip(&values) {
                row[i] = *value;
            }
        }
        let ends = usize::from(pinned);
        let (q, t) = orthonormalized(&b[ends * stride..(count - ends) * stride], stride, points);
        Self {
            count,
            points,
            stride,
            pinned,
            b,
            q,
            t,
        }
    }

    /// Index of the first free control point.
    pub(super) fn first_free(&self) -> usize {
        usize::from(self.pinned)
    }

    /// Number of free control points.
    pub(super) fn free(&self) -> usize {
        self.count - 2 * usize::from(self.pinned)
    }

    /// Replaces `right`, coefficients of `q`, by `T⁻¹ right`, coefficients of `b`. It has `free()`
    /// rows of `width` numbers.
    pub(super) fn to_bernstein(&self, right: &mut [f64], width: usize) {
        let free = self.free();
        for k in (0..free).rev() {
            let (row, later) = right[k * width..].split_at_mut(width);
            for (j, other) in later.chunks_exact(width).enumerate() {
                super::kernels::add_multiple(row, -self.t[k * free + k + 1 + j], other);
            }
            let pivot = self.t[k * free + k];
            row.iter_mut().for_each(|number| *number /= pivot);
        }
    }
}

/// Computes `Q` and `T` of these rows.
fn orthonormalized(b: &[f64], stride: usize, points: usize) -> (Vec<f64>, Vec<f64>) {
    let count = b.len() / stride;
    let mut q = vec![0.0; b.len()];
    if count == 0 {
        return (q, Vec::new());
    }
    let factors = Qr::new(
        MatRef::from_row_major_slice(b, count, stride)
            .subcols(0, points)
            .transpose(),
    );
    for (k, row) in q.chunks_exact_mut(stride).enumerate() {
        for (i, number) in row[..points].iter_mut().enumerate() {
            *number = factors.q()[(i, k)];
        }
    }
    (q, row_by_row(factors.r()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_basis_is_orthonormal_and_makes_the_polynomials_at_any_order() {
        for (order, points, pinned) in [
            (1, 2, false),
            (1, 2, true),
            (8, 120, true),
            (31, 256, false),
        ] {
            let design = Design::new(order, points, pinned);
            let (free, stride) = (design.free(), design.stride);
            assert_eq!(design.q.len(), free * stride);
            for k in 0..free {
                let row = |l: usize| &design.q[l * stride..(l + 1) * stride];
                for l in 0..=k {
                    let product: f64 = row(k).iter().zip(row(l)).map(|(a, b)| a * b).sum();
                    assert!((product - f64::from(u8::from(k == l))).abs() < 1e-13);
                }
                let b = &design.b[(k + design.first_free()) * stride..][..stride];
                for (i, b) in b.iter().enumerate() {
                    let sum: f64 = (0..=k).map(|l| design.t[l * free + k] * row(l)[i]).sum();
                    assert!((sum - b).abs() < 1e-14);
                }
            }
        }
    }
}
