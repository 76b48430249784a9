//! Checks which curve a descriptor describes. A message is only bytes, and an inconsistent one must
//! not be evaluated.

use thiserror::Error;

use crate::{Basis, MAX_CONTROL_POINTS, MAX_POINTS, Place};

/// Basis functions that the control points weigh.
#[derive(Debug, Clone, Copy)]
pub(super) enum Form<'a> {
    /// Bernstein polynomials; the number of control points gives the degree.
    Bezier,
    /// Clamped B-splines.
    BSpline {
        /// Degree of the pieces.
        degree: usize,
        /// Inner knots.
        inner: &'a [f64],
    },
    /// Rational Bernstein functions.
    Rational {
        /// One weight for each control point.
        weights: &'a [f64],
    },
    /// A truncated Fourier series.
    Fourier,
}

/// Fields of a descriptor that define its basis functions.
#[derive(Debug, Clone, Copy)]
pub(super) struct Functions<'a> {
    pub(super) basis: Option<Basis>,
    pub(super) degree: usize,
    pub(super) weights: &'a [f64; MAX_CONTROL_POINTS],
    pub(super) knots: &'a [f64; MAX_CONTROL_POINTS],
}

/// Reason why a descriptor lacks a curve.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum NoShape {
    /// The descriptor has points of the rope instead.
    #[error(
        "the chain describes ropes by points (--basis points), which are no curve: take control_points(), or start the \
         chain with --basis bezier or bspline"
    )]
    FeaturePoints,
    /// The descriptor has the rope's center instead.
    #[error(
        "the chain describes ropes by their center (--basis mass), which is no curve: take control_points(), or start the \
         chain with --basis bezier or bspline"
    )]
    CenterOfMass,
    /// The descriptor's numbers are inconsistent. A chain of this release never sends such a
    /// descriptor.
    #[error(
        "the descriptor's numbers make no curve: use the same release of lariat for every process on the rig"
    )]
    Unreadable,
    /// The rope's position in space is unknown.
    #[error("it is not known where in space the rope is: {}", .0.name())]
    Nowhere(Place),
}

impl<'a> Form<'a> {
    /// Checks the numbers already read from the descriptor, then reads and checks everything else
    /// that the curve needs.
    pub(super) fn of<const D: usize>(
        functions: Functions<'a>,
        control_points: &[[f64; D]; MAX_CONTROL_POINTS],
        count: usize,
        samples: usize,
    ) -> Result<Self, NoShape> {
        let Functions {
            degree,
            weights,
            knots,
            ..
        } = functions;
        let (Some(basis), true) = (functions.basis, (1..=MAX_CONTROL_POINTS).contains(&count))
        else {
            return Err(NoShape::Unreadable);
        };
        let coordinates = control_points[..count].iter().flatten();
        // Each evaluation of a covariance iterates over all fitted points.
        let is_fitted = (count..=MAX_POINTS).contains(&samples);
        if !coordinates.clone().all(|c| c.is_finite()) || !is_fitted {
            return Err(NoShape::Unreadable);
        }
        let form = match basis {
            Basis::Bezier if count == degree + 1 => Self::Bezier,
            Basis::BSpline if (1..count).contains(&degree) => Self::BSpline {
                degree,
                inner: &knots[..count - degree - 1],
            },
            Basis::RationalBezier if count == degree + 1 => Self::Rational {
                weights: &weights[..count],
            },
            Basis::Fourier if count == 2 * degree + 1 => Self::Fourier,
            Basis::FeaturePoints => return Err(NoShape::FeaturePoints),
            Basis::CenterOfMass if count == 1 => return Err(NoShape::CenterOfMass),
            _ => return Err(NoShape::Unreadable),
        };
        form.is_sound().then_some(form).ok_or(NoShape::Unreadable)
    }

    /// Returns whether knots ascend and weights are positive.
    fn is_sound(&self) -> bool {
        match *self {
            Self::Bezier | Self::Fourier => true,
            Self::BSpline { degree, inner } => {
                let inside = |knot: f64| 0.0 < knot && knot < 1.0;
                // A knot that occurs more often than the degree would make the curve discontinuous.
                let torn = |i: usize| i >= degree && inner[i] <= inner[i - degree];
                inner.iter().all(|&knot| inside(knot))
                    && inner.is_sorted()
                    && !(0..inner.len()).any(torn)
            }
            Self::Rational { weights } => weights.iter().all(|w| w.is_finite() && *w > 0.0),
        }
    }
}
