//! Errors of requests and points, in sentences that say what to do instead.

use crate::arc_length::ArcLengthError;
use crate::basis::Basis;
use crate::fitter::MAX_COORDINATE_PX;
use crate::options::{MAX_POINTS, Solver};
use crate::weighted::WeightedError;

/// Why a [`Fitter`](crate::Fitter) could not be created.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FitterError {
    /// A size of the basis is out of range.
    #[error("a curve cannot have {what} {given}: choose one from {low} to {high}")]
    Size {
        /// The size: "order", "degree", …
        what: &'static str,
        /// The requested number.
        given: usize,
        /// Minimum allowed.
        low: usize,
        /// Maximum allowed.
        high: usize,
    },
    /// The number of points is not valid for a centerline.
    #[error("a centerline cannot have {points} points: choose from 2 to {MAX_POINTS}")]
    Points {
        /// The requested number.
        points: usize,
    },
    /// There are fewer points than control points.
    #[error(
        "{points} points cannot fix {basis}: give at least {} points{}",
        basis.control_points(), or_choose(*.nearest)
    )]
    TooFewPoints {
        /// The requested number of points.
        points: usize,
        /// The requested curve.
        basis: Basis,
        /// The largest curve of its family that is allowed with this many points.
        nearest: Option<Basis>,
    },
    /// Rounding errors would dominate the control points.
    #[error(
        "for {basis} with {points} points the condition number is {condition:.2e}, and {solver} gives \
         trustworthy control points only up to {limit:.1e}: choose {}{}",
        .nearest.map_or("a smaller one".to_owned(), |nearest| nearest.to_string()),
        if *.solver == Solver::Cholesky { ", or the solver pinv or qr" } else { "" }
    )]
    IllConditioned {
        /// The requested curve.
        basis: Basis,
        /// The requested number of points.
        points: usize,
        /// The requested solver.
        solver: Solver,
        /// The 2-norm condition number of `B`.
        condition: f64,
        /// The solver's limit.
        limit: f64,
        /// The largest curve of the same family below that limit, with the same number of points.
        nearest: Option<Basis>,
    },
    /// λ is negative or not a number.
    #[error("invalid ridge {ridge}: it must be 0 or positive")]
    Ridge {
        /// The requested λ.
        ridge: f64,
    },
    /// An option does not apply to the basis.
    #[error("{basis} cannot be fitted with {option}: {why}")]
    Option {
        /// The requested curve.
        basis: Basis,
        /// Name of the option in the settings.
        option: &'static str,
        /// The reason, and what to do.
        why: &'static str,
    },
}

fn or_choose(nearest: Option<Basis>) -> String {
    nearest.map_or(String::new(), |nearest| format!(", or choose {nearest}"))
}

/// Why points could not be fitted.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FitError {
    /// The fitter was made for another number of points.
    #[error(
        "{given} points were given to a fitter made for {expected}: resample the centerline, or make another fitter"
    )]
    Count {
        /// Number of points given.
        given: usize,
        /// Number of points that the fitter expects.
        expected: usize,
    },
    /// A coordinate is NaN, infinite or too large.
    #[error(
        "point {index} has the coordinate {value}, which is not a position in a picture: all must be finite and \
         below {MAX_COORDINATE_PX:e} px in size"
    )]
    NotAPoint {
        /// Index of the point, counted from 0.
        index: usize,
        /// Its first such coordinate.
        value: f64,
    },
    /// Weights were given to a fitter whose points all count the same.
    #[error("this fitter takes no weights: make it with the option weights = Given or Robust")]
    NoWeights,
    /// The number of weights is not the number of points.
    #[error("{given} weights were given for {expected} points: give one for each")]
    WeightCount {
        /// Number of weights given.
        given: usize,
        /// Number of points.
        expected: usize,
    },
    /// The points do not determine the curve with these weights.
    #[error(transparent)]
    Weighted(#[from] WeightedError),
    /// No arc length can be measured along the points.
    #[error(transparent)]
    ArcLength(#[from] ArcLengthError),
}
