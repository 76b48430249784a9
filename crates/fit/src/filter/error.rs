//! What can be wrong with what a filter is given, in sentences that say what to do instead.

use crate::options::{MAX_ORDER, MAX_POINTS};

/// Why there is no [`CurveSpace`](crate::CurveSpace).
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CurveSpaceError {
    /// No control points, or more than a descriptor can carry.
    #[error(
        "a curve cannot have {columns} control points: choose from 1 to {}",
        MAX_ORDER + 1
    )]
    ControlPoints {
        /// How many were asked for.
        columns: usize,
    },
    /// Fewer points than control points, or too many.
    #[error(
        "B has {rows} rows for {columns} control points: give a row for each point, {columns} to {MAX_POINTS} of them"
    )]
    Shape {
        /// The number of points.
        rows: usize,
        /// The number of control points.
        columns: usize,
    },
    /// A number is NaN or infinite.
    #[error("row {row} of B has no finite number in column {column}: give B as it is evaluated")]
    NotFinite {
        /// Which row, counted from 0.
        row: usize,
        /// Which column, counted from 0.
        column: usize,
    },
    /// The points hardly tell the control points apart.
    #[error(
        "the condition number of B is {condition:.2e}, and control points can only be trusted up to {limit:.1e}: choose fewer control points"
    )]
    IllConditioned {
        /// The 2-norm condition number.
        condition: f64,
        /// The highest that is taken.
        limit: f64,
    },
}

/// Why there is no [`Filter`](crate::Filter).
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FilterError {
    /// No control points, or more than a descriptor can carry.
    #[error(
        "a filter cannot be made for {given} control points: choose from 1 to {}",
        MAX_ORDER + 1
    )]
    ControlPoints {
        /// How many were asked for.
        given: usize,
    },
    /// An option outside its range.
    #[error("the filter's {name} cannot be {given}: choose from {least} to {most}")]
    Option {
        /// Which field of [`FilterOptions`](crate::FilterOptions).
        name: &'static str,
        /// What was asked for.
        given: f64,
        /// The least that is allowed.
        least: f64,
        /// The most that is allowed.
        most: f64,
    },
}

/// Why a shape was not taken in. The filter is then as it was before.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum UpdateError {
    /// The shape is of the moment of the last one, or of an earlier one.
    #[error(
        "a shape of {t_ns} ns cannot follow one of {last_ns} ns: give shapes in the order of their images, or call forget first"
    )]
    NotLater {
        /// The shape's moment.
        t_ns: u64,
        /// The moment of the shape before it.
        last_ns: u64,
    },
    /// Not as many control points as the space has.
    #[error("{given} control points were given for a space of curves that have {expected}")]
    Count {
        /// How many came.
        given: usize,
        /// How many the space has.
        expected: usize,
    },
    /// More control points than the filter was made for.
    #[error(
        "{given} control points were given to a filter made for at most {most}: make it for more"
    )]
    TooMany {
        /// How many came.
        given: usize,
        /// How many the filter was made for.
        most: usize,
    },
    /// A control point that is NaN, infinite or absurdly far away.
    #[error(
        "control point {index} is not a position: all its numbers must be finite and below {limit:e} px in size"
    )]
    NotAPoint {
        /// Which, counted from 0.
        index: usize,
        /// What its coordinates must be below.
        limit: f64,
    },
    /// A variance, or an entry of a covariance, that is NaN, infinite or absurdly large.
    #[error(
        "invalid variance or covariance {value} px²: all must be finite and at most {limit:e} px² in size, and variances not negative"
    )]
    NotAVariance {
        /// The number.
        value: f64,
        /// The largest that is taken.
        limit: f64,
    },
    /// A covariance of another size.
    #[error(
        "a covariance of {given} numbers was given for {control_points} control points: give all {} of its rows, one after the other",
        control_points * control_points
    )]
    CovarianceSize {
        /// How many numbers came.
        given: usize,
        /// How many control points there are.
        control_points: usize,
    },
    /// A matrix that is no covariance.
    #[error(
        "the covariance of the control points is not positive semidefinite: some combination of them would have a negative variance"
    )]
    NotPositive,
    /// A covariance whose small directions are lost in rounding.
    #[error(
        "at a condition number of {condition:.2e} a covariance has lost the curve's own precision (that is so from {limit:.1e} on): give Noise::Even, or choose fewer control points"
    )]
    LostInRounding {
        /// The condition number of the space.
        condition: f64,
        /// The highest at which a covariance can be taken.
        limit: f64,
    },
}

/// Why nothing can be said about a moment.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PredictError {
    /// No shape has been taken in yet.
    #[error("nothing can be predicted before the first shape: call update first")]
    NothingSeen,
    /// The moment is too far from the last shape.
    #[error(
        "{t_ns} ns is {distance_s:.3} s from the last shape, and predictions are made up to {limit_s} s: ask for a nearer moment, or raise longest_gap_s"
    )]
    TooFar {
        /// The moment asked for.
        t_ns: u64,
        /// How far it is from the last shape.
        distance_s: f64,
        /// The longest gap that is bridged.
        limit_s: f64,
    },
}
