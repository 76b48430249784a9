//! Errors of requests, in sentences that say what to do instead.

use crate::MAX_POINTS;

/// Why a [`Servo`](crate::Servo) could not be made, or a target was refused.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ServoError {
    /// An option is out of its range.
    #[error("{name} is {given}: choose from {least} to {most}")]
    Option {
        /// The option's name.
        name: &'static str,
        /// The requested value.
        given: f64,
        /// The minimum allowed.
        least: f64,
        /// The maximum allowed.
        most: f64,
    },
    /// The speed limits of all inputs are 0.
    #[error("every speed limit is 0, so that nothing can be moved: allow one coordinate to move")]
    NothingMoves,
    /// A workspace's minimum is not below its maximum.
    #[error(
        "the workspace of gripper {gripper} is empty along {axis}: its least must be below its most"
    )]
    Workspace {
        /// The gripper: 1 or 2.
        gripper: usize,
        /// The coordinate: `x`, `y` or `θ`; in 3-D `x`, `y`, `z`, `θ₁`, `θ₂` or `θ₃`.
        axis: &'static str,
    },
    /// The target is not a stack of points.
    #[error(
        "invalid target of {given} coordinates: give {of} of 1 to {MAX_POINTS} points",
        of = if *dimensions == 3 { "x, y and z" } else { "x and y" }
    )]
    TargetSize {
        /// Number of coordinates given.
        given: usize,
        /// Number of coordinates per point.
        dimensions: usize,
    },
    /// The target and the first target differ in the number of coordinates.
    #[error(
        "the target has {given} coordinates, and the servo was made for {expected}: make another servo"
    )]
    OtherTarget {
        /// Number of coordinates given.
        given: usize,
        /// Number of coordinates that the servo expects.
        expected: usize,
    },
    /// A coordinate of the target is not a number, or is too large.
    #[error("coordinate {index} of the target is {value}, which is not a position in a picture")]
    NotATarget {
        /// The coordinate's index, counted from 0.
        index: usize,
        /// Its value.
        value: f64,
    },
    /// The rows are not a Jacobian of the servo's shapes.
    #[error(
        "{given} rows make no Jacobian of {expected} coordinates: give a row of finite numbers for each coordinate"
    )]
    NotAJacobian {
        /// Number of rows given.
        given: usize,
        /// Number of coordinates of a shape.
        expected: usize,
    },
    /// The metric is for another number of points.
    #[error(
        "the metric is of {metric} points and the target has {target}: make it of the target's basis"
    )]
    OtherMetric {
        /// Number of points of the metric.
        metric: usize,
        /// Number of points of the target.
        target: usize,
    },
}

/// Why a [`Metric`](crate::Metric) could not be made from rows.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MetricError {
    /// There are no control points, or too many.
    #[error("a curve cannot have {count} control points here: choose from 1 to {MAX_POINTS}")]
    Count {
        /// Number of control points.
        count: usize,
    },
    /// Rows differ in length.
    #[error(
        "row {row} has {given} numbers and the first {expected}: give one for each control point"
    )]
    Row {
        /// The row's index, counted from 0.
        row: usize,
        /// Its length.
        given: usize,
        /// The length of the first row.
        expected: usize,
    },
    /// Different curves would have the distance 0, or a distance lost to rounding.
    #[error(
        "with these rows different control points can have the distance 0: give more points of the curve, or a lower order"
    )]
    Singular,
}
