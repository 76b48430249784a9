//! Distance of two shapes.
//!
//! The control points of a curve are not on it. Noise that moves the curve by 1 px moves a control
//! point of a Bezier curve of order 8 by 25 px. The visible distance is that of the curves. With
//! the rows `B` of points of the curve, it is
//!
//! ```text
//! ‖B e‖²/N = eᵀ (M ⊗ I₂) e,      M = BᵀB/N
//! ```

use std::ops::Deref;

use crate::{MAX_POINTS, MetricError};

/// A square matrix with one row and column per point.
type Gram = [[f64; MAX_POINTS]; MAX_POINTS];

/// Distance of two shapes: the root of `eᵀ (M ⊗ I₂) e`, px, for a difference `e` of their points.
///
/// The default compares points: the root mean square of their distances. For control points, use
/// the curve's metric.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Metric(Option<Box<Curve>>);

#[derive(Debug, Clone, PartialEq)]
struct Curve {
    count: usize,
    gram: Gram,
    gains: [f64; MAX_POINTS],
}

impl Metric {
    /// Creates the metric of a curve from rows of `B` at equal steps of ρ. A row contains the share
    /// of each control point in one point of the curve. A reader provides it as
    /// `Shape::jacobian_at(ρ)`. Four times as many rows as control points are plenty.
    ///
    /// # Errors
    /// Fails if rows differ in length, or if there are fewer distinct rows than control points.
    pub fn of_rows<Row: Deref<Target = [f64]>>(
        rows: impl IntoIterator<Item = Row>,
    ) -> Result<Self, MetricError> {
        let mut gram = [[0.0; MAX_POINTS]; MAX_POINTS];
        let (mut count, mut samples) = (0, 0.0);
        for (index, row) in rows.into_iter().enumerate() {
            if index == 0 {
                count = checked(row.len())?;
            }
            if row.len() != count {
                return Err(MetricError::Row {
                    row: index,
                    given: row.len(),
                    expected: count,
                });
            }
            for (j, a) in row.iter().enumerate() {
                for (k, b) in row.iter().enumerate() {
                    gram[j][k] += a * b;
                }
            }
            samples += 1.0;
        }
        checked(count)?;
        gram.as_flattened_mut()
            .iter_mut()
            .for_each(|g| *g /= samples);
        Self::of_gram(gram, count)
    }

    /// Creates the metric of a Bezier curve of this order, the mean over ρ from 0 to 1 in closed
    /// form: `Mⱼₖ = ∫ BⱼBₖ dρ`, which is `C(n, j) C(n, k) / C(2n, j + k) / (2n + 1)`.
    ///
    /// # Errors
    /// Fails for an order of 0, and for orders so high that rounding destroys the distance (from
    /// about 24: the condition number is `C(2n + 1, n)`).
    pub fn bezier(order: usize) -> Result<Self, MetricError> {
        let count = checked(order.saturating_add(1))?;
        let mut gram = [[0.0; MAX_POINTS]; MAX_POINTS];
        for (j, row) in gram[..count].iter_mut().enumerate() {
            for (k, entry) in row[..count].iter_mut().enumerate() {
                *entry = binomial(order, j) * binomial(order, k)
                    / binomial(2 * order, j + k)
                    / (2 * order + 1) as f64;
            }
        }
        Self::of_gram(gram, count)
    }

    fn of_gram(gram: Gram, count: usize) -> Result<Self, MetricError> {
        let gains = diagonal_of_inverse(&gram, count).ok_or(MetricError::Singular)?;
        Ok(Self(Some(Box::new(Curve { count, gram, gains }))))
    }

    /// Number of points that the metric is for; `None` if it is for any number.
    pub(crate) fn points(&self) -> Option<usize> {
        self.0.as_ref().map(|curve| curve.count)
    }

    /// Returns `M` and the diagonal of its inverse, for a shape of this many points. The diagonal
    /// is the relative variance of each point under noise that is even along the curve.
    pub(crate) fn matrix(&self, count: usize) -> (Gram, [f64; MAX_POINTS]) {
        if let Some(curve) = &self.0 {
            return (curve.gram, curve.gains);
        }
        let mut gram = [[0.0; MAX_POINTS]; MAX_POINTS];
        for (j, row) in gram[..count].iter_mut().enumerate() {
            row[j] = 1.0 / count as f64;
        }
        (gram, [count as f64; MAX_POINTS])
    }
}

fn checked(count: usize) -> Result<usize, MetricError> {
    if (1..=MAX_POINTS).contains(&count) {
        Ok(count)
    } else {
        Err(MetricError::Count { count })
    }
}

fn binomial(n: usize, k: usize) -> f64 {
    (0..k).fold(1.0, |product, i| product * (n - i) as f64 / (i + 1) as f64)
}

/// Diagonal of `M⁻¹` by the Cholesky factor `M = LLᵀ`: the sums of squares of the columns of `L⁻¹`.
/// `None` if a pivot is lost to rounding.
fn diagonal_of_inverse(gram: &Gram, count: usize) -> Option<[f64; MAX_POINTS]> {
    let mut l = [[0.0; MAX_POINTS]; MAX_POINTS];
    for j in 0..count {
        for k in 0..=j {
            let sum: f64 = (0..k).map(|i| l[j][i] * l[k][i]).sum();
            let rest = gram[j][k] - sum;
            if j > k {
                l[j][k] = rest / l[k][k];
            } else if rest > 16.0 * f64::EPSILON * gram[j][j] {
                l[j][j] = rest.sqrt();
            } else {
                return None;
            }
        }
    }
    let mut diagonal = [0.0; MAX_POINTS];
    for (column, diagonal) in diagonal[..count].iter_mut().enumerate() {
        let mut inverse = [0.0; MAX_POINTS];
        for row in column..count {
            let sum: f64 = (column..row).map(|i| l[row][i] * inverse[i]).sum();
            let unit = if row == column { 1.0 } else { 0.0 };
            inverse[row] = (unit - sum) / l[row][row];
        }
        // (M⁻¹)ⱼⱼ = Σ (L⁻¹)ᵢⱼ² over i: column j of L⁻¹.
        *diagonal = inverse.iter().map(|entry| entry * entry).sum();
    }
    Some(diagonal)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bernstein(order: usize, rho: f64) -> Vec<f64> {
        (0..=order)
            .map(|j| binomial(order, j) * rho.powi(j as i32) * (1.0 - rho).powi((order - j) as i32))
            .collect()
    }

    #[test]
    fn the_closed_form_is_the_mean_over_many_points() {
        for order in [1, 3, 8] {
            let exact = Metric::bezier(order).expect("a metric").matrix(order + 1).0;
            // The midpoint rule, whose error is proportional to the square of the step.
            let rows = (0..1000).map(|i| bernstein(order, (i as f64 + 0.5) / 1000.0));
            let mean = Metric::of_rows(rows).expect("a metric").matrix(order + 1).0;
            for (a, b) in exact.as_flattened().iter().zip(mean.as_flattened()) {
                assert!((a - b).abs() < 1e-5, "{order}: {a} {b}");
            }
        }
    }

    #[test]
    fn a_control_point_in_the_middle_is_less_certain_than_the_curve() {
        let (_, gains) = Metric::bezier(8).expect("a metric").matrix(9);
        // For 120 points with noise 1, the root of the largest gain divided by 120 is the fit's
        // noise gain of 25 (crates/fit).
        let largest = gains.iter().copied().fold(0.0, f64::max);
        assert!(((largest / 120.0).sqrt() - 25.0).abs() < 2.0, "{largest}");
    }

    #[test]
    fn rows_that_leave_a_control_point_unseen_are_refused() {
        let ends = [0.0, 1.0].map(|rho| bernstein(3, rho));
        assert_eq!(Metric::of_rows(ends), Err(MetricError::Singular));
        let rows = [vec![1.0, 0.0], vec![1.0]];
        assert!(matches!(
            Metric::of_rows(rows),
            Err(MetricError::Row { row: 1, .. })
        ));
        assert_eq!(
            Metric::of_rows(Vec::<Vec<f64>>::new()),
            Err(MetricError::Count { count: 0 })
        );
        assert!(Metric::bezier(usize::MAX).is_err());
    }
}
