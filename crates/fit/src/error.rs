//! What can be wrong with a request, in sentences that say what to do instead.

use crate::arc_length::ArcLengthError;
use crate::basis::Basis;
use crate::fitter::MAX_COORDINATE_PX;
use crate::options::{MAX_POINTS, Solver};
use crate::weighted::WeightedError;

/// Why no [`Fitter`](crate::Fitter) can be made.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FitterError {
    /// A size of the basis is out of range.
    #[error("a curve cannot have {what} {given}: choose one from {low} to {high}")]
    Size {
        /// Which: "order", "degree", …
        what: &'static str,
        /// What was asked for.
        given: usize,
        /// The least allowed.
        low: usize,
        /// The most allowed.
        high: usize,
    },
    /// The number of points is not one that a centerline can have.
    #[error("a centerline cannot have {points} points: choose from 2 to {MAX_POINTS}")]
    Points {
        /// What was asked for.
        points: usize,
    },
    /// Fewer points than control points.
    #[error(
        "{points} points cannot fix {basis}: give at least {} points{}",
        basis.control_points(), or_choose(*.nearest)
    )]
    TooFewPoints {
        /// The points asked for.
        points: usize,
        /// The curve asked for.
        basis: Basis,
        /// The largest of its family that is allowed with so many points.
        nearest: Option<Basis>,
    },
    /// Rounding errors would drown the control points.
    #[error(
        "for {basis} with {points} points the condition number is {condition:.2e}, and {solver} gives \
         trustworthy control points only up to {limit:.1e}: choose {}{}",
        .nearest.map_or("a smaller one".to_owned(), |nearest| nearest.to_string()),
        if *.solver == Solver::Cholesky { ", or the solver pinv or qr" } else { "" }
    )]
    IllConditioned {
        /// The curve asked for.
        basis: Basis,
        /// The points asked for.
        points: usize,
        /// The solver asked for.
        solver: Solver,
        /// The 2-norm condition number of `B`.
        condition: f64,
        /// The highest that this solver is trusted with.
        limit: f64,
        /// The largest of the same family below that limit with as many points.
        nearest: Option<Basis>,
    },
    /// λ is negative or no number.
    #[error("invalid ridge {ridge}: it must be 0 or positive")]
    Ridge {
        /// What was asked for.
        ridge: f64,
    },
    /// An option that the basis has no use for.
    #[error("{basis} cannot be fitted with {option}: {why}")]
    Option {
        /// The curve asked for.
        basis: Basis,
        /// The option, as settings have it.
        option: &'static str,
        /// Why not, and what to do.
        why: &'static str,
    },
}

fn or_choose(nearest: Option<Basis>) -> String {
    nearest.map_or(String::new(), |nearest| format!(", or choose {nearest}"))
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
        "point {index} has the coordinate {value}, which is not a position in a picture: all must be finite and \
         below {MAX_COORDINATE_PX:e} px in size"
    )]
    NotAPoint {
        /// Which point, counted from 0.
        index: usize,
        /// Its first such coordinate.
        value: f64,
    },
    /// Weights were given to a fitter that was made for points that all count the same.
    #[error("this fitter takes no weights: make it with the option weights = Given or Robust")]
    NoWeights,
    /// Not as many weights as points.
    #[error("{given} weights were given for {expected} points: give one for each")]
    WeightCount {
        /// How many came.
        given: usize,
        /// How many points there are.
        expected: usize,
    },
    /// Points that do not determine the curve with these weights.
    #[error(transparent)]
    Weighted(#[from] WeightedError),
    /// Points along which no arc length can be measured.
    #[error(transparent)]
    ArcLength(#[from] ArcLengthError),
}
