//! Errors of invalid curves, in sentences that say what to do instead.

use crate::basis::{Basis, MAX_CONTROL_POINTS};

/// Why a [`Curve`](crate::Curve) could not be created.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CurveError {
    /// No curve of this family has this size.
    #[error(
        "there is no {} of this size ({basis}): a curve has 1 to {MAX_CONTROL_POINTS} control points, a B-spline \
         a degree from 1 to one less than it has control points",
        basis.name()
    )]
    Size {
        /// The requested basis.
        basis: Basis,
    },
    /// The number of control points does not match the basis.
    #[error(
        "{given} control points were given for {basis}, which has {}: give as many, or name another basis",
        basis.control_points()
    )]
    ControlPoints {
        /// The requested basis.
        basis: Basis,
        /// Number of control points given.
        given: usize,
    },
    /// The number of weights does not match the basis.
    #[error(
        "{given} weights were given for {basis}, which has {expected}: give one for each control point of a \
         rational curve, and none for others"
    )]
    Weights {
        /// The requested basis.
        basis: Basis,
        /// Number of weights given.
        given: usize,
        /// Number of weights that the basis needs.
        expected: usize,
    },
    /// A weight is not positive, or not finite.
    #[error("weight {index} is {weight}: all weights must be positive and finite")]
    Weight {
        /// Index of the weight, counted from 0.
        index: usize,
        /// Its value.
        weight: f64,
    },
    /// A coordinate is NaN or infinite.
    #[error(
        "control point {index} is not finite: a curve needs numbers for all of its coordinates"
    )]
    NotFinite {
        /// Index of the control point, counted from 0.
        index: usize,
    },
    /// The knots are missing, and only the fit knows them.
    #[error("the knots lie where the points were: give the ones that the curve was fitted with")]
    KnotsWanted,
    /// Knots were given to a basis without knots.
    #[error("knots were given for {basis}, which takes none: leave them out")]
    NoKnots {
        /// The requested basis.
        basis: Basis,
    },
    /// The number of knots does not match the B-spline.
    #[error(
        "{given} knots were given, and this B-spline has {expected}: give as many, or none if they are even"
    )]
    KnotCount {
        /// Number of knots given.
        given: usize,
        /// Number of control points plus degree plus one.
        expected: usize,
    },
    /// Knots are not clamped at 0 and 1, descend, or repeat too often.
    #[error(
        "knot {index} is {knot}: the first {} knots must be 0, as many at the end 1, those between them must \
         lie inside and ascend, and none may come more than {degree} times",
        degree + 1
    )]
    Knot {
        /// Index of the knot, counted from 0.
        index: usize,
        /// Its value.
        knot: f64,
        /// Degree of the B-spline.
        degree: usize,
    },
}

/// Checks the size of a basis, and that these control points and weights match it.
pub(crate) fn check<const D: usize>(
    basis: Basis,
    control_points: &[[f64; D]],
    weights: &[f64],
) -> Result<(), CurveError> {
    let given = control_points.len();
    // Prevents overflow when counting for an absurd order.
    let sane = basis.order() <= MAX_CONTROL_POINTS
        && (1..=MAX_CONTROL_POINTS).contains(&basis.control_points());
    let fits = match basis {
        Basis::BSpline {
            degree,
            control_points,
            ..
        } => (1..control_points).contains(&degree),
        Basis::FeaturePoints { count } => count >= 2,
        _ => true,
    };
    if !sane || !fits {
        return Err(CurveError::Size { basis });
    }
    if given != basis.control_points() {
        return Err(CurveError::ControlPoints { basis, given });
    }
    let expected = match basis {
        Basis::RationalBezier { .. } => given,
        _ => 0,
    };
    if weights.len() != expected {
        return Err(CurveError::Weights {
            basis,
            given: weights.len(),
            expected,
        });
    }
    let finite = |point: &[f64; D]| point.iter().all(|c| c.is_finite());
    if let Some(index) = control_points.iter().position(|point| !finite(point)) {
        return Err(CurveError::NotFinite { index });
    }
    let usable = |weight: &f64| weight.is_finite() && *weight > 0.0;
    match weights.iter().position(|weight| !usable(weight)) {
        Some(index) => Err(CurveError::Weight {
            index,
            weight: weights[index],
        }),
        None => Ok(()),
    }
}

/// Checks that these are the clamped knots of a connected B-spline.
pub(crate) fn check_knots(
    degree: usize,
    control_points: usize,
    knots: &[f64],
) -> Result<(), CurveError> {
    let expected = control_points + degree + 1;
    if knots.len() != expected {
        return Err(CurveError::KnotCount {
            given: knots.len(),
            expected,
        });
    }
    let right = |index: usize| {
        let knot = knots[index];
        if index <= degree {
            knot == 0.0
        } else if index >= control_points {
            knot == 1.0
        } else {
            let inside = 0.0 < knot && knot < 1.0;
            inside && knot >= knots[index - 1] && knot > knots[index - degree]
        }
    };
    match (0..expected).find(|&index| !right(index)) {
        Some(index) => Err(CurveError::Knot {
            index,
            knot: knots[index],
            degree,
        }),
        None => Ok(()),
    }
}
