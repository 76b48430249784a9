//! The space of curves that control points belong to, in coordinates measured in pixels of the
//! curve.

use super::error::CurveSpaceError;
use super::rows::{Rows, vectors};
use crate::factor::Qr;
use crate::options::{MAX_ORDER, MAX_POINTS};
use faer::{Mat, MatRef};
use std::sync::Arc;

/// Maximum condition number of `B`. At this number, conversion to curve coordinates and back has a
/// relative error of a millionth, as a fit by `pinv` does.
const MAX_CONDITION: f64 = 1e-6 / f64::EPSILON;

/// A space of curves: a basis on a grid of `ρ`, given by the matrix `B` (`N` × `m`) that maps `m`
/// control points to `N` points of the curve. It is created once for each fitter; clones share the
/// computed data.
///
/// It defines *curve coordinates* `z = √(m/N) R s`, where `B = QR`, for control points `s`. Lengths
/// in these coordinates are lengths on the rope: `|z|²/m` is the mean of the squared distances of
/// the curve's `N` points from the origin, and the covariance `σ²(BᵀB)⁻¹` of a fit is `σ² m/N` in
/// every direction. Control points can be far outside their curve, and move by a hundred pixels if
/// the curve moves by one (the ratio of their variances is the square of `B`'s condition number).
/// Curve coordinates do not have this problem.
#[derive(Debug, Clone)]
pub struct CurveSpace(Arc<Coordinates>);

#[derive(Debug)]
struct Coordinates {
    control_points: usize,
    points: usize,
    condition: f64,
    /// Sum of the squares of `G⁻¹`'s entries.
    size: f64,
    /// Transpose of `G` in `s = G z`: row `k` is the contribution of coordinate `k` to each control
    /// point.
    to_control_points: Rows,
    /// Transpose of `G⁻¹` in `z = G⁻¹ s`.
    to_curve: Rows,
}

impl CurveSpace {
    /// Creates the space of the curves `B s`. `b` is `B`: `N` rows, one for each point, and a
    /// column for each control point.
    ///
    /// # Errors
    /// Fails for 0 or more than 32 control points, if there are fewer points than control points,
    /// if a number is not finite, or if the condition number of `B` is too high.
    pub fn new(b: MatRef<'_, f64>) -> Result<Self, CurveSpaceError> {
        let (rows, columns) = b.shape();
        if !(1..=MAX_ORDER + 1).contains(&columns) {
            return Err(CurveSpaceError::ControlPoints { columns });
        }
        if !(columns..=MAX_POINTS).contains(&rows) {
            return Err(CurveSpaceError::Shape { rows, columns });
        }
        for row in 0..rows {
            for column in 0..columns {
                if !b[(row, column)].is_finite() {
                    return Err(CurveSpaceError::NotFinite { row, column });
                }
            }
        }
        let factors = Qr::new(b);
        let condition = factors.condition();
        if condition > MAX_CONDITION {
            return Err(CurveSpaceError::IllConditioned {
                condition,
                limit: MAX_CONDITION,
            });
        }
        let (r, inverse) = (factors.r(), factors.inverse_of_r());
        let scale = (columns as f64 / rows as f64).sqrt();
        let mut to_curve = Rows::square(columns);
        let mut to_control_points = Rows::square(columns);
        for j in 0..columns {
            for i in 0..=j {
                to_curve.set(j, i, scale * r[(i, j)]);
                to_control_points.set(j, i, inverse[(i, j)] / scale);
            }
        }
        // Both were filled as transposes of G⁻¹ and G: row j belongs to column j.
        Ok(Self(Arc::new(Coordinates {
            control_points: columns,
            points: rows,
            condition,
            size: to_curve.vectors.as_flattened().iter().map(|h| h * h).sum(),
            to_control_points,
            to_curve,
        })))
    }

    /// Creates the space whose `control_points` control points are points on the rope themselves:
    /// `B` is the identity.
    ///
    /// # Errors
    /// Fails for 0 or more than 32 control points.
    pub fn of_points(control_points: usize) -> Result<Self, CurveSpaceError> {
        if control_points > MAX_ORDER + 1 {
            return Err(CurveSpaceError::ControlPoints {
                columns: control_points,
            });
        }
        Self::new(Mat::identity(control_points, control_points).as_ref())
    }

    /// Number of control points of a curve.
    pub fn control_points(&self) -> usize {
        self.0.control_points
    }

    /// 2-norm condition number of `B`.
    pub fn condition(&self) -> f64 {
        self.0.condition
    }

    /// Variance of each curve coordinate of a fit whose points have variance 1.
    pub(super) fn unit_variance(&self) -> f64 {
        self.0.control_points as f64 / self.0.points as f64
    }

    /// Maximum error of a variance in curve coordinates if control points' variances that sum to
    /// `trace` are rounded: `ε` of each entry, multiplied by `G⁻¹` from both sides, and the same
    /// again for the sums.
    pub(super) fn rounding(&self, trace: f64) -> f64 {
        2.0 * f64::EPSILON * self.0.size * trace
    }

    /// `Gᵀ`.
    pub(super) fn to_control_points(&self) -> &Rows {
        &self.0.to_control_points
    }

    /// `G⁻ᵀ`.
    pub(super) fn to_curve(&self) -> &Rows {
        &self.0.to_curve
    }

    /// Returns whether `other` is the same object or a clone of it.
    pub(super) fn is(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

/// `out ← Tᵀ points`.
#[inline(always)]
pub(super) fn transform<const D: usize>(t: &Rows, points: &[[f64; D]], out: &mut [[f64; D]]) {
    debug_assert_eq!(t.width, vectors(points.len()));
    out.fill([0.0; D]);
    for (k, point) in points.iter().enumerate() {
        for (sum, f) in out.iter_mut().zip(t.numbers(k, points.len())) {
            for axis in 0..D {
                sum[axis] += f * point[axis];
            }
        }
    }
}
