//! What can be wrong with a request, in sentences that say what to do instead.

use crate::fitter::MAX_COORDINATE_PX;
use crate::options::{MAX_ORDER, MAX_POINTS, Solver};

/// Why no [`Fitter`](crate::Fitter) can be made.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FitterError {
    /// The order is not one that a descriptor can carry.
    #[error("a curve cannot have order {order}: choose one from 1 to {MAX_ORDER}")]
    Order {
        /// What was asked for.
        order: usize,
    },
    /// The number of points is not one that a centerline can have.
    #[error("a centerline cannot have {points} points: choose from 2 to {MAX_POINTS}")]
    Points {
        /// What was asked for.
        points: usize,
    },
    /// Fewer points than control points.
    #[error(
        "{points} points cannot fix the {} control points of order {order}: give at least {} points, \
         or choose an order of at most {}",
        order + 1, order + 1, points - 1
    )]
    TooFewPoints {
        /// The points asked for.
        points: usize,
        /// The order asked for.
        order: usize,
    },
    /// Rounding errors would drown the control points.
    #[error(
        "at order {order} with {points} points the condition number is {condition:.2e}, and {solver} \
         gives trustworthy control points only up to {limit:.1e}: choose an order of at most \
         {highest_order}{}",
        if *.solver == Solver::Cholesky { ", or the solver pinv or qr" } else { "" }
    )]
    IllConditioned {
        /// The order asked for.
        order: usize,
        /// The points asked for.
        points: usize,
        /// The solver asked for.
        solver: Solver,
        /// The 2-norm condition number of `B`.
        condition: f64,
        /// The highest that this solver is trusted with.
        limit: f64,
        /// The highest order below that limit with as many points.
        highest_order: usize,
    },
}

/// Why these points have no fit.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FitError {
    /// Not the number of points that the fitter was made for.
    #[error(
        "{given} points were given to a fitter made for {expected}: resample the centerline, or make another fitter"
    )]
    Count {
        /// How many came.
        given: usize,
        /// How many the fitter takes.
        expected: usize,
    },
    /// A coordinate is NaN, infinite or absurdly large.
    #[error(
        "point {index} is ({x}, {y}), which is no place in a picture: both numbers must be finite and \
         below {MAX_COORDINATE_PX:e} px in size"
    )]
    NotAPoint {
        /// Which point, counted from 0.
        index: usize,
        /// Its x.
        x: f64,
        /// Its y.
        y: f64,
    },
}
