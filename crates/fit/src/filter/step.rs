//! What goes into a filter's step beside the shape, and what it says of it.

use std::fmt;

/// How uncertain measured control points are; the same for each axis.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Noise<'a> {
    /// `σ²(BᵀB)⁻¹` with the `B` of the [`CurveSpace`](crate::CurveSpace): the fit of points that all weigh the same.
    Even {
        /// `σ²`, the variance of one coordinate of one point: a fit's residual variance, px².
        variance_px2: f64,
    },
    /// The covariance of the control points, `m` × `m`, row by row, `σ²` included, px²: of a fit whose
    /// points weigh differently, or not at all. A direction of which nothing was seen may have a variance as
    /// large as it likes.
    Covariance(&'a [f64]),
}

/// What a filter did with a shape.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum FilterStep {
    /// It is the first: the rope is where it says, at rest as far as is known.
    Began,
    /// It was taken in.
    Updated {
        /// The normalized innovation squared: how far the shape was from its prediction, by what both are
        /// uncertain. With a right model it has a chi-square distribution of `m D` degrees of freedom, so
        /// that its mean over many shapes is `m D` (see [`FilterOptions::noise_scale`](crate::FilterOptions::noise_scale)).
        nis: f64,
    },
    /// It has other curves than those before it, so the filter began again with it.
    OtherCurves,
    /// It came too long after the one before it, so the filter began again with it.
    LongGap {
        /// How long after, s.
        seconds: f64,
    },
    /// It was too far from its prediction to be the same rope in motion, so the filter began again with it.
    Jumped {
        /// The normalized innovation squared; infinite if the prediction's covariance was lost in rounding.
        nis: f64,
    },
}

impl FilterStep {
    /// Whether the filter knows nothing from before this shape.
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
