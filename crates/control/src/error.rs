//! What can be wrong with a request, in sentences that say what to do instead.

use crate::MAX_POINTS;

/// Why no [`Servo`](crate::Servo) can be made, or no target taken.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ServoError {
    /// An option is out of its range.
    #[error("{name} is {given}: choose from {least} to {most}")]
    Option {
        /// Which.
        name: &'static str,
        /// What was asked for.
        given: f64,
        /// The least allowed.
        least: f64,
        /// The most allowed.
        most: f64,
    },
    /// No input may move.
    #[error("every speed limit is 0, so that nothing can be moved: allow one coordinate to move")]
    NothingMoves,
    /// A workspace whose least is not below its most.
    #[error(
        "the workspace of gripper {gripper} is empty along {axis}: its least must be below its most"
    )]
    Workspace {
        /// 1 or 2.
        gripper: usize,
        /// `x`, `y` or `θ`; in space `x`, `y`, `z`, `θ₁`, `θ₂` or `θ₃`.
        axis: &'static str,
    },
    /// The target is no stack of points.
    #[error(
        "invalid target of {given} coordinates: give {of} of 1 to {MAX_POINTS} points",
        of = if *dimensions == 3 { "x, y and z" } else { "x and y" }
    )]
    TargetSize {
        /// How many coordinates came.
        given: usize,
        /// How many a point has.
        dimensions: usize,
    },
    /// Another number of coordinates than that of the first target.
    #[error(
        "the target has {given} coordinates, and the servo was made for {expected}: make another servo"
    )]
    OtherTarget {
        /// How many came.
        given: usize,
        /// How many the servo takes.
        expected: usize,
    },
    /// A coordinate of the target is no number, or absurdly large.
    #[error("coordinate {index} of the target is {value}, which is not a position in a picture")]
    NotATarget {
        /// Which, counted from 0.
        index: usize,
        /// Its value.
        value: f64,
    },
    /// No Jacobian of such shapes.
    #[error(
        "{given} rows make no Jacobian of {expected} coordinates: give a row of finite numbers for each coordinate"
    )]
    NotAJacobian {
        /// How many rows came.
        given: usize,
        /// How many coordinates a shape has.
        expected: usize,
    },
    /// A metric for another number of points.
    #[error(
        "the metric is of {metric} points and the target has {target}: make it of the target's basis"
    )]
    OtherMetric {
        /// The metric's.
        metric: usize,
        /// The target's.
        target: usize,
    },
}

/// Why rows make no [`Metric`](crate::Metric).
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MetricError {
    /// No control points, or too many.
    #[error("a curve cannot have {count} control points here: choose from 1 to {MAX_POINTS}")]
    Count {
        /// How many there are.
        count: usize,
    },
    /// Rows of different lengths.
    #[error(
        "row {row} has {given} numbers and the first {expected}: give one for each control point"
    )]
    Row {
        /// Which, counted from 0.
        row: usize,
        /// Its length.
        given: usize,
        /// The first row's.
        expected: usize,
    },
    /// Curves that differ and have no distance, or none that rounding leaves.
    #[error(
        "with these rows different control points can have the distance 0: give more points of the curve, or a lower order"
    )]
    Singular,
}
