//! Errors of a filter, in sentences that say what to do instead.

use crate::options::{MAX_ORDER, MAX_POINTS};

/// Why a [`CurveSpace`](crate::CurveSpace) could not be created.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CurveSpaceError {
    /// There are no control points, or more than a descriptor can have.
    #[error(
        "a curve cannot have {columns} control points: choose from 1 to {}",
        MAX_ORDER + 1
    )]
    ControlPoints {
        /// The requested number.
        columns: usize,
    },
    /// There are fewer points than control points, or too many.
    #[error(
        "B has {rows} rows for {columns} control points: give a row for each point, {columns} to {MAX_POINTS} of them"
    )]
    Shape {
        /// Number of points.
        rows: usize,
        /// Number of control points.
        columns: usize,
    },
    /// A number is NaN or infinite.
    #[error("row {row} of B has no finite number in column {column}: give B as it is evaluated")]
    NotFinite {
        /// The row, counted from 0.
        row: usize,
        /// The column, counted from 0.
        column: usize,
    },
    /// The points hardly distinguish the control points.
    #[error(
        "the condition number of B is {condition:.2e}, and control points can only be trusted up to {limit:.1e}: choose fewer control points"
    )]
    IllConditioned {
        /// The 2-norm condition number.
        condition: f64,
        /// The limit.
        limit: f64,
    },
}

/// Why a [`Filter`](crate::Filter) could not be created.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FilterError {
    /// There are no control points, or more than a descriptor can have.
    #[error(
        "a filter cannot be made for {given} control points: choose from 1 to {}",
        MAX_ORDER + 1
    )]
    ControlPoints {
        /// The requested number.
        given: usize,
    },
    /// An option is out of its range.
    #[error("the filter's {name} cannot be {given}: choose from {least} to {most}")]
    Option {
        /// The field of [`FilterOptions`](crate::FilterOptions).
        name: &'static str,
        /// The requested value.
        given: f64,
        /// Minimum allowed.
        least: f64,
        /// Maximum allowed.
        most: f64,
    },
}

/// Why a shape was refused. The filter is then unchanged.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum UpdateError {
    /// The shape has the same time as the last one, or an earlier one.
    #[error(
        "a shape of {t_ns} ns cannot follow one of {last_ns} ns: give shapes in the order of their images, or call forget first"
    )]
    NotLater {
        /// Time of the shape.
        t_ns: u64,
        /// Time of the previous shape.
        last_ns: u64,
    },
    /// The number of control points does not match the space.
    #[error("{given} control points were given for a space of curves that have {expected}")]
    Count {
        /// Number of control points given.
        given: usize,
        /// Number of control points of the space.
        expected: usize,
    },
    /// There are more control points than the filter was made for.
    #[error(
        "{given} control points were given to a filter made for at most {most}: make it for more"
    )]
    TooMany {
        /// Number of control points given.
        given: usize,
        /// Number of control points that the filter was made for.
        most: usize,
    },
    /// A control point is NaN, infinite or too far away.
    #[error(
        "control point {index} is not a position: all its numbers must be finite and below {limit:e} px in size"
    )]
    NotAPoint {
        /// Index of the control point, counted from 0.
        index: usize,
        /// The limit of its coordinates.
        limit: f64,
    },
    /// A variance, or an entry of a covariance, is NaN, infinite or too large.
    #[error(
        "invalid variance or covariance {value} px²: all must be finite and at most {limit:e} px² in size, and variances not negative"
    )]
    NotAVariance {
        /// The number.
        value: f64,
        /// The limit.
        limit: f64,
    },
    /// A covariance has the wrong size.
    #[error(
        "a covariance of {given} numbers was given for {control_points} control points: give all {} of its rows, one after the other",
        control_points * control_points
    )]
    CovarianceSize {
        /// Number of entries given.
        given: usize,
        /// Number of control points.
        control_points: usize,
    },
    /// A matrix is not a covariance.
    #[error(
        "the covariance of the control points is not positive semidefinite: some combination of them would have a negative variance"
    )]
    NotPositive,
    /// The directions of small variance in a covariance are lost in rounding.
    #[error(
        "at a condition number of {condition:.2e} a covariance has lost the curve's own precision (that is so from {limit:.1e} on): give Noise::Even, or choose fewer control points"
    )]
    LostInRounding {
        /// Condition number of the space.
        condition: f64,
        /// The limit.
        limit: f64,
    },
}

/// Why a prediction was refused.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PredictError {
    /// There has been no shape yet.
    #[error("nothing can be predicted before the first shape: call update first")]
    NothingSeen,
    /// The time is too far from the last shape.
    #[error(
        "{t_ns} ns is {distance_s:.3} s from the last shape, and predictions are made up to {limit_s} s: ask for a nearer moment, or raise longest_gap_s"
    )]
    TooFar {
        /// The requested time.
        t_ns: u64,
        /// Its distance from the last shape.
        distance_s: f64,
        /// Maximum distance.
        limit_s: f64,
    },
}
