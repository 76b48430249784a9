//! How uncertain control points and curve are.
//!
//! The message has a covariance `Dⱼ` for each control point. How two of them err together follows from the regression:
//! with `G = (BᵀB)⁻¹` their errors are correlated by `cⱼₖ = Gⱼₖ/√(Gⱼⱼ Gₖₖ)`, and
//!
//! ```text
//! Cov(sⱼ, sₖ) = Dⱼ^½ cⱼₖ Dₖ^½
//! ```
//!
//! Of plain least squares this is `σ²(BᵀB)⁻¹ ⊗ I₂`, and of its filter `k (BᵀB)⁻¹ ⊗ I₂`, to rounding. With ridge, pinned
//! ends, weights or a plane `Dⱼ` is right and `cⱼₖ` that of the plain fit, an approximation.

use super::{Inverse, Shape};

/// How far from plain the ratios of the control points' variances may be and still be its rounding.
const ROUNDING: f64 = 1e-6;

/// The covariance of all control points of a curve, in the unit's square.
#[derive(Debug, Clone, Copy)]
pub struct Covariance<'a> {
    shape: Shape<'a>,
}

impl<'a> Covariance<'a> {
    pub(super) fn of(shape: Shape<'a>) -> Self {
        Self { shape }
    }

    /// Each control point's own, `[xx, xy, yy]`.
    fn each(&self) -> &'a [[f64; 3]] {
        self.shape.covariances.as_chunks().0
    }

    /// Whether it is that of plain least squares, or of its filter: right to rounding. If not (ridge, pinned ends, weights,
    /// a plane), each control point's own covariance is right, and how two of them hang together is that of the plain fit.
    /// Rational curves, whose weights err too, are never exact.
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

    /// How control points `j` and `k` err together: `[[xx, xy], [yx, yy]]`. For `j = k` control point `j`'s own.
    ///
    /// # Panics
    /// If there is no such control point.
    pub fn block(&self, j: usize, k: usize) -> [[f64; 2]; 2] {
        let [a, b] = [j, k].map(|i| root(self.each()[i]));
        let correlation = Inverse::with(&self.shape, |inverse| {
            let dot: f64 = inverse.row(j).iter().zip(inverse.row(k)).map(product).sum();
            dot / (inverse.variance(j) * inverse.variance(k)).sqrt()
        });
        let product = times(a, b);
        product.map(|row| row.map(|entry| correlation * entry))
    }

    /// How many rows and columns it has: two for each control point.
    pub fn size(&self) -> usize {
        2 * self.shape.control_points.len()
    }

    /// Writes the whole matrix, row by row, of the vector `x₀, y₀, x₁, y₁, …`: [`size`](Self::size) squared numbers.
    /// Only as many are written as there are places.
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

    /// The covariance of the curve's point at `rho`: `[xx, xy, yy]`.
    pub fn of_point(&self, rho: f64) -> [f64; 3] {
        let [values] = self.shape.rows(rho);
        Inverse::with(&self.shape, |inverse| {
            // Σⱼₖ bⱼbₖ Dⱼ^½ cⱼₖ Dₖ^½ = Σ_c Y_c Y_cᵀ with Y_c = Σⱼ bⱼ Dⱼ^½ R⁻¹ⱼ_c/√Gⱼⱼ: a sum of squares, never negative.
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
