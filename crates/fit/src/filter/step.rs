//! Input of a filter's step in addition to the shape, and the result of the step.

use std::fmt;

/// Uncertainty of measured control points; the same for each axis.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Noise<'a> {
    /// `σ²(BᵀB)⁻¹` with the `B` of the [`CurveSpace`](crate::CurveSpace): the fit of points with
    /// equal weights.
    Even {
        /// `σ²`, the variance of one coordinate of one point: a fit's residual variance, px².
        variance_px2: f64,
    },
    /// Covariance of the control points, `m` × `m`, row by row, `σ²` included, px²: for a fit whose
    /// points have different weights, possibly 0. A direction that was not observed may have an
    /// arbitrarily large variance.
    Covariance(&'a [f64]),
}

/// Result of a filter's update.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum FilterStep {
    /// This is the first shape. The rope is assumed to be at rest at its position.
    Began,
    /// The shape was used.
    Updated {
        /// The normalized innovation squared: the distance of the shape from its prediction,
        /// relative to the uncertainty of both. If the model is right, it has a chi-square
        /// distribution of `m D` degrees of freedom, so its mean over many shapes is `m D` (see
        /// [`FilterOptions::noise_scale`](crate::FilterOptions::noise_scale)).
        nis: f64,
    },
    /// The shape's curves belong to another space than the previous ones, so the filter restarted
    /// with this shape.
    OtherCurves,
    /// The shape came too long after the previous one, so the filter restarted with it.
    LongGap {
        /// The time since the previous shape, s.
        seconds: f64,
    },
    /// The shape was too far from its prediction to be the same rope in motion, so the filter
    /// restarted with it.
    Jumped {
        /// The normalized innovation squared; infinite if the prediction's covariance was lost in
        /// rounding.
        nis: f64,
    },
}

impl FilterStep {
    /// Returns whether the filter has no information from before this shape.
    pub fn is_beginning(&self) -> bool {
        !matches!(self, FilterStep::Updated { .. })
    }
}

impl fmt::Display for FilterStep {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            FilterStep::Began => f.write_str("the filter began with this shape"),
            FilterStep::Updated { nis } => {
                write!(
                    f,
                    "the shape was taken in, its normalized innovation squared {nis:.1}"
                )
            }
            FilterStep::OtherCurves => f.write_str(
                "the filter began again: the shape has other curves than those before it",
            ),
            FilterStep::LongGap { seconds } => {
                write!(
                    f,
                    "the filter began again: the last shape was {seconds:.3} s ago"
                )
            }
            FilterStep::Jumped { nis } => write!(
                f,
                "the filter began again: the rope jumped, its normalized innovation squared {nis:.1}"
            ),
        }
    }
}
