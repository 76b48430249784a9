//! Uncertainty of the control points and of the curve.
//!
//! The message has a covariance `Dⱼ` for each control point. The correlation of two of them follows
//! from the regression: with `G = (BᵀB)⁻¹`, it is `cⱼₖ = Gⱼₖ/√(Gⱼⱼ Gₖₖ)`, and
//!
//! ```text
//! Cov(sⱼ, sₖ) = Dⱼ^½ cⱼₖ Dₖ^½
//! ```
//!
//! For plain least squares this equals `σ²(BᵀB)⁻¹ ⊗ I₂` to rounding, and for the filter of such
//! fits `k (BᵀB)⁻¹ ⊗ I₂`. With ridge, pinned ends, weights or a plane, `Dⱼ` is exact and `cⱼₖ` is
//! that of the plain fit, an approximation.

use super::{Inverse, Shape};

/// Maximum relative deviation of the variance ratios from those of a plain fit. Up to this, it
/// counts as rounding.
const ROUNDING: f64 = 1e-6;

/// Joint covariance of all control points of a curve, in the unit squared.
#[derive(Debug, Clone, Copy)]
pub struct Covariance<'a> {
    shape: Shape<'a>,
}

impl<'a> Covariance<'a> {
    pub(super) fn of(shape: Shape<'a>) -> Self {
        Self { shape }
    }

    /// Covariance of each control point alone, `[xx, xy, yy]`.
    fn each(&self) -> &'a [[f64; 3]] {
        self.shape.covariances.as_chunks().0
    }

    /// Returns whether the matrix is exact up to rounding, as for plain least squares and for the
    /// filter of such fits.
    ///
    /// Otherwise (ridge, pinned ends, weights, a plane) each control point's own covariance is
    /// exact, and the correlations are those of the plain fit. Rational curves are never exact,
    /// because their weights have errors too.
    pub fn is_exact(&self) -> bool {
        if matches!(self.shape.form, super::Form::Rational { .. }) {
            return false;
        }
        Inverse::with(&self.shape, |inverse| {
            let mut ratios = self.each().iter().enumerate().map(|(j, d)| {
                let even = d[1].abs() <= ROUNDING * d[0] && (d[0] - d[2]).abs() <= ROUNDING * d[0];
                even.then(|| d[0] / inverse.variance(j))
            });
            let Some(Some(first)) = ratios.next() else {
                return false;
            };
            ratios.all(|ratio| ratio.is_some_and(|r| (r - first).abs() <= ROUNDING * first.abs()))
        })
    }

    /// Covariance of control points `j` and `k`: `[[xx, xy], [yx, yy]]`. For `j = k` it is that of
    /// one point.
    ///
    /// # Panics
    /// If the control point does not exist.
    pub fn block(&self, j: usize, k: usize) -> [[f64; 2]; 2] {
        let [a, b] = [j, k].map(|i| root(self.each()[i]));
        let correlation = Inverse::with(&self.shape, |inverse| {
            let dot: f64 = inverse.row(j).iter().zip(inverse.row(k)).map(product).sum();
            dot / (inverse.variance(j) * inverse.variance(k)).sqrt()
        });
        let product = times(a, b);
        product.map(|row| row.map(|entry| correlation * entry))
    }

    /// Number of rows and of columns: two for each control point.
    pub fn size(&self) -> usize {
        2 * self.shape.control_points.len()
    }

    /// Writes the whole matrix for the vector `x₀, y₀, x₁, y₁, …`, row by row: [`size`](Self::size)
    /// squared numbers. Stops at the end of the slice.
    pub fn write_to(&self, matrix: &mut [f64]) {
        let size = self.size();
        for j in 0..size / 2 {
            for k in 0..size / 2 {
                let block = self.block(j, k);
                for (r, row) in block.iter().enumerate() {
                    for (c, entry) in row.iter().enumerate() {
                        if let Some(place) = matrix.get_mut((2 * j + r) * size + 2 * k + c) {
                            *place = *entry;
                        }
                    }
                }
            }
        }
    }

    /// Covariance of the curve's point at `rho`: `[xx, xy, yy]`.
    pub fn of_point(&self, rho: f64) -> [f64; 3] {
        let [values] = self.shape.rows(rho);
        Inverse::with(&self.shape, |inverse| {
            // Σⱼₖ bⱼbₖ Dⱼ^½ cⱼₖ Dₖ^½ = Σ_c Y_c Y_cᵀ with Y_c = Σⱼ bⱼ Dⱼ^½ R⁻¹ⱼ_c/√Gⱼⱼ: a sum of
            // squares, so never negative.
            let mut columns = [[[0.0; 2]; 2]; crate::MAX_CONTROL_POINTS];
            for (j, &covariance) in self.each().iter().enumerate() {
                let scale = values[j] / inverse.variance(j).sqrt();
                let weighed = root(covariance).map(|row| row.map(|entry| scale * entry));
                for (column, r) in columns.iter_mut().zip(inverse.row(j)) {
                    for (sum, entry) in column
                        .as_flattened_mut()
                        .iter_mut()
                        .zip(weighed.as_flattened())
                    {
                        *sum += r * entry;
                    }
                }
            }
            let mut sum = [0.0; 3];
            for [x, y] in &columns[..self.shape.control_points.len()] {
                sum[0] += x[0] * x[0] + x[1] * x[1];
                sum[1] += x[0] * y[0] + x[1] * y[1];
                sum[2] += y[0] * y[0] + y[1] * y[1];
            }
            sum
        })
    }
}

fn product((a, b): (&f64, &f64)) -> f64 {
    a * b
}

/// The symmetric root of a covariance `[xx, xy, yy]`: `(D + √det D · I)/√(tr D + 2 √det D)`.
fn root([xx, xy, yy]: [f64; 3]) -> [[f64; 2]; 2] {
    let det = (xx * yy - xy * xy).max(0.0).sqrt();
    let size = (xx + yy + 2.0 * det).sqrt();
    if size == 0.0 {
        return [[0.0; 2]; 2];
    }
    [
        [(xx + det) / size, xy / size],
        [xy / size, (yy + det) / size],
    ]
}

fn times(a: [[f64; 2]; 2], b: [[f64; 2]; 2]) -> [[f64; 2]; 2] {
    a.map(|row| [0, 1].map(|c| row[0] * b[0][c] + row[1] * b[1][c]))
}
